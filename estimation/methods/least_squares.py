"""Least squares of one form, linear or partially linear, also by a loss (M-estimation).

A reversal that the filter rounds, a shock, a bad contact: rows whose residual is no noise of the
others. Their squares lead least squares; by M-estimation a row counts for less the larger its
residual is, in deviations by the median, and with the bisquare not at all from 4.7 on. Both are 95
% as precise as least squares where the noise is normal.

References
----------
[Huber1981]_; [BeatonTukey1974]_ for the bisquare; [HollandWelsch1977]_ for the iteration.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from axisid.estimation.choices import BISQUARE_LOSS, HUBER_LOSS, SQUARES_LOSS
from axisid.estimation.estimates import NotSimulated
from axisid.estimation.estimation_problem import Problem, Solver
from axisid.estimation.regression import (
    Columns,
    Form,
    LossWeights,
    QrFactors,
    Solution,
    instrumental_variables,
    least_squares,
    separable_least_squares,
)
from axisid.estimation.thresholds import BISQUARE_TUNING, HUBER_TUNING, LIGHT_ROW, MEDIAN_OF_NORMAL
from axisid.support.arrays import Array
from axisid.support.errors import DataError, EstimationError, ModelError

from .method import Fit, Method

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


LOSS_FUNCTIONS: Mapping[str, RowLoss] = {HUBER_LOSS: _huber, BISQUARE_LOSS: _bisquare}
#: The loss whose estimate another is iterated from, instead of least squares: one that forgets
#: large residuals has several valleys.
_STARTS = {BISQUARE_LOSS: HUBER_LOSS}


def robust_solution(y: Array, X: Columns, Z: QrFactors, loss: str) -> Solution:
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

    Raises
    ------
    EstimationError
        It does not stand still, or what counts of the rows does not tell the parameters apart.
    """
    plain = instrumental_variables(y, X, Z)
    if loss not in LOSS_FUNCTIONS or robust_scale(plain.residuals) <= _ROUNDING * np.linalg.norm(y):
        return plain
    solution = robust_solution(y, X, Z, _STARTS[loss]) if loss in _STARTS else plain
    for _ in range(_MOST):
        weights, slopes, _ = LOSS_FUNCTIONS[loss](
            solution.residuals / robust_scale(solution.residuals)
        )
        previous = solution.theta
        solution = instrumental_variables(y, X, Z, LossWeights(weights=weights, slopes=slopes))
        change = np.linalg.norm((solution.theta - previous) * X.scale)
        if change <= _STANDS_STILL * np.linalg.norm(previous * X.scale):
            return solution
    raise EstimationError(
        f"the {loss} estimate still moves after {_MOST} iterations; use least squares, and look at "
        "what the residuals are.",
        code="no-convergence",
    )


def size_by_loss(residuals: Array, scale: float, loss: str) -> float:
    """What a loss makes of residuals, (n,), in their unit: their norm, if it is of squares."""
    if loss not in LOSS_FUNCTIONS or not scale > 0:
        return float(np.linalg.norm(residuals))
    return scale * float(np.sqrt(2 * np.sum(LOSS_FUNCTIONS[loss](residuals / scale)[2])))


def check_loss(loss: str, form: Form) -> None:
    """Refuse a loss for a model whose parameters are searched for by squares.

    Raises
    ------
    ModelError
        The model is not linear, and the loss is not of squares.
    """
    if loss in LOSS_FUNCTIONS and not form.is_linear:
        raise ModelError(
            f"the {loss} loss is of models that are linear in their parameters, and axis "
            f'{form.axis.name!r} is not; use loss="{SQUARES_LOSS}", or fit the control '
            "with a loss.",
            code="method",
        )


def loss_remarks(loss: str, solution: Solution) -> list[str]:
    """What a loss did to the rows, in words; nothing of squares."""
    if loss not in LOSS_FUNCTIONS:
        return []
    if solution.counts is None:
        return [f"{loss} loss: the rows are exact to rounding, and all count alike"]
    weights = solution.counts.weights
    light, least = np.count_nonzero(weights < LIGHT_ROW.value), float(weights.min())
    return [
        f"{loss} loss: {light} of {len(weights)} rows count for less than half, "
        f"the least by {least:.2g}"
    ]


def robust_scale(residuals: Array) -> float:
    """Deviation of normal residuals with this median size."""
    return float(np.median(np.abs(residuals))) / MEDIAN_OF_NORMAL.value


class LeastSquares(Method):
    """Least squares of one form; the simulated loop is a courtesy."""

    def fit(self, problem: Problem) -> Fit:
        """See `Method.fit`."""
        form = separable_least_squares(problem.form(self.form), problem.rows)
        measured = problem.rows(form)
        check_loss(self.loss, form)
        regressor = problem.factored(form, measured)
        left = measured.left - measured.intercept
        if form.is_linear:
            solution = robust_solution(left, regressor, regressor, self.loss)
        else:
            # The search ends within the bounds, where a step of the linearised model might not.
            found, at = least_squares(left, regressor), form.start
            solution = replace(found, theta=at, residuals=measured.residuals(at))
        solver = Solver(counts=solution.counts)
        fit = Fit(form=form, measured=measured, solution=solution, solver=solver)
        try:
            loops, right = problem.simulated(form, form.physical(solution.theta)[0])
        except (ModelError, DataError, EstimationError) as error:
            by_estimate = isinstance(error, EstimationError)
            said = f"no simulation error, since {error!s}"
            return replace(
                fit,
                simulated=NotSimulated(str(error), by_estimate=by_estimate),
                remarks=(said,) if by_estimate else (),  # what no method has, the verdict tells
            )
        return replace(fit, loops=loops, right=right, simulated=right.predicted(solution.theta))
