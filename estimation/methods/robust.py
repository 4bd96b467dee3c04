"""Least squares that few large residuals do not lead: M-estimates by reweighted rows.

A reversal that the filter rounds, a shock, a bad contact: rows whose residual is no noise of the
others. Their squares lead least squares; here a row counts for less the larger its residual is, in
deviations by the median, and with the bisquare not at all from 4.7 on. Both are 95 % as precise as
least squares where the noise is normal.

References
----------
[Huber1981]_; [BeatonTukey1974]_ for the bisquare; [HollandWelsch1977]_ for the iteration.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from axisid.estimation.choices.methods import BISQUARE_LOSS, HUBER_LOSS, SQUARES_LOSS
from axisid.estimation.regression import Form, QrFactors, Solution, least_squares
from axisid.estimation.thresholds.estimates import (
    BISQUARE_TUNING,
    HUBER_TUNING,
    LIGHT_ROW,
    MEDIAN_OF_NORMAL,
)
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
    start : str
        The loss whose estimate it is iterated from, empty for least squares; one that forgets large
        residuals has several valleys.
    """

    weight: Callable[[Array], Array]
    slope: Callable[[Array], Array]
    start: str = ""


_HUBER, _BISQUARE = HUBER_TUNING.value, BISQUARE_TUNING.value


def _huber_weight(u: Array) -> Array:
    return np.minimum(1.0, _HUBER / np.maximum(np.abs(u), _HUBER))


def _huber_slope(u: Array) -> Array:
    return (np.abs(u) <= _HUBER).astype(float)


def _bisquare_weight(u: Array) -> Array:
    return np.maximum(1 - (u / _BISQUARE) ** 2, 0.0) ** 2


def _bisquare_slope(u: Array) -> Array:
    inside = np.maximum(1 - (u / _BISQUARE) ** 2, 0.0)
    return inside * (inside - 4 * (u / _BISQUARE) ** 2)


ROW_LOSSES: Mapping[str, RowLoss] = MappingProxyType(
    {
        HUBER_LOSS: RowLoss(_huber_weight, _huber_slope),
        BISQUARE_LOSS: RowLoss(_bisquare_weight, _bisquare_slope, start=HUBER_LOSS),
    }
)


def robust_least_squares(y: Array, X: QrFactors, loss: str) -> Solution:
    """``argmin sum rho((y - X theta)/s)`` with s from the median of the residuals' sizes.

    The influence is that of the estimate's own equations, ``psi(u) X (X' diag(psi') X)^-1`` over
    the residuals, so that every covariance of it is the sandwich that is consistent for it.

    Parameters
    ----------
    y : (n,) array
    X : QrFactors
    loss : str
        Of `ROW_LOSSES`, or another for least squares.

    Raises
    ------
    EstimationError
        It does not stand still, or what keeps its weight does not tell the parameters apart.
    """
    plain = least_squares(y, X)
    if loss not in ROW_LOSSES or _scale(plain.residuals) <= _ROUNDING * np.linalg.norm(y):
        return plain
    return _with_influence(_iterated(y, X, plain, loss), X, loss)


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
    if solution.loss_weights is None:
        return [f"the {loss} loss is not of this method, or its rows are exact: all count alike"]
    light = np.count_nonzero(solution.loss_weights < LIGHT_ROW.value)
    least = float(solution.loss_weights.min())
    return [
        f"{loss} loss: {light} of {len(solution.loss_weights)} rows count for less than half, "
        f"the least by {least:.2g}"
    ]


def _iterated(y: Array, X: QrFactors, plain: Solution, loss: str) -> Solution:
    rule = ROW_LOSSES[loss]
    found = _iterated(y, X, plain, rule.start) if rule.start else plain
    scaled = X.columns / X.scale
    for _ in range(_MOST):
        weights = rule.weight(found.residuals / _scale(found.residuals))
        root = np.sqrt(weights)
        theta = np.linalg.lstsq(root[:, None] * scaled, root * y)[0] / X.scale
        moved = np.linalg.norm((theta - found.theta) * X.scale)
        found = replace(found, theta=theta, residuals=y - X.columns @ theta)
        if moved <= _STANDS_STILL * np.linalg.norm(theta * X.scale):
            return found
    raise EstimationError(
        f"the {loss} estimate still moves after {_MOST} iterations; use least squares, and look at "
        "what the residuals are.",
        code="loss-moves",
    )


def _with_influence(found: Solution, X: QrFactors, loss: str) -> Solution:
    u = found.residuals / _scale(found.residuals)
    weights, slopes = ROW_LOSSES[loss].weight(u), ROW_LOSSES[loss].slope(u)
    basis = X.basis.astype(float)
    try:
        hessian = np.linalg.inv(basis.T @ (slopes[:, None] * basis))
    except np.linalg.LinAlgError as error:
        raise _untold(loss, X) from error
    if not np.all(np.linalg.eigvalsh(hessian) > 0):
        raise _untold(loss, X)
    inverse = X.inverse.astype(float)
    counted = weights * found.residuals
    spread = np.linalg.norm(counted) / np.linalg.norm(found.residuals) / slopes.mean()
    return replace(
        found,
        influence=weights[:, None] * (basis @ hessian @ inverse.T),
        # Of independent residuals: ``E psi^2 / (E psi')^2 (X'X)^-1``.
        inverse_factor=spread * inverse,
        loss_weights=weights,
    )


def _untold(loss: str, X: QrFactors) -> EstimationError:
    return EstimationError(
        f"with the {loss} loss the rows that keep their weight do not tell "
        f"{', '.join(X.names)} apart; use least squares.",
        code="loss-tells-nothing",
    )


def _scale(residuals: Array) -> float:
    """Deviation of normal residuals with this median size."""
    return float(np.median(np.abs(residuals))) / MEDIAN_OF_NORMAL.value
