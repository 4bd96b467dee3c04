"""Where the loop of a record starts: its motion there, and what its drive remembers."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.estimation.records import Record
from axisid.estimation.signals import recorded_signals
from axisid.estimation.simulation import law_of
from axisid.support.arrays import Array

from .as_logged import as_logged, with_drive
from .kept import KeptByRecord
from .law_run import control_along, state_at_rest
from .law_ticks import LawTicks, law_ticks
from .start_memory import first_memory, unlimited
from .start_velocity import MIN_START_DISTANCE, first_value, first_velocity

_KNOWN: KeptByRecord[GeneratedAxis, tuple[LoopStart, ...]] = KeptByRecord()

_SAMPLES = 50  # of the segment that are looked at
_STEP = 1e-6  # of the reference's range, for the slope


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


def placed(axis: GeneratedAxis, record: Record, span: tuple[int, int]) -> Record:
    """The record with its position as far from the reference as its first controls say.

    Parameters
    ----------
    axis : GeneratedAxis
        With a control law.
    record : Record
        With a reference.
    span : tuple of int
        The segment: first row and the one after the last.
    """
    if not record.integrated or record.control is None:
        return record
    away = _away(axis, record, span)
    return replace(record, position=record.position + away) if away else record


def _away(axis: GeneratedAxis, record: Record, span: tuple[int, int]) -> float:
    """By how much the position is to be moved; 0 where the controls do not show it."""
    law, control = law_of(axis), np.asarray(record.control)[slice(*span)]
    ticks = law_ticks(axis, record, span).first(_SAMPLES)
    seen = unlimited(axis, record, span)[: len(ticks.held)]
    wanted = control[: len(ticks.held)] - as_logged(axis, ticks.added_at_samples(law.delay))
    step = _STEP * float(np.ptp(np.asarray(record.reference))) or _STEP
    given, moved = (_control(axis, ticks, away) for away in (0.0, step))
    slope, off = ((moved - given) / step)[seen], (wanted - given)[seen]
    power = float(slope @ slope)
    if not (np.isfinite(power) and power > 0 and np.all(np.isfinite(off))):
        return 0.0
    away = float(slope @ off) / power
    left = off - away * slope
    deviation = float(np.sqrt(left @ left / max(len(off) - 1, 1) / power))
    return away if abs(away) > MIN_START_DISTANCE * deviation else 0.0


def _control(axis: GeneratedAxis, ticks: LawTicks, away: float) -> Array:
    """What the law gives for positions that are so far from those that were integrated."""
    there = replace(ticks, position=ticks.position + away)
    return control_along(axis, there, state_at_rest(axis, there))
