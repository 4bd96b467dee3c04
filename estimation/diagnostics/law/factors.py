"""What stands between a recorded control and the terms of its law: factors, a constant, a shift."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.regression import Hac, factor, least_squares
from axisid.estimation.signals import Neighbours
from axisid.estimation.thresholds import MAX_SCALE_ERROR, MIN_DISTANCE_FROM_NOISE
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.errors import EstimationError

from .sentences import CONSTANT, DRIFT, MOST_SHIFT

# constant, or half of a drift, beside the law, by the control's root mean square
_MAX_CONTROL_LEAN = 0.01
# residual with a shift, by that without, up to which it is told
_MAX_EXPLAINED_RESIDUAL = 0.7

LAGS = 50  # samples over which what the law leaves may be alike


def fitted_factors(
    control: Array, terms: Array, names: list[str], neighbours: Neighbours
) -> tuple[dict[str, float], dict[str, float], float | None]:
    """A control fitted by the terms of its law, each with a factor.

    Factors and their HAC deviations by name, none where the terms cannot be told apart, and what
    the factors leave of the control, percent. A term that is always zero has no factor.
    """
    moving = np.any(terms != 0, axis=0)
    kept = [name for name, moves in zip(names, moving, strict=True) if moves]
    try:
        columns = factor(terms[:, moving], kept, neighbours=neighbours) if kept else None
    except EstimationError:
        columns = None
    if columns is None:
        return {}, {}, None
    fit = least_squares(control, columns)
    deviations = np.sqrt(np.diag(Hac(min(LAGS, len(control) // 4)).matrix(fit)))
    factors = dict(zip(kept, map(float, fit.theta), strict=True))
    unsure = dict(zip(kept, map(float, deviations), strict=True))
    return factors, unsure, relative_error_percent(fit.residuals, control)


def scaled_factors(
    factors: Mapping[str, float], deviations: Mapping[str, float]
) -> dict[str, float]:
    """Factors that are not 1, by more than 1 % and three of their deviations."""
    least, most = MAX_SCALE_ERROR.value, MIN_DISTANCE_FROM_NOISE.value
    return {
        name: factors[name]
        for name, deviation in deviations.items()
        if abs(factors[name] - 1) > max(least, most * deviation)
    }


def lean_of(
    left: Array,
    control: Array,
    neighbours: Neighbours,
    left_open: Array | tuple[float, float] = (0.0, 0.0),
) -> dict[str, float]:
    """A constant and a drift over the record that stand out of what the law leaves, by name.

    Parameters
    ----------
    left, control : (n,) array
    neighbours : Neighbours
    left_open : (2,) array_like
        How large either may be for what the log does not write.
    """
    values, deviations = leaning(left, neighbours)
    least = _MAX_CONTROL_LEAN * float(np.sqrt(np.mean(control**2))) * np.array([1.0, 2.0])
    far = np.maximum(least, MIN_DISTANCE_FROM_NOISE.value * deviations)
    return {
        name: float(value)
        for name, value, limit in zip(
            (CONSTANT, DRIFT), values, np.maximum(far, left_open), strict=True
        )
        if abs(value) > limit
    }


def leaning(left: Array, neighbours: Neighbours) -> tuple[Array, Array]:
    """Constant and drift of what is left, and their deviations, (2,) each."""
    half = neighbours.places - neighbours.places.mean()
    terms = np.column_stack([np.ones(len(left)), half / np.ptp(half)])
    fit = least_squares(left, factor(terms, (CONSTANT, DRIFT), neighbours=neighbours))
    lags = min(LAGS, len(left) // 4)
    return fit.theta, np.sqrt(np.diag(Hac(lags).matrix(fit)))


def best_shift(predicted: Array, control: Array, used: NDArray[np.bool_]) -> int:
    """Shift that explains the control clearly better than none, else 0."""
    rows = np.flatnonzero(used)
    rows = rows[(rows >= MOST_SHIFT) & (rows < len(control) - MOST_SHIFT)]
    errors = {
        shift: float(np.linalg.norm(control[rows] - predicted[rows - shift]))
        for shift in range(-MOST_SHIFT, MOST_SHIFT + 1)
    }
    best = min(errors, key=lambda shift: errors[shift])
    return best if errors[best] < _MAX_EXPLAINED_RESIDUAL * errors[0] else 0
