"""Least squares that few large residuals do not lead: M-estimates by reweighted rows.

A reversal that the filter rounds, a shock, a bad contact: rows whose residual is no noise of the
others. Their squares lead least squares; here a row counts for less the larger its residual is, in
deviations by the median, and with the bisquare not at all from 4.7 on. Both are 95 % as precise as
least squares where the noise is normal.

References
----------
[Huber1981]_; [BeatonTukey1974]_ for the bisquare; [HollandWelsch1977]_ for the iteration.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from axisid.estimation.choices import BISQUARE_LOSS, HUBER_LOSS, SQUARES_LOSS
from axisid.estimation.regression import (
    Columns,
    Form,
    QrFactors,
    RowCounts,
    Solution,
    as_counted,
    least_squares,
)
from axisid.estimation.thresholds import BISQUARE_TUNING, HUBER_TUNING, LIGHT_ROW, MEDIAN_OF_NORMAL
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError, ModelError
from axisid.support.remedy import Remedy, Setting

_MOST, _STANDS_STILL = 200, 1e-10
#: Rows whose residuals are rounding alone have no scale.
_ROUNDING = 1e-13


@dataclass(frozen=True, slots=True)
class RowLoss:
    """What residuals count by, from their size in deviations, (n,).

    Attributes
    ----------
    weight : callable
        ``psi(u) / u``, 1 for a small residual.
    slope : callable
        ``psi'(u)``.
    size : callable
        ``rho(u)``, ``u^2/2`` for a small residual.
    start : str
        The loss whose estimate it is iterated from, empty for least squares; one that forgets large
        residuals has several valleys.
    """

    weight: Callable[[Array], Array]
    slope: Callable[[Array], Array]
    size: Callable[[Array], Array]
    start: str = ""


_HUBER, _BISQUARE = HUBER_TUNING.value, BISQUARE_TUNING.value


def _huber_weight(u: Array) -> Array:
    return np.minimum(1.0, _HUBER / np.maximum(np.abs(u), _HUBER))


def _huber_slope(u: Array) -> Array:
    return (np.abs(u) <= _HUBER).astype(float)


def _huber_size(u: Array) -> Array:
    far = np.maximum(np.abs(u) - _HUBER, 0.0)
    return np.asarray(np.minimum(np.abs(u), _HUBER) ** 2 / 2 + _HUBER * far)


def _bisquare_weight(u: Array) -> Array:
    return np.maximum(1 - (u / _BISQUARE) ** 2, 0.0) ** 2


def _bisquare_slope(u: Array) -> Array:
    inside = np.maximum(1 - (u / _BISQUARE) ** 2, 0.0)
    return inside * (inside - 4 * (u / _BISQUARE) ** 2)


def _bisquare_size(u: Array) -> Array:
    inside = np.maximum(1 - (u / _BISQUARE) ** 2, 0.0)
    return np.asarray(_BISQUARE**2 / 6 * (1 - inside**3))


ROW_LOSSES: Mapping[str, RowLoss] = MappingProxyType(
    {
        HUBER_LOSS: RowLoss(_huber_weight, _huber_slope, _huber_size),
        BISQUARE_LOSS: RowLoss(_bisquare_weight, _bisquare_slope, _bisquare_size, start=HUBER_LOSS),
    }
)


def robust_solution(y: Array, X: Columns, Z: QrFactors, loss: str, plain: Solution) -> Solution:
    """The solution of ``sum psi(e_i/s) z_i = 0`` with s from the median of the residuals' sizes.

    Of least squares Z is X. The influence is that of these equations, ``Z (X' diag(psi') Z)^-1`` of
    residuals as they count, so that every covariance of it is the sandwich that is consistent.

    Parameters
    ----------
    y : (n,) array
    X : Columns
    Z : QrFactors
    loss : str
        Of `ROW_LOSSES`, or another for squares.
    plain : Solution
        By squares.

    Raises
    ------
    EstimationError
        It does not stand still, or what counts of the rows does not tell the parameters apart.
    """
    if loss not in ROW_LOSSES or scale_of(plain.residuals) <= _ROUNDING * np.linalg.norm(y):
        return plain
    return _iterated(y, X, Z, plain, loss)


def robust_least_squares(y: Array, X: QrFactors, loss: str) -> Solution:
    """`robust_solution` of least squares."""
    return robust_solution(y, X, X, loss, least_squares(y, X))


def size_by_loss(residuals: Array, scale: float, loss: str) -> float:
    """What a loss makes of residuals, (n,), in their unit: their norm, if it is of squares."""
    if loss not in ROW_LOSSES or not scale > 0:
        return float(np.linalg.norm(residuals))
    return scale * math.sqrt(2 * float(np.sum(ROW_LOSSES[loss].size(residuals / scale))))


def check_loss(loss: str, form: Form) -> None:
    """Refuse a loss for a model whose parameters are searched for by squares.

    Raises
    ------
    ModelError
        The model is not linear, and the loss is not of squares.
    """
    if loss in ROW_LOSSES and not form.is_linear:
        raise ModelError(
            f"the {loss} loss is of models that are linear in their parameters, and axis "
            f"{form.axis.axis.name!r} is not; ",
            Remedy.of("use ", Setting("loss", SQUARES_LOSS), ", or fit the control with a loss."),
            code="loss-of-nonlinear",
        )


def loss_remarks(loss: str, solution: Solution) -> list[str]:
    """What a loss did to the rows, in words; nothing of squares."""
    if loss not in ROW_LOSSES:
        return []
    if solution.counts is None:
        return [f"{loss} loss: the rows are exact to rounding, and all count alike"]
    weights = solution.counts.weights
    light, least = np.count_nonzero(weights < LIGHT_ROW.value), float(weights.min())
    return [
        f"{loss} loss: {light} of {len(weights)} rows count for less than half, "
        f"the least by {least:.2g}"
    ]


def _iterated(y: Array, X: Columns, Z: QrFactors, first: Solution, loss: str) -> Solution:
    rule = ROW_LOSSES[loss]
    found = _iterated(y, X, Z, first, rule.start) if rule.start else first
    for _ in range(_MOST):
        u = found.residuals / scale_of(found.residuals)
        before = found.theta
        found = as_counted(y, X, Z, RowCounts(weights=rule.weight(u), slopes=rule.slope(u)))
        moved = np.linalg.norm((found.theta - before) * X.scale)
        if moved <= _STANDS_STILL * np.linalg.norm(before * X.scale):
            return found
    raise EstimationError(
        f"the {loss} estimate still moves after {_MOST} iterations; use least squares, and look at "
        "what the residuals are.",
        code="loss-moves",
    )


def scale_of(residuals: Array) -> float:
    """Deviation of normal residuals with this median size."""
    return float(np.median(np.abs(residuals))) / MEDIAN_OF_NORMAL.value
