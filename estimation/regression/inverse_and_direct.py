"""Regression forms of a model: inverse (IDM) and direct (DDM), linear or partially linear.

Both forms write the same physics as ``y = X theta + intercept``; they differ in the left side, in
the regressor, and in the map from their parameters to the physical ones.

A partially linear model is linearised about a point, which a search finds by separable least
squares and damped instrumental-variable steps.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import product
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.generated_axes import GeneratedAxis, Quantity
from axisid.estimation.signals import FilteredRecord, Signals
from axisid.estimation.simulation import at_rest
from axisid.modeling.quantities import Parameter
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError, ModelError
from axisid.support.missing import Missing

from .linear import QrFactors, factor, least_squares


@dataclass(frozen=True, slots=True, kw_only=True)
class Equations:
    """Rows of the regression ``left = regressor theta + intercept``.

    Attributes
    ----------
    left : (n,) array
        Force (IDM) or acceleration (DDM).
    intercept : (n,) array
        Known terms without a parameter.
    regressor : (n, k) array
        Derivatives of the left side by the k parameters.
    """

    left: Array
    intercept: Array
    regressor: Array

    def reduced(self, data: FilteredRecord) -> "Equations":
        """Return the rows after the decimation filter of a record.

        Left side, intercept and every column of the regressor pass the same filter.
        """
        k = self.regressor.shape[1]
        known = (self.intercept,) if np.any(self.intercept) else ()
        rows = data.reduce(np.column_stack([self.regressor, self.left, *known]))
        return Equations(
            left=rows[:, k].copy(),
            intercept=rows[:, k + 1].copy() if known else np.zeros(len(rows)),
            regressor=rows[:, :k],
        )

    def predicted(self, theta: Array) -> Array:
        """Return the left side that parameters theta, (k,), predict, (n,)."""
        return np.asarray(self.regressor @ theta + self.intercept, dtype=float)

    def residuals(self, theta: Array) -> Array:
        """Return the residuals ``left - intercept - regressor theta``, (n,)."""
        return np.asarray(self.left - self.intercept - self.regressor @ theta, dtype=float)

    @classmethod
    def stacked(cls, pieces: Sequence["Equations"]) -> "Equations":
        """Return the rows of several equations as one regression."""
        if len(pieces) == 1:
            return pieces[0]
        return cls(
            left=np.concatenate([piece.left for piece in pieces]),
            intercept=np.concatenate([piece.intercept for piece in pieces]),
            regressor=np.concatenate([piece.regressor for piece in pieces]),
        )


@dataclass(frozen=True, slots=True)
class Form(ABC):
    """Model of an axis as a linear regression in k parameters, which p physical ones determine.

    Subclasses are the inverse and the direct model, and inverse models whose parameters are those
    of several records, or include gains and initial states of a simulated loop. A record has an
    axis of its own, with b parameters, if a known value of the record is fixed in it.

    Attributes
    ----------
    axis : GeneratedAxis
        Axis of the model.
    """

    axis: GeneratedAxis

    #: Left side of the equations, ``force`` or ``acceleration``.
    left: ClassVar[str]

    @property
    def start(self) -> Array:
        """Start values of the physical parameters, (p,)."""
        return self.axis.nominal

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Parameters of the regression, length k.

        They are the physical parameters, unless a subclass regresses other parameters.
        """
        return self.axis.parameters

    @abstractmethod
    def equations(self, signals: Signals) -> Equations:
        """Return the rows of the regression at each of N samples of signals, without filter."""

    @property
    def physical_quantities(self) -> tuple[Quantity, ...]:
        """Physical parameters, length p."""
        return self.axis.parameters

    @property
    def declared(self) -> tuple[Parameter, ...]:
        """Physical parameters with their declared bounds, length p."""
        return self.axis.axis_parameters

    @property
    def is_linear(self) -> bool:
        """True if the force is linear in all physical parameters."""
        return self.axis.is_linear

    def describe(self, physical: Array) -> str:
        """Return physical parameters (p,) as text: ``M = 95.1 kg, Fv = 203.5 N/(m/s)``."""
        pairs = zip(self.physical_quantities, physical, strict=True)
        return ", ".join(f"{q.name} = {value:.6g} {q.unit}" for q, value in pairs)

    def have_inertia(self, physical: Array) -> NDArray[np.bool_]:
        """Return True for each set of physical parameters, (B, p), with a positive inertia."""
        return at_rest(
            self.axis, physical, np.zeros(len(physical)), np.ones(len(self.axis.signals))
        )[0]

    def of_record(self, record: int) -> "Form":  # noqa: ARG002
        """Return the form of one of several records, in the parameters of that record's axis.

        The same form, unless a subclass has local parameters or known values of each record.
        """
        return self

    def own(self, physical: Array, record: int) -> Array:  # noqa: ARG002
        """Return the parameters of one record's axis, (b,), for physical parameters (p,).

        The same parameters, unless a subclass has parameters of several records, or of a simulated
        loop.
        """
        return physical

    def record_jacobian(self, record: int) -> Array:  # noqa: ARG002
        """Return the derivative of a record's parameters by those of the regression, (b, k).

        The identity matrix, unless a subclass has parameters of several records.
        """
        return np.eye(len(self.quantities))

    def placed(self, record: int, intercept: Array, regressor: Array) -> tuple[Array, Array]:  # noqa: ARG002
        """Return a record's intercept, (n,), and regressor, (n, k), in the regression's parameters.

        The arguments are intercept, (n,), and regressor, (n, b), in the parameters of the record's
        axis. They are returned unchanged, unless a subclass has parameters of several records.
        """
        return intercept, regressor

    def at(self, physical: Array) -> "Form":  # noqa: ARG002
        """Return the form linearised about physical parameters (p,).

        The same form, unless a subclass can be partially linear.
        """
        return self

    def physical(self, theta: Array) -> tuple[Array, Array]:
        """Return the physical parameters (p,) for those of the regression (k,), and the Jacobian.

        The Jacobian, (p, k), has the derivatives of the physical parameters by `theta`. The same
        parameters and the identity matrix are returned, unless a subclass regresses other
        parameters.
        """
        return theta, np.eye(len(theta))

    def regressed(self, physical: Array) -> Array:
        """Return the regression's parameters (k,) for physical parameters (p,).

        The same parameters, unless a subclass regresses other parameters.
        """
        return physical


