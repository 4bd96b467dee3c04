"""Quantisation of a record: counts of an encoder, steps of a converter."""

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.thresholds import MIN_STEP_DIFFERENCES
from axisid.support.arrays import Array

from .record import Record


def rounding(values: Array) -> float:
    """Return the floating-point rounding of the values."""
    return 8 * float(np.finfo(float).eps * np.abs(values).max(initial=0.0))


def quantisation_step(values: Array, fewest: int = 1) -> float:
    """Return the quantisation step: the least difference, if others are its multiples.

    Else 0, as where fewer than so many differences tell it.
    """
    differences = np.diff(np.unique(values))
    differences = differences[differences > rounding(values)]
    least = float(differences.min(initial=np.inf))
    few = differences[differences < 5 * least] / least  # larger ones do not tell
    whole = np.abs(few - np.round(few)) < 0.15  # as decimals leave them
    enough = np.isfinite(least) and len(few) >= fewest
    return least if enough and np.mean(whole) > 0.9 else 0.0


# of the samples change a rounded velocity; at a constant speed noise of half a step changes as
# many, and averages the steps
_MAX_DITHERED_SHARE = 0.5


def position_step(record: Record) -> float:
    """Return the quantisation step of a recorded position, SI; 0 if it is not known."""
    if record.integrated:
        return 0.0
    return quantisation_step(record.position, int(MIN_STEP_DIFFERENCES.value))


def sensor_steps(axis: GeneratedAxis, record: Record) -> tuple[float, float]:
    """Return the quantisation steps of position and measured velocity in a sampled law, SI.

    0 where nothing is known of them, or where noise averages the velocity's.
    """
    law, velocity = axis.control, record.velocity
    if law is None or law.continuous:
        return 0.0, 0.0
    if velocity is None:
        return position_step(record), 0.0
    step = quantisation_step(velocity, int(MIN_STEP_DIFFERENCES.value))
    changing = np.abs(np.diff(velocity)) > step / 2
    return position_step(record), step * bool(np.mean(changing) <= _MAX_DITHERED_SHARE)
