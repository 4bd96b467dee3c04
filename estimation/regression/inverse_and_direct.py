"""The two forms a model is regressed in, inverse (IDM) and direct (DDM), also partially linear.

Both put the same physics into ``y = X theta + intercept``; they differ in what is on the left, in
the regressor, and in how their parameters map to the physical ones.

A partially linear model is regressed about a point, which a search finds: separable least squares,
and damped instrumental steps.
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
from axisid.support.errors import EstimationError, Missing, ModelError

from .linear import QrFactors, factor, least_squares


@dataclass(frozen=True, slots=True, kw_only=True)
class Equations:
    """``left = regressor theta + intercept``, row by row.

    Attributes
    ----------
    left : (n,) array
        Force (IDM) or acceleration (DDM).
    intercept : (n,) array
        What no parameter scales.
    regressor : (n, k) array
    """

    left: Array
    intercept: Array
    regressor: Array

    def reduced(self, data: FilteredRecord) -> "Equations":
        """The rows that the record's filter keeps, every column filtered alike."""
        k = self.regressor.shape[1]
        known = (self.intercept,) if np.any(self.intercept) else ()
        rows = data.reduce(np.column_stack([self.regressor, self.left, *known]))
        return Equations(
            left=rows[:, k].copy(),
            intercept=rows[:, k + 1].copy() if known else np.zeros(len(rows)),
            regressor=rows[:, :k],
        )

    def predicted(self, theta: Array) -> Array:
        """Left side with parameters (k,), (n,)."""
        return np.asarray(self.regressor @ theta + self.intercept, dtype=float)

    def residuals(self, theta: Array) -> Array:
        """What parameters (k,) leave of the left side, (n,)."""
        return np.asarray(self.left - self.intercept - self.regressor @ theta, dtype=float)

    @classmethod
    def stacked(cls, pieces: Sequence["Equations"]) -> "Equations":
        """The rows of several, one after the other."""
        if len(pieces) == 1:
            return pieces[0]
        return cls(
            left=np.concatenate([piece.left for piece in pieces]),
            intercept=np.concatenate([piece.intercept for piece in pieces]),
            regressor=np.concatenate([piece.regressor for piece in pieces]),
        )


@dataclass(frozen=True, slots=True)
class Form(ABC):
    """One way to write the axis's model as a linear regression."""

    axis: GeneratedAxis

    #: What stands on the left of the equations.
    left: ClassVar[str]

    @property
    def start(self) -> Array:
        """Physical parameters (p,) that an iteration starts from."""
        return self.axis.nominal

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """What the regression estimates: the physical parameters, unless it is of others."""
        return self.axis.parameters

    @abstractmethod
    def equations(self, signals: Signals) -> Equations:
        """The model's rows for signals, (N,)."""

    @property
    def physical_quantities(self) -> tuple[Quantity, ...]:
        """The physical parameters, length p."""
        return self.axis.parameters

    @property
    def declared(self) -> tuple[Parameter, ...]:
        """The same with the bounds that they were declared with."""
        return self.axis.axis_parameters

    @property
    def is_linear(self) -> bool:
        """Whether the force is linear in all of them."""
        return self.axis.is_linear

    def describe(self, physical: Array) -> str:
        """Physical parameters (p,) in words, as ``M = 95.1 kg, Fv = 203.5 N/(m/s)``."""
        pairs = zip(self.physical_quantities, physical, strict=True)
        return ", ".join(f"{q.name} = {value:.6g} {q.unit}" for q, value in pairs)

    def have_inertia(self, physical: Array) -> NDArray[np.bool_]:
        """Which sets of physical parameters, (B, p), have a positive and finite inertia."""
        return at_rest(
            self.axis, physical, np.zeros(len(physical)), np.ones(len(self.axis.signals))
        )[0]

    def of_record(self, record: int) -> "Form":  # noqa: ARG002
        """The form of one of several records, in that record's own parameters."""
        return self

    def own(self, physical: Array, record: int) -> Array:  # noqa: ARG002
        """Parameters of the axis of one of several records from physical ones (p,)."""
        return physical

    def record_jacobian(self, record: int) -> Array:  # noqa: ARG002
        """Of a record's own parameters by the regression's, (b, k)."""
        return np.eye(len(self.quantities))

    def placed(self, record: int, intercept: Array, regressor: Array) -> tuple[Array, Array]:  # noqa: ARG002
        """A record's intercept, (n,), and regressor by the parameters of all records."""
        return intercept, regressor

    def at(self, physical: Array) -> "Form":  # noqa: ARG002
        """The form linearised about physical parameters (p,); itself if it is linear."""
        return self

    def physical(self, theta: Array) -> tuple[Array, Array]:
        """Physical parameters (p,) of an estimate (k,), and the Jacobian (p, k)."""
        return theta, np.eye(len(theta))

    def regressed(self, physical: Array) -> Array:
        """The regression's parameters (k,) of physical ones (p,)."""
        return physical


