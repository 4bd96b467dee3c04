"""Quantisation of a record: steps of an encoder or of a converter."""

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.thresholds import MIN_STEP_DIFFERENCES
from axisid.support.arrays import Array

from .record import Record


def rounding(values: Array) -> float:
    """Return an upper bound of the rounding errors of floating-point values, in their unit."""
    return 8 * float(np.finfo(float).eps * np.abs(values).max(initial=0.0))


def quantisation_step(values: Array, fewest: int = 1) -> float:
    """Return the quantisation step of values, in their unit; 0 if they are not quantised.

    The step is the smallest difference of two values, if nearly all small differences are multiples
    of it. It is also 0 if fewer than `fewest` small differences can be compared.

    Parameters
    ----------
    values : (N,) array
    fewest : int
        Smallest number of differences below five steps that show a quantisation.
    """
    differences = np.diff(np.unique(values))
    differences = differences[differences > rounding(values)]
    least = float(differences.min(initial=np.inf))
    # Small differences in steps; larger multiples of a step are not distinguishable.
    multiples = differences[differences < 5 * least] / least
    is_whole = np.abs(multiples - np.round(multiples)) < 0.15  # values may be rounded to decimals
    enough = np.isfinite(least) and len(multiples) >= fewest
    return least if enough and np.mean(is_whole) > 0.9 else 0.0


# largest share of samples at which a rounded velocity changes; more changes show that noise of half
# a step or more averages the steps
_MAX_DITHERED_SHARE = 0.5


def position_step(record: Record) -> float:
    """Return the quantisation step of a recorded position, SI; 0 if it is not known."""
    if record.integrated:
        return 0.0
    return quantisation_step(record.position, int(MIN_STEP_DIFFERENCES.value))


def sensor_steps(axis: GeneratedAxis, record: Record) -> tuple[float, float]:
    """Return the quantisation steps of the position and of the measured velocity, SI.

    These are the steps of the values that the control law reads. Both are 0 without a law, or for a
    continuous law. A step is 0 if it is unknown. The step of the velocity is also 0 without a
    measured velocity, or if noise averages the steps.
    """
    law, velocity = axis.control, record.velocity
    if law is None or law.continuous:
        return 0.0, 0.0
    if velocity is None:
        return position_step(record), 0.0
    step = quantisation_step(velocity, int(MIN_STEP_DIFFERENCES.value))
    changing = np.abs(np.diff(velocity)) > step / 2
    return position_step(record), step * bool(np.mean(changing) <= _MAX_DITHERED_SHARE)
