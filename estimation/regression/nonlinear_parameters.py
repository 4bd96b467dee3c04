"""Estimates of what enters nonlinearly: separable least squares, and damped instrumental steps.

A partially linear model is regressed about a point, which a search finds.
"""

from collections.abc import Callable
from contextlib import suppress
from itertools import product

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError

from .inverse_and_direct import Equations, Form, InverseForm
from .linear import QrFactors, factor, least_squares

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
    nonlinear, declared = np.array(axis.nonlinear), axis.axis.parameters
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
        for p, value, least, most in zip(form.axis.axis.parameters, goal, low, high, strict=True)
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
