"""Initial velocity of a record, and the noise of its positions.

The velocity is the slope at the first sample of a parabola that is fitted to the first positions.
Many samples average the noise, few samples follow the motion: samples are added as long as the
slope stays within the confidence intervals of all shorter fits, as in [Lepskii1991]_ for a
bandwidth. The noise level follows from differences of fourth order, in which the motion of a drive
is negligible.
"""

import math
from functools import lru_cache

import numpy as np

from axisid.support.arrays import Array, frozen

# half width of a confidence interval in standard errors; of 1.5 and 2.5 the value with the smaller
# velocity errors on twins of the library
_START_AGREEMENT = 2.5
# distance from rest in standard errors from which a record begins in motion; 540 starts at rest
# reach 4.1
MIN_START_DISTANCE = 5.0

_DEGREE = 2
_COUNTS = (6, 8, 10, 12, 16, 20, 24, 32, 40, 48, 64, 80, 96, 128, 160, 192, 256)  # samples
_ORDER, _NOISE = 4, 200  # order of the differences for the noise, and number of samples


def first_velocity(position: Array, period: float) -> float:
    """Return the velocity at the first position, 0 for an axis at rest.

    Parameters
    ----------
    position : (N,) array
        Measured positions of one stretch.
    period : float
        Sampling period, s.

    Returns
    -------
    float
        Velocity; 0 if the slope over the first half of the fitted samples is within
        `MIN_START_DISTANCE` standard errors of 0. A rest that ends soon changes the fit to all
        samples before the motion is visible in the first half.

    Notes
    -----
    On twins of the library, cut during motion, its error is 0.03 to 0.9 % of the largest speed
    (root mean square); none of 540 starts at rest was taken for a motion.
    """
    used = position[: max(_COUNTS[-1], _NOISE)]
    return first_coefficient(used - used[0], degree=_DEGREE, power=1) / period


def first_coefficient(values: Array, *, degree: int, power: int) -> float:
    """Return a coefficient of the polynomial fitted to the first values; 0 if not significant.

    More and more values are fitted, as long as the coefficient stays within the confidence
    intervals of all shorter fits. It is significant if it differs from 0 in the first half of these
    values by more than `MIN_START_DISTANCE` standard errors.

    Parameters
    ----------
    values : (N,) array
        Values from the first sample on, with white noise.
    degree : int
        Degree of the polynomial in the number of samples since the first.
    power : int
        Power of the sample number whose coefficient is returned, in the unit of the values.
    """
    # Intersect the confidence intervals of fits to more and more values.
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
    # Significance in the first half of the values.
    half = values[: max(used // 2, degree + 2)]
    fitted, deviation = _coefficient(half, noise, degree, power)
    return found if abs(fitted) > MIN_START_DISTANCE * deviation else 0.0


def position_noise(position: Array) -> float:
    """Return the standard deviation of the white noise of positions, (N,), in their unit.

    It is the root of ``mean d^2 / C(2k, k)`` of the differences d of order k = 4, of the first 200
    positions.
    """
    used = position[:_NOISE]
    order = min(_ORDER, len(used) - 1)
    return float(np.sqrt(np.mean(np.diff(used, order) ** 2) / math.comb(2 * order, order)))


def _coefficient(values: Array, noise: float, degree: int, power: int) -> tuple[float, float]:
    """Return a least-squares coefficient of a polynomial in the samples, and its standard error.

    `noise` is the standard deviation of the values.
    """
    weights, size = _weights(len(values), degree, power)
    return float(weights @ values), noise * size


@lru_cache(maxsize=128)
def _weights(count: int, degree: int, power: int) -> tuple[Array, float]:
    """Return the weights of the values in a coefficient, (count,), and their norm."""
    powers = (np.arange(count) / count)[:, None] ** np.arange(degree + 1)
    weights = frozen(np.linalg.pinv(powers)[power] / count**power)
    return weights, float(np.linalg.norm(weights))
