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


_HUBER, _BISQUARE = HUBER_TUNING.value, BISQUARE_TUNING.value
#: Of residuals by their size in deviations, (n,): ``psi(u) / u``, which is 1 for a small one,
#: ``psi'(u)``, and ``rho(u)``, which is ``u^2/2`` for a small one.
RowLoss = Callable[[Array], tuple[Array, Array, Array]]


def _huber(u: Array) -> tuple[Array, Array, Array]:
    size = np.abs(u)
    near = np.minimum(size, _HUBER)
    weight = _HUBER / np.maximum(size, _HUBER)
    return weight, (size <= _HUBER).astype(float), near**2 / 2 + _HUBER * (size - near)


def _bisquare(u: Array) -> tuple[Array, Array, Array]:
    share = (u / _BISQUARE) ** 2
    inside = np.maximum(1 - share, 0.0)
    return inside**2, inside * (inside - 4 * share), _BISQUARE**2 / 6 * (1 - inside**3)


ROW_LOSSES: Mapping[str, RowLoss] = MappingProxyType({HUBER_LOSS: _huber, BISQUARE_LOSS: _bisquare})
#: The loss whose estimate another is iterated from, instead of least squares: one that forgets
#: large residuals has several valleys.
_STARTS = {BISQUARE_LOSS: HUBER_LOSS}


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
    return scale * math.sqrt(2 * float(np.sum(ROW_LOSSES[loss](residuals / scale)[2])))


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
    found = _iterated(y, X, Z, first, _STARTS[loss]) if loss in _STARTS else first
    for _ in range(_MOST):
        weights, slopes, _ = ROW_LOSSES[loss](found.residuals / scale_of(found.residuals))
        before = found.theta
        found = as_counted(y, X, Z, RowCounts(weights=weights, slopes=slopes))
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