@dataclass(frozen=True, slots=True)
class InverseForm(Form):
    """Inverse model ``tau = IDM(q, dq, ddq) theta + intercept`` in the physical parameters.

    Attributes
    ----------
    point : (p,) array or None
        Parameters about which a partially linear model is linearised; nominal values by default.
    """

    point: Array | None = None

    left: ClassVar[str] = "force"

    def equations(self, signals: Signals) -> Equations:
        """Return the rows of the inverse model at each of N samples; the left side is the force."""
        s = signals
        motion = (s.position, s.velocity, s.acceleration, s.direction)
        # A partially linear model also needs the point that it is linearised about.
        point = () if self.axis.is_linear else (self.start,)
        rows, intercept = self.axis.evaluate("idm_regressor", *motion, *s.recorded, *point)
        return Equations(left=s.force, intercept=intercept[:, 0], regressor=rows)

    def at(self, physical: Array) -> "InverseForm":
        """Return the model linearised about physical parameters (p,); itself if it is linear."""
        return self if self.is_linear else replace(self, point=physical)

    @property
    def start(self) -> Array:
        """Point of the linearisation, (p,); nominal values if there is none."""
        nominal = np.array([p.nominal for p in self.declared], dtype=float)
        return nominal if self.point is None else self.point


@dataclass(frozen=True, slots=True)
class DirectForm(Form):
    """Direct model ``ddq = DDM(tau, q, dq) theta_ddm + intercept``, in quotients by the inertia."""

    left: ClassVar[str] = "acceleration"

    def __post_init__(self) -> None:
        """Refuse an axis without a direct model."""
        _ = self.quantities  # raises the error

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Parameters ``theta_ddm`` of the direct model, quotients by the inertia, length k.

        Raises
        ------
        ModelError
            The axis has no direct model.
        """
        if isinstance(self.axis.ddm_parameters, Missing):
            raise ModelError(self.axis.ddm_parameters.reason)
        return self.axis.ddm_parameters

    def equations(self, signals: Signals) -> Equations:
        """Return the rows of the direct model at N samples; the left side is the acceleration."""
        s = signals
        motion = (s.position, s.velocity, s.force, s.direction)
        rows, intercept = self.axis.evaluate("ddm_regressor", *motion, *s.recorded)
        return Equations(left=s.acceleration, intercept=intercept[:, 0], regressor=rows)

    def physical(self, theta: Array) -> tuple[Array, Array]:
        """Return the physical parameters (p,) for ``theta_ddm`` (k,), and the Jacobian (p, k)."""
        return self.axis.mapped("physical_from_ddm", theta)

    def regressed(self, physical: Array) -> Array:
        """Return ``theta_ddm`` (k,) for physical parameters (p,)."""
        return self.axis.mapped("ddm_from_physical", physical)[0]


_SPREAD = (0.1, 0.3, 1.0, 3.0, 10.0)  # factors of the nominal value for start values
_MOST_STARTS = 125  # combinations of start values
_BEST_STARTS = 5  # number of the best starts from which a search runs
_MOST_HALVINGS = 8  # of a damped step


def separable_least_squares(form: Form, rows: Callable[[Form], Equations]) -> Form:
    """Return a form linearised at the least-squares estimate of a partially linear model.

    The linear parameters are projected out [GolubPereyra1973]_: for given nonlinear parameters they
    have an exact solution, so that only the few nonlinear parameters are searched. The search runs
    from several starts, because the error may have several local minima. A linear form, and a form
    that is not an inverse model, is returned unchanged.

    Parameters
    ----------
    form : Form
    rows : callable
        Function that returns the filtered rows of a form, linearised at its point.

    Raises
    ------
    EstimationError
        A nonlinear parameter has no nominal value to start from, or no start gives an estimate.
    """
    from scipy.optimize import least_squares as minimise

    if form.is_linear or not isinstance(form, InverseForm):
        return form
    problem = _SeparableProblem(form=form, rows=rows, nonlinear=np.array(form.axis.nonlinear))
    low, high = (end[problem.nonlinear] for end in search_bounds(form.axis))
    starts = _starts_of_search(problem, low, high)
    try:
        problem.solved(starts[0])
    except EstimationError as why:
        raise EstimationError(
            f"no start value of {', '.join(problem.names)} gives an estimate. Declare nominal "
            "values and bounds of the right size, where the equation of motion has a finite value. "
            f"The reason at the first start value: {why}",
            code="no-convergence",
        ) from why
    fits = [
        minimise(
            problem.residuals,
            start,
            bounds=(low, high),
            x_scale=np.abs(start),
            xtol=1e-12,
            ftol=1e-12,
        )
        for start in starts[:_BEST_STARTS]
    ]
    best = min(fits, key=lambda fit: float(fit.cost))
    return form.at(problem.solved(np.asarray(best.x, dtype=float))[0])


@dataclass(frozen=True, slots=True, kw_only=True)
class _SeparableProblem:
    """Least squares of a partially linear model in its nonlinear parameters alone.

    Attributes
    ----------
    form : InverseForm
    rows : callable
        Function that returns the filtered rows of a form, linearised at its point.
    nonlinear : (p,) array of bool
        True for parameters that enter nonlinearly.
    """

    form: InverseForm
    rows: Callable[[Form], Equations]
    nonlinear: NDArray[np.bool_]

    @property
    def names(self) -> list[str]:
        """Names of the nonlinear parameters."""
        pairs = zip(self.form.axis.names, self.nonlinear, strict=True)
        return [name for name, is_nonlinear in pairs if is_nonlinear]

    @property
    def linear_names(self) -> list[str]:
        """Names of the linear parameters."""
        pairs = zip(self.form.axis.names, self.nonlinear, strict=True)
        return [name for name, is_nonlinear in pairs if not is_nonlinear]

    def solved(self, at: Array) -> tuple[Array, Array]:
        """Return all parameters (p,) and the residuals (n,) for nonlinear parameters `at`.

        The linear parameters are those of least squares.

        Raises
        ------
        EstimationError
            The rows do not show a linear parameter, or the model has no finite value.
        """
        physical = self.form.axis.nominal.copy()
        physical[self.nonlinear] = at
        equations = self.rows(self.form.at(physical))
        # The columns of the linear parameters do not depend on the linear parameters.
        intercept = equations.intercept + equations.regressor[:, self.nonlinear] @ at
        columns = factor(equations.regressor[:, ~self.nonlinear], self.linear_names)
        solution = least_squares(equations.left - intercept, columns)
        physical[~self.nonlinear] = solution.theta
        if not np.all(np.isfinite(solution.residuals)):
            values = ", ".join(f"{n} = {x:g}" for n, x in zip(self.names, at, strict=True))
            raise EstimationError(f"the model has no finite value with {values}.")
        return physical, solution.residuals

    def residuals(self, at: Array) -> Array:
        """Return the residuals, (n,), for nonlinear parameters `at`.

        Where there is no estimate, each residual is 1000 times the largest left side.
        """
        try:
            return self.solved(at)[1]
        except EstimationError:
            left = self.rows(self.form).left
            return np.full_like(left, 1e3 * float(np.abs(left).max()))

    def squared_error(self, at: Array) -> float:
        """Return the sum of squared residuals for nonlinear parameters `at`.

        It is infinite where there is no estimate.
        """
        with suppress(EstimationError):
            return float(np.sum(self.solved(at)[1] ** 2))
        return np.inf


def _starts_of_search(problem: _SeparableProblem, low: Array, high: Array) -> list[Array]:
    """Return start values of the nonlinear parameters within their bounds, the best first.

    Raises
    ------
    EstimationError
        A nonlinear parameter has the nominal value 0.
    """
    nominal = problem.form.axis.nominal[problem.nonlinear]
    without_start = [n for n, x in zip(problem.names, nominal, strict=True) if x == 0]
    if without_start:
        raise EstimationError(
            f"the model is not linear in {', '.join(without_start)}, so the search needs a start "
            "value. Declare a nominal value other than 0.",
            code="no-convergence",
        )
    # All combinations of factors; with too many combinations, the same factor for all parameters.
    factors = [*product(_SPREAD, repeat=len(nominal))]
    if len(factors) > _MOST_STARTS:
        factors = [(factor_of_all,) * len(nominal) for factor_of_all in _SPREAD]
    candidates = [nominal * np.array(each) for each in factors]
    inside = [each for each in candidates if np.all((each > low) & (each < high))]
    return sorted(inside or [nominal], key=problem.squared_error)


def search_bounds(axis: GeneratedAxis) -> tuple[Array, Array]:
    """Return lower and upper bounds (p,) of a search; linear parameters have infinite bounds."""
    nonlinear, declared = np.array(axis.nonlinear), axis.axis_parameters
    return (
        np.where(nonlinear, [p.lower for p in declared], -np.inf),
        np.where(nonlinear, [p.upper for p in declared], np.inf),
    )


def damped_step(
    form: InverseForm,
    rows: Callable[[InverseForm], Equations],
    instruments: QrFactors,
    start: Array,
    goal: Array,
) -> Array:
    """Return the parameters after a damped step towards the linearised instrumental solution, (p,).

    The step from `start` to `goal` is halved until it is within the bounds of the nonlinear
    parameters and reduces ``||Q' e||``, the norm of the residuals e projected on the instruments.
    If none of eight steps does, `goal` is returned, provided that it is within the bounds.

    Parameters
    ----------
    form : InverseForm
    rows : callable
        Function that returns the filtered rows of a form, linearised at its point.
    instruments : QrFactors
        Instruments with their orthonormal basis Q.
    start, goal : (p,) array
        Present parameters, and the solution of the linearised equations.

    Raises
    ------
    EstimationError
        The solution is beyond a bound, and no step within the bounds reduces the residuals.
    """
    low, high = search_bounds(form.axis)

    def projected(physical: Array) -> float:
        """Return the norm of the residuals projected on the instruments, ``||Q' e||``."""
        residuals = rows(form.at(physical)).residuals(physical)
        return float(np.linalg.norm(instruments.basis.T @ residuals))

    before = projected(start)
    for halving in range(_MOST_HALVINGS):
        trial = start + (goal - start) / 2**halving
        if np.all((trial >= low) & (trial <= high)) and projected(trial) < before:
            return np.asarray(trial, dtype=float)
    beyond = [
        f"{p.name} = {value:.4g} {p.unit}, beyond its bound {min(max(value, least), most):g}"
        for p, value, least, most in zip(form.axis.axis_parameters, goal, low, high, strict=True)
        if not least <= value <= most
    ]
    if not beyond:
        return goal
    raise EstimationError(
        f"the instrumental variables give {' and '.join(beyond)}, and no step within the bounds "
        "reduces the residuals. Widen the bounds if this value is possible; otherwise use the "
        "estimate of idm-ls, whose search ends within the bounds, and check the friction model.",
        code="bounds",
    )
