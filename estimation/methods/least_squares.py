"""Least squares of one form, linear or partially linear, also with a robust loss (M-estimation).

A reversal that the filter rounds, a shock or a bad contact makes rows with residuals far larger
than the noise of the other rows. Their squares dominate least squares. With M-estimation, a row has
less weight the larger its residual is, in standard deviations estimated by the median. With the
bisquare it has no weight beyond 4.7 standard deviations. Both losses are 95 % as precise as least
squares for normal noise.

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

_MOST_ITERATIONS = 200
_CONVERGED = 1e-10  # relative change of the parameters in the last iteration
_ROUNDING = 1e-13  # of the left side; smaller residuals are rounding errors and have no scale


_HUBER, _BISQUARE = HUBER_TUNING.value, BISQUARE_TUNING.value
#: Functions of the residuals u in standard deviations, (n,): ``psi(u) / u``, which is 1 for a small
#: residual, ``psi'(u)``, and ``rho(u)``, which is ``u^2/2`` for a small residual.
RowLoss = Callable[[Array], tuple[Array, Array, Array]]


def _huber(u: Array) -> tuple[Array, Array, Array]:
    """Return weight, derivative and value of Huber's loss for scaled residuals; see `RowLoss`."""
    size = np.abs(u)
    near = np.minimum(size, _HUBER)
    weight = _HUBER / np.maximum(size, _HUBER)
    return weight, (size <= _HUBER).astype(float), near**2 / 2 + _HUBER * (size - near)


def _bisquare(u: Array) -> tuple[Array, Array, Array]:
    """Return weight, derivative and value of the bisquare for scaled residuals; see `RowLoss`."""
    share = (u / _BISQUARE) ** 2
    inside = np.maximum(1 - share, 0.0)
    return inside**2, inside * (inside - 4 * share), _BISQUARE**2 / 6 * (1 - inside**3)


LOSS_FUNCTIONS: Mapping[str, RowLoss] = {HUBER_LOSS: _huber, BISQUARE_LOSS: _bisquare}
#: The loss whose estimate starts the iteration of another loss, instead of least squares: a loss
#: that ignores large residuals has several minima.
_STARTS = {BISQUARE_LOSS: HUBER_LOSS}


def robust_solution(y: Array, X: Columns, Z: QrFactors, loss: str) -> Solution:
    """Return the M-estimate of the rows: the solution of ``sum psi(e_i/s) z_i = 0``.

    Here e_i is the residual of a row, z_i its instruments, psi the derivative of the loss, and s
    the scale by the median residual. The solution is found by iteratively reweighted rows, starting
    from the solution with squares, or from the Huber estimate for the bisquare. The influence of
    the rows is that of these equations, ``Z (X' diag(psi') Z)^-1`` times the weighted residuals, so
    that every covariance is the consistent sandwich covariance.

    Parameters
    ----------
    y : (n,) array
        Left side.
    X : Columns
        Regressor.
    Z : QrFactors
        Instruments; the regressor itself for least squares.
    loss : str
        One of `ROW_LOSSES`; any other name stands for squares.

    Raises
    ------
    EstimationError
        The iteration does not converge, or the weighted rows do not distinguish the parameters.
    """
    plain = instrumental_variables(y, X, Z)
    if loss not in LOSS_FUNCTIONS or robust_scale(plain.residuals) <= _ROUNDING * np.linalg.norm(y):
        return plain
    solution = robust_solution(y, X, Z, _STARTS[loss]) if loss in _STARTS else plain
    for _ in range(_MOST_ITERATIONS):
        scaled_residuals = solution.residuals / robust_scale(solution.residuals)
        weights, slopes, _ = LOSS_FUNCTIONS[loss](scaled_residuals)
        previous = solution.theta
        solution = instrumental_variables(y, X, Z, LossWeights(weights=weights, slopes=slopes))
        change = np.linalg.norm((solution.theta - previous) * X.scale)
        if change <= _CONVERGED * np.linalg.norm(previous * X.scale):
            return solution
    raise EstimationError(
        f"the estimate with the {loss} loss does not converge in {_MOST_ITERATIONS} "
        "iterations. Use least "
        "squares, and examine the residuals.",
        code="no-convergence",
    )


