"""Where the loop of a record starts: its motion there, and what its drive remembers."""

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.estimation.records import Record

from .law_ticks import law_ticks
from .start_memory import first_memory
from .start_velocity import first_velocity


def loop_starts(axis: GeneratedAxis, record: Record) -> tuple[LoopStart, ...]:
    """Where the loop of each segment of a record starts.

    Parameters
    ----------
    axis : GeneratedAxis
        With a control law.
    record : Record
        With a reference.
    """
    kept: dict[GeneratedAxis, tuple[LoopStart, ...]] = vars(record).setdefault("_loop_starts", {})
    if axis not in kept:  # it is asked for in every iteration
        kept[axis] = tuple(_start(axis, record, span) for span in record.spans)
    return kept[axis]


def _start(axis: GeneratedAxis, record: Record, span: tuple[int, int]) -> LoopStart:
    position = record.position[slice(*span)]
    return LoopStart(
        position=float(position[0]),
        velocity=first_velocity(position, record.period),
        memory=first_memory(axis, record, span, law_ticks(axis, record, span)),
    )