@dataclass(frozen=True, slots=True)
class InverseForm(Form):
    """``tau = IDM(q, dq, ddq) theta + intercept``: the physical parameters themselves.

    Attributes
    ----------
    point : (p,) array or None
        Where a partially linear model is linearised; its nominal values by default.
    """

    point: Array | None = None

    left: ClassVar[str] = "force"

    def equations(self, signals: Signals) -> Equations:
        """Force by the inverse regressor."""
        s = signals
        motion = (s.position, s.velocity, s.acceleration, s.direction)
        about = () if self.axis.is_linear else (self.start,)
        row, intercept = self.axis.evaluate("idm_regressor", *motion, *s.recorded, *about)
        return Equations(left=s.force, intercept=intercept[:, 0], regressor=row)

    def at(self, physical: Array) -> "InverseForm":
        """See `Form.at`."""
        return self if self.is_linear else replace(self, point=physical)

    @property
    def start(self) -> Array:
        """See `Form.start`; where it is linearised, if it is."""
        nominal = np.array([p.nominal for p in self.declared], dtype=float)
        return nominal if self.point is None else self.point


@dataclass(frozen=True, slots=True)
class DirectForm(Form):
    """``ddq = DDM(tau, q, dq) theta_ddm + intercept``: quotients by the inertia."""

    left: ClassVar[str] = "acceleration"

    def __post_init__(self) -> None:
        _ = self.quantities  # refuses an axis without

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """``theta_ddm``."""
        if isinstance(self.axis.ddm_parameters, Missing):
            raise ModelError(self.axis.ddm_parameters.reason)
        return self.axis.ddm_parameters

    def equations(self, signals: Signals) -> Equations:
        """Acceleration by the direct regressor."""
        s = signals
        motion = (s.position, s.velocity, s.force, s.direction)
        row, intercept = self.axis.evaluate("ddm_regressor", *motion, *s.recorded)
        return Equations(left=s.acceleration, intercept=intercept[:, 0], regressor=row)

    def physical(self, theta: Array) -> tuple[Array, Array]:
        """Through the generated inverse map."""
        return self.axis.mapped("physical_from_ddm", theta)

    def regressed(self, physical: Array) -> Array:
        """Through the generated map."""
        return self.axis.mapped("ddm_from_physical", physical)[0]


_SPREAD = (0.1, 0.3, 1.0, 3.0, 10.0)  # times the nominal value
_MOST_STARTS = 125
_REFINED = 5  # of the starts, the best ones
_MOST_HALVINGS = 8