def size_by_loss(residuals: Array, scale: float, loss: str) -> float:
    """Return the size of residuals, (n,), in their unit: the root of twice the sum of their losses.

    `scale` is the standard deviation of the residuals that the loss is scaled by. For squares, or
    without a positive scale, the size is the norm of the residuals.
    """
    if loss not in LOSS_FUNCTIONS or not scale > 0:
        return float(np.linalg.norm(residuals))
    return scale * float(np.sqrt(2 * np.sum(LOSS_FUNCTIONS[loss](residuals / scale)[2])))


def check_loss(loss: str, form: Form) -> None:
    """Refuse a robust loss for a nonlinear model, whose parameters are searched with squares.

    Raises
    ------
    ModelError
        The model is not linear, and the loss is not of squares.
    """
    if loss in LOSS_FUNCTIONS and not form.is_linear:
        raise ModelError(
            f"the {loss} loss needs a model that is linear in its parameters, and axis "
            f'{form.axis.name!r} is not. Use loss="{SQUARES_LOSS}", or fit the control (fit) '
            "with this loss.",
            code="method",
        )


def loss_remarks(loss: str, solution: Solution) -> list[str]:
    """Return a list with one sentence on the weights of the rows; empty for the squares.

    With a robust loss, the sentence gives the number of rows with a weight below one half, and the
    smallest weight.
    """
    if loss not in LOSS_FUNCTIONS:
        return []
    if solution.counts is None:
        return [f"{loss} loss: the rows are exact to rounding, and all have the same weight"]
    weights = solution.counts.weights
    light, least = np.count_nonzero(weights < LIGHT_ROW.value), float(weights.min())
    return [
        f"{loss} loss: {light} of {len(weights)} rows have a weight below one half; the smallest "
        f"weight is {least:.2g}"
    ]


def robust_scale(residuals: Array) -> float:
    """Return the standard deviation of normal residuals that have the same median magnitude."""
    return float(np.median(np.abs(residuals))) / MEDIAN_OF_NORMAL.value


class LeastSquares(Method):
    """Least squares of one form; the loop is simulated only for the simulation error."""

    def fit(self, problem: Problem) -> Fit:
        """Solve the rows of a problem by least squares, and simulate its loops with the solution.

        A nonlinear model is first linearised at its global least-squares solution. Where the loops
        cannot be simulated, the fit has the reason instead.

        Raises
        ------
        ModelError, EstimationError
            As in `Method.fit`.
        """
        form = separable_least_squares(problem.form(self.form), problem.rows)
        measured = problem.rows(form)
        check_loss(self.loss, form)
        regressor = problem.factored(form, measured)
        left = measured.left - measured.intercept
        if form.is_linear:
            solution = robust_solution(left, regressor, regressor, self.loss)
        else:
            # The parameters are those of the search, which are within the bounds. A step of the
            # linearised model might end outside.
            found, at = least_squares(left, regressor), form.start
            solution = replace(found, theta=at, residuals=measured.residuals(at))
        solver = Solver(counts=solution.counts)
        fit = Fit(form=form, measured=measured, solution=solution, solver=solver)
        try:
            loops, right = problem.simulated(form, form.physical(solution.theta)[0])
        except (ModelError, DataError, EstimationError) as error:
            by_estimate = isinstance(error, EstimationError)
            remarks: tuple[str, ...] = ()
            # If no loop can be simulated for any method, the verdict reports it instead.
            if by_estimate:
                remarks = (f"there is no simulation error, because {error!s}",)
            return replace(
                fit,
                simulated=NotSimulated(str(error), by_estimate=by_estimate),
                remarks=remarks,
            )
        return replace(fit, loops=loops, right=right, simulated=right.predicted(solution.theta))
