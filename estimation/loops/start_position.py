"""Where a record of velocity alone begins, beside its reference.

Its position is the velocity's integral, of which the first value is not known. The first controls
show it, as the law answers to the distance from the reference.
"""

from dataclasses import replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.records import Record
from axisid.estimation.simulation import law_of
from axisid.support.arrays import Array

from .as_logged import as_logged
from .law_run import control_along, state_at_rest
from .law_ticks import LawTicks, law_ticks
from .start_memory import unlimited
from .start_velocity import MIN_START_DISTANCE

_SAMPLES = 50  # of the segment that are looked at
_STEP = 1e-6  # of the reference's range, for the slope


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
