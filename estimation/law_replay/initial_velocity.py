"""The velocity with which a record begins, and the noise of its positions.

A parabola is fitted to the first positions, and its slope at the first sample taken. Many samples
average the noise, few follow the motion: samples are added as long as the slope stays within what
noise leaves open of every shorter fit, as [Lepskii1991]_ chooses a bandwidth. How much noise there
is shows in differences of fourth order, in which no motion of a drive is left.
"""

import math
from functools import lru_cache

import numpy as np

from axisid.support.arrays import Array, frozen

# deviations; of 1.5 and 2.5 the one whose velocities err less on twins of the library
_START_AGREEMENT = 2.5
# deviations from rest, from which a record begins otherwise; 540 starts at rest reach 4.1
MIN_START_DISTANCE = 5.0

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
    some = position[: max(_COUNTS[-1], _NOISE)]
    return first_coefficient(some - some[0], degree=_DEGREE, power=1) / period


def first_coefficient(values: Array, *, degree: int, power: int) -> float:
    """A coefficient of the polynomial that the first values follow, a sample; 0 by chance."""
    noise = position_noise(values)
    low, high, found, used = -math.inf, math.inf, 0.0, 0
    for count in [each for each in _COUNTS if each <= len(values)]:
        fitted, deviation = _coefficient(values[:count], noise, degree, power)
        low = max(low, fitted - _START_AGREEMENT * deviation)
        high = min(high, fitted + _START_AGREEMENT * deviation)
        if low > high:
            break
        found, used = fitted, count
    if not used:
        return 0.0
    some = values[: max(used // 2, degree + 2)]
    fitted, deviation = _coefficient(some, noise, degree, power)
    return found if abs(fitted) > MIN_START_DISTANCE * deviation else 0.0


def position_noise(position: Array) -> float:
    """Deviation of the noise of measured positions, (N,), from those at the start."""
    some = position[:_NOISE]
    order = min(_ORDER, len(some) - 1)
    return float(np.sqrt(np.mean(np.diff(some, order) ** 2) / math.comb(2 * order, order)))


def _coefficient(values: Array, noise: float, degree: int, power: int) -> tuple[float, float]:
    weights, size = _weights(len(values), degree, power)
    return float(weights @ values), noise * size


@lru_cache(maxsize=128)
def _weights(count: int, degree: int, power: int) -> tuple[Array, float]:
    """Of so many values in a coefficient, and the root of their squares' sum."""
    powers = (np.arange(count) / count)[:, None] ** np.arange(degree + 1)
    weights = frozen(np.linalg.pinv(powers)[power] / count**power)
    return weights, float(np.linalg.norm(weights))
