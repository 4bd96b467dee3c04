"""Estimates within declared bounds: what would go beyond one is held there, the rest identified.

A sum of squares is convex, so that its least value within bounds is that of the rows with the
parameters at their bounds put in, once it is known which those are: of least squares the active set
of the same rows, of instruments Z that of ``||P_Z (y - X theta)||``, whose free minimum is the
instrumental-variable estimate [Wooldridge2010]_.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis, build
from axisid.estimation.estimates import Estimate
from axisid.estimation.problems import Held
from axisid.estimation.thresholds.estimates import INTERVAL_LEVEL
from axisid.modeling.declaration import leave_out
from axisid.modeling.quantities import Parameter
from axisid.support.arrays import Array
from axisid.support.errors import AxisidError, EstimationError

from .result import Identification

#: Identifies an axis, from records that it knows.
Identify = Callable[[GeneratedAxis], Identification]


def within_bounds(axis: GeneratedAxis, identify: Identify) -> Identification:
    """What is identified with every declared parameter within its bounds, by the judged method.

    Parameters
    ----------
    axis : GeneratedAxis
    identify : callable

    Raises
    ------
    EstimationError
        Nothing is left to identify, or no inertia, with the parameters at their bounds.
    """
    result, held = identify(axis), list[Held]()
    while beyond := _at_bounds(axis, result.preferred):
        held += [_held(result.preferred, p, bound) for p, bound in beyond]
        values = {each.name: each.bound for each in held}
        result = identify(_with_held(axis, values, held))
    return replace(result, problem=replace(result.problem, held=tuple(held))) if held else result


def _with_held(axis: GeneratedAxis, values: Mapping[str, float], held: list[Held]) -> GeneratedAxis:
    try:
        return build(leave_out(axis.declared, **values), native=axis.native.enabled)
    except AxisidError as error:
        said = "; ".join(each.text for each in held)
        raise EstimationError(
            f"{said}: so there is no axis left ({error.problem.rstrip('.')}). Check the signs and "
            "units of the record.",
            code="nothing-within-bounds",
        ) from error


def _at_bounds(axis: GeneratedAxis, estimate: Estimate) -> list[tuple[Parameter, float]]:
    """Declared parameters that are not within their bounds, with the bound that each is held at."""
    names = {p.name for p in axis.declared.parameters}
    declared = [(i, p) for i, p in enumerate(estimate.form.declared) if p.name in names]
    outside = [
        (p, p.lower if estimate.physical[i] < p.lower else p.upper)
        for i, p in declared
        if not p.allows(estimate.physical[i])
    ]
    if not outside or not np.array_equal(estimate.jacobian, np.eye(len(estimate.theta))):
        return outside  # quotients of what is regressed: one after the other
    lower, upper = np.full((2, len(estimate.theta)), np.inf) * np.array([[-1.0], [1.0]])
    for i, p in declared:
        lower[i], upper[i] = p.lower, p.upper
    active = _active_set(estimate, lower, upper)
    return [(p, p.lower if active[i] < 0 else p.upper) for i, p in declared if active[i]]


def _active_set(estimate: Estimate, lower: Array, upper: Array) -> Array:
    """-1 and 1 for parameters, (p,), that the least sum of squares has at a bound, else 0."""
    from scipy.optimize import lsq_linear

    weights = np.ones(len(estimate.y)) if estimate.weights is None else estimate.weights
    if estimate.loss_weights is not None:
        weights = weights * np.sqrt(estimate.loss_weights)
    X = weights[:, None] * estimate.X
    y = weights * estimate.residuals + X @ estimate.theta
    seen = X if estimate.Z is None else weights[:, None] * estimate.Z
    basis = np.linalg.qr(seen / np.linalg.norm(seen, axis=0))[0].T
    scale = np.linalg.norm(X, axis=0)
    found = lsq_linear(
        basis @ (X / scale), basis @ y, bounds=(lower * scale, upper * scale), method="bvls"
    )
    return np.asarray(found.active_mask)


def _held(estimate: Estimate, parameter: Parameter, bound: float) -> Held:
    from scipy.special import stdtrit

    value = estimate.parameters[parameter.name]
    place = [q.name for q in estimate.quantities].index(parameter.name)
    freedom = float(estimate.freedom[estimate.chosen][place])
    away = float(stdtrit(freedom, INTERVAL_LEVEL.value)) * value.deviation
    is_lower = bound == parameter.lower
    reach = value.corrected + (away if is_lower else -away)
    return Held(
        name=parameter.name,
        unit=value.unit,
        bound=bound,
        is_lower=is_lower,
        free=value.corrected,
        deviation=value.deviation,
        reach=max(bound, reach) if is_lower else min(bound, reach),
    )