def separable_least_squares(form: Form, rows: Callable[[Form], Equations]) -> Form:
    """A form, at the least-squares estimate if its model is only partially linear.

    The linear parameters are projected out [GolubPereyra1973]_: for given nonlinear ones they are
    solved exactly, so that only the few nonlinear ones are searched; from several starts, since the
    error may have more than one valley.

    Parameters
    ----------
    form : Form
    rows : callable
        The reduced equations (n,) of a form at its point.

    Raises
    ------
    EstimationError
        A nonlinear parameter has no nominal value to start from, or no start gives an estimate.
    """
    from scipy.optimize import least_squares as minimise

    if form.is_linear or not isinstance(form, InverseForm):
        return form
    axis, nonlinear = form.axis, np.array(form.axis.nonlinear)
    names, linear = (
        [name for name, is_so in zip(axis.names, axis.nonlinear, strict=True) if is_so == wanted]
        for wanted in (True, False)
    )
    nominal = axis.nominal[nonlinear]
    low, high = (end[nonlinear] for end in search_bounds(axis))
    if missing := [n for n, x in zip(names, nominal, strict=True) if x == 0]:
        raise EstimationError(
            f"{', '.join(missing)} enters nonlinearly, so its search needs a start; declare a "
            "nominal value other than 0.",
            code="no-convergence",
        )

    def solved(at: Array) -> tuple[Array, Array]:
        """All parameters (p,) for given nonlinear ones, and the residuals (n,)."""
        physical = axis.nominal.copy()
        physical[nonlinear] = at
        equations = rows(form.at(physical))
        # The columns of the linear parameters, and what they leave, do not depend on their values.
        intercept = equations.intercept + equations.regressor[:, nonlinear] @ at
        columns = factor(equations.regressor[:, ~nonlinear], linear)
        solution = least_squares(equations.left - intercept, columns)
        physical[~nonlinear] = solution.theta
        if not np.all(np.isfinite(solution.residuals)):
            values = ", ".join(f"{n} = {x:g}" for n, x in zip(names, at, strict=True))
            raise EstimationError(f"the model has no finite value with {values}.")
        return physical, solution.residuals

    def residuals(at: Array) -> Array:
        """Those of the best linear parameters, (n,); larger than any where there is no estimate."""
        try:
            return solved(at)[1]
        except EstimationError:
            left = rows(form).left
            return np.full_like(left, 1e3 * float(np.abs(left).max()))

    def error(at: Array) -> float:
        """Sum of squares of the same; infinite where there is no estimate."""
        with suppress(EstimationError):
            return float(np.sum(solved(at)[1] ** 2))
        return np.inf

    factors = [*product(_SPREAD, repeat=len(nominal))]
    if len(factors) > _MOST_STARTS:
        factors = [(times,) * len(nominal) for times in _SPREAD]
    around = [nominal * np.array(each) for each in factors]
    inside = [each for each in around if np.all((each > low) & (each < high))]
    starts = sorted(inside or [nominal], key=error)
    try:
        solved(starts[0])
    except EstimationError as why:
        said = (
            f"no start of {', '.join(names)} gives an estimate; give them nominal "
            "values and bounds of the right size, where the equation of motion has a value. "
            f"At the first, {why}"
        )
        raise EstimationError(said, code="no-convergence") from why
    fits = [
        minimise(
            residuals, start, bounds=(low, high), x_scale=np.abs(start), xtol=1e-12, ftol=1e-12
        )
        for start in starts[:_REFINED]
    ]
    best = min(fits, key=lambda valley: float(valley.cost))
    return form.at(solved(np.asarray(best.x, dtype=float))[0])


def search_bounds(axis: GeneratedAxis) -> tuple[Array, Array]:
    """Lower and upper bounds (p,) of what is searched for; linear parameters have none."""
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
    """From parameters towards a solution of the linearised instrumental equations, both (p,).

    As far as what the instruments see of the residuals falls, within the bounds of the nonlinear
    parameters.

    Raises
    ------
    EstimationError
        The solution is beyond a bound, and no step towards it within the bounds is of use.
    """
    low, high = search_bounds(form.axis)

    def projected(physical: Array) -> float:
        return float(
            np.linalg.norm(instruments.basis.T @ rows(form.at(physical)).residuals(physical))
        )

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
        f"the instruments lead to {' and '.join(beyond)}, and no step within the bounds brings "
        "their equations nearer to zero. Widen the bounds if such a value is possible; otherwise "
        "believe idm-ls, whose search ends within them, and check the model of the friction.",
        code="bounds",
    )
