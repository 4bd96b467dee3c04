"""Where the loop of a record starts: its motion there, and what its drive remembers."""

import weakref
from functools import partial

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.estimation.records import Record

from .start_memory import first_memory
from .start_velocity import first_velocity

_Starts = dict[GeneratedAxis, tuple[LoopStart, ...]]

#: Those of the records that are alive, by their identity: they are asked for in every iteration.
_KNOWN: dict[int, tuple["weakref.ref[Record]", _Starts]] = {}


def loop_starts(axis: GeneratedAxis, record: Record) -> tuple[LoopStart, ...]:
    """Where the loop of each segment of a record starts.

    Parameters
    ----------
    axis : GeneratedAxis
        With a control law.
    record : Record
        With a reference.
    """
    of_record = _KNOWN.get(id(record))
    if of_record is None:
        kept = weakref.ref(record, partial(_forget, id(record)))
        of_record = _KNOWN[id(record)] = (kept, {})
    starts = of_record[1]
    if axis not in starts:
        starts[axis] = tuple(_start(axis, record, span) for span in record.spans)
    return starts[axis]


def _forget(record: int, _: object) -> None:
    _KNOWN.pop(record, None)


def _start(axis: GeneratedAxis, record: Record, span: tuple[int, int]) -> LoopStart:
    position = record.position[slice(*span)]
    return LoopStart(
        position=float(position[0]),
        velocity=first_velocity(position, record.period),
        memory=first_memory(axis, record, span),
    )
