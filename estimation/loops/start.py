"""Where the loop of a record starts: its motion there, and what its drive remembers."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.estimation.records import Record
from axisid.estimation.signals import recorded_signals

from .as_logged import with_drive
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
    reference = np.asarray(record.commanded)
    signals = recorded_signals(axis, record.provenance.source, record.signals)
    return tuple(
        moved_start(axis, start, float(reference[row]), [float(v[row]) for v in signals], away)
        for (row, _), start in zip(record.spans, starts[axis], strict=True)
    )


def moved_start(
    axis: GeneratedAxis, start: LoopStart, reference: float, first: Sequence[float], away: float
) -> LoopStart:
    """A start whose law reads positions, and remembers them, so far from those of the axis.

    Parameters
    ----------
    axis : GeneratedAxis
    start : LoopStart
    reference : float
        The first.
    first : sequence of float
        The first of the recorded signals.
    away : float
    """
    if start.memory is None:
        return start
    at_rest, position = axis.functions["control_start"], start.position
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
    start = LoopStart(
        position=float(position[0]),
        velocity=velocity,
        memory=first_memory(axis, record, span),
    )
    return with_drive(axis, record, span, start)
