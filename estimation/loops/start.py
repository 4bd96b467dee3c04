"""Where the loop of a record starts: its motion there, and what its drive remembers."""

from dataclasses import replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.estimation.records import Record
from axisid.estimation.signals import recorded_signals

from .kept import KeptByRecord
from .start_memory import first_memory
from .start_position import placed
from .start_velocity import first_value, first_velocity

_KNOWN: KeptByRecord[GeneratedAxis, tuple[LoopStart, ...]] = KeptByRecord()


def loop_starts(axis: GeneratedAxis, record: Record, away: float = 0.0) -> tuple[LoopStart, ...]:
    """Where the loop of each segment of a record starts.

    Parameters
    ----------
    axis : GeneratedAxis
        With a control law.
    record : Record
        With a reference.
    away : float
        Of the positions that the law reads, from those of the record; what it remembers of them is
        as far away.
    """
    starts = _KNOWN.of(record)
    if axis not in starts:
        starts[axis] = tuple(_start(axis, record, span) for span in record.spans)
    if not away:
        return starts[axis]
    return tuple(
        _moved(axis, record, row, start, away)
        for (row, _), start in zip(record.spans, starts[axis], strict=True)
    )


def _moved(
    axis: GeneratedAxis, record: Record, row: int, start: LoopStart, away: float
) -> LoopStart:
    if start.memory is None:
        return start
    at_rest = axis.functions["control_start"]
    reference, position = np.asarray(record.commanded)[row], start.position
    signals = recorded_signals(axis, record.provenance.source, record.signals)
    first = [values[row] for values in signals]
    change = at_rest(reference + away, position + away, *first)
    change -= at_rest(reference, position, *first)
    return replace(start, memory=start.memory + change.full().ravel())


def _start(axis: GeneratedAxis, record: Record, span: tuple[int, int]) -> LoopStart:
    record, rows = placed(axis, record, span), slice(*span)
    position = record.position[rows]
    if record.integrated:
        velocity = first_value(np.asarray(record.velocity)[rows])
    else:
        velocity = first_velocity(position, record.period)
    return LoopStart(
        position=float(position[0]),
        velocity=velocity,
        memory=first_memory(axis, record, span),
    )
