"""The velocity with which a record begins.

A parabola is fitted to its first positions, and its slope at the first sample taken. Many samples
average the noise, few follow the motion: samples are added as long as the slope stays within what
noise leaves open of every shorter fit, as [Lepskii1991]_ chooses a bandwidth. How much noise there
is shows in differences of fourth order, in which no motion of a drive is left.
"""

import math

import numpy as np

from axisid.estimation.thresholds.simulation import MIN_START_DISTANCE, START_AGREEMENT
from axisid.support.arrays import Array

_DEGREE = 2
_COUNTS = (6, 8, 10, 12, 16, 20, 24, 32, 40, 48, 64, 80, 96, 128, 160, 192, 256)  # samples
_ORDER, _NOISE = 4, 200  # of the differences that show noise, and samples that they are taken of


def first_velocity(position: Array, period: float) -> float:
    """Velocity at the first of positions, 0 for an axis that rests there.

    Parameters
    ----------
    position : (N,) array
        Measured, of one stretch.
    period : float
        s

    Returns
    -------
    float
        0 where half the samples have a slope within `MIN_START_DISTANCE` deviations of it: a rest
        that ends soon bends the whole fit before it shows.

    Notes
    -----
    On twins of the library, cut where they move, it is right to 0.03 to 0.9 % of the greatest speed
    (root mean square); none of 540 starts at rest was taken for a motion.
    """
    noise = position_noise(position)
    low, high, velocity, used = -math.inf, math.inf, 0.0, 0
    for count in _COUNTS:
        if count > len(position):
            break
        slope, deviation = _slope(position[:count], noise)
        low = max(low, slope - START_AGREEMENT.value * deviation)
        high = min(high, slope + START_AGREEMENT.value * deviation)
        if low > high:
            break
        velocity, used = slope, count
    if not used:
        return 0.0
    slope, deviation = _slope(position[: max(used // 2, _DEGREE + 2)], noise)
    return velocity / period if abs(slope) > MIN_START_DISTANCE.value * deviation else 0.0


def position_noise(position: Array) -> float:
    """Deviation of the noise of measured positions, (N,), from those at the start."""
    some = position[:_NOISE]
    order = min(_ORDER, len(some) - 1)
    return float(np.sqrt(np.mean(np.diff(some, order) ** 2) / math.comb(2 * order, order)))


def _slope(position: Array, noise: float) -> tuple[float, float]:
    """Slope of a parabola at its first sample, and its deviation, a sample."""
    count = len(position)
    powers = (np.arange(count) / count)[:, None] ** np.arange(_DEGREE + 1)
    weights = np.linalg.pinv(powers)[1] / count
    return float(weights @ (position - position[0])), noise * float(np.linalg.norm(weights))
