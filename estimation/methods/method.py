"""What a method of estimation is, what it makes of a problem, and least squares as the first.

A reversal that the filter rounds, a shock, a bad contact: rows whose residual is no noise of the
others. Their squares lead least squares; by M-estimation a row counts for less the larger its
residual is, in deviations by the median, and with the bisquare not at all from 4.7 on. Both are 95
% as precise as least squares where the noise is normal.

References
----------
[Huber1981]_; [BeatonTukey1974]_ for the bisquare; [HollandWelsch1977]_ for the iteration.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from axisid.estimation.choices import (
    BISQUARE_LOSS,
    HUBER_LOSS,
    INSTRUMENT_STARTS,
    ROW_LOSSES,
    SQUARES_LOSS,
)
from axisid.estimation.estimates import Iterate, NotSimulated
from axisid.estimation.estimation_problem import Problem, Solver
from axisid.estimation.regression import (
    Columns,
    Equations,
    Form,
    LossWeights,
    QrFactors,
    Solution,
    instrumental_variables,
    least_squares,
    separable_least_squares,
)
from axisid.estimation.simulation import Simulation
from axisid.estimation.thresholds import (
    BISQUARE_TUNING,
    HUBER_TUNING,
    LIGHT_ROW,
    MAX_SIMULATION_ERROR,
    MEDIAN_OF_NORMAL,
)
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.errors import DataError, EstimationError, ModelError

_NO_LOOP = NotSimulated("the method simulates no loop")


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """A solution of measured rows, with the loops simulated from it.

    Attributes
    ----------
    form : Form
        At the point that the rows are linearised about.
    measured : Equations
    solution : Solution
    solver : Solver
        What solved the rows, and solves others as it did.
    iterates : tuple of Iterate
        The start and every iterate; empty for what is no iteration.
    started : str
        Where the iteration started, of `INSTRUMENT_STARTS`; empty for what is no iteration.
    loops : tuple of Simulation
        One for each segment of each record; empty where they could not be simulated.
    right : Equations or None
        Rows of the loops, where they were simulated with the solution.
    simulated : (n,) array or NotSimulated
        Left side as the simulated loops have it.
    remarks : tuple of str
    """

    form: Form
    measured: Equations
    solution: Solution
    solver: Solver = field(default_factory=Solver)
    iterates: tuple[Iterate, ...] = ()
    started: str = ""
    loops: tuple[Simulation, ...] = ()
    right: Equations | None = None
    simulated: Array | NotSimulated = _NO_LOOP
    remarks: tuple[str, ...] = ()

    @property
    def physical(self) -> Array:
        """Physical parameters, (p,)."""
        return self.form.physical(self.solution.theta)[0]

    @property
    def simulation_error_percent(self) -> float:
        """What the simulated loops leave of the left side; infinite where there are none."""
        left = self.measured.left
        if isinstance(self.simulated, NotSimulated):
            return math.inf
        return relative_error_percent(left - self.simulated, left)

    @property
    def follows(self) -> bool:
        """Whether the simulated loops move as the records do, so that they stand for them."""
        return self.simulation_error_percent < MAX_SIMULATION_ERROR.value


@dataclass(frozen=True, slots=True, kw_only=True)
class Method(ABC):
    """A way from a problem's rows to an estimate.

    Attributes
    ----------
    name : str
        As users give it, ``idm-ls``.
    form : type of Form
        That is regressed.
    start : str
        Of `INSTRUMENT_STARTS`, where an iteration starts; least squares only where its loop follows
        records.
    loss : str
        Of `ROW_LOSSES`, how rows count.
    """

    name: str
    form: type[Form]
    start: str = INSTRUMENT_STARTS[0]
    loss: str = ROW_LOSSES[0]

    def fitted(self, problem: Problem) -> Fit:
        """The fit of a problem, which is made once; see `fit`."""
        if self not in problem.made:
            problem.made[self] = self.fit(problem)
        found: Fit = problem.made[self]
        return found

    @abstractmethod
    def fit(self, problem: Problem) -> Fit:
        """Solve the rows.

        Raises
        ------
        ModelError
            The axis has no such form.
        EstimationError
            The rows cannot be solved; what is missing is named.
        """


def at_point(solution: Solution, measured: Equations, physical: Array) -> Solution:
    """A solution moved to where the measured rows are linearised, (p,): their residuals there."""
    return replace(solution, theta=physical, residuals=measured.residuals(physical))


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


LOSS_FUNCTIONS: Mapping[str, RowLoss] = MappingProxyType(
    {HUBER_LOSS: _huber, BISQUARE_LOSS: _bisquare}
)
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
    if loss not in LOSS_FUNCTIONS or scale_of(plain.residuals) <= _ROUNDING * np.linalg.norm(y):
        return plain
    solution = robust_solution(y, X, Z, _STARTS[loss]) if loss in _STARTS else plain
    for _ in range(_MOST):
        weights, slopes, _ = LOSS_FUNCTIONS[loss](solution.residuals / scale_of(solution.residuals))
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
    return scale * math.sqrt(2 * float(np.sum(LOSS_FUNCTIONS[loss](residuals / scale)[2])))


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
            f'{form.axis.axis.name!r} is not; use loss="{SQUARES_LOSS}", or fit the control '
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


def scale_of(residuals: Array) -> float:
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
            solution = at_point(least_squares(left, regressor), measured, form.start)
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
