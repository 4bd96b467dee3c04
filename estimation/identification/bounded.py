"""Estimates within declared bounds: what would go beyond one is held there, the rest identified.

The bounded estimate is the point within the bounds that is nearest to the free one, by the
covariance of independent residuals; of least squares that is the bounded least squares of the same
rows. What it has at a bound is held, the others are identified anew with it, until none goes beyond
its bound.

What a bound holds is not known, so the others are as unsure as its parameter lets them be: they
have the covariance that they have without bounds. The bounded estimate is, by that covariance,
nearer to whatever is within the bounds than the free one is, so that it is enough.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import stdtrit

from axisid.codegen.artefacts import GeneratedAxis, Quantity, build
from axisid.estimation.estimates import Estimate
from axisid.estimation.parameters import least_within
from axisid.estimation.problems import Held
from axisid.estimation.regression import root
from axisid.estimation.thresholds import INTERVAL_LEVEL
from axisid.modeling.declaration import leave_out
from axisid.support.arrays import Array
from axisid.support.errors import AxisidError, EstimationError

from .result import Identification

#: Identifies an axis, from records that it knows.
Identify = Callable[[GeneratedAxis], Identification]


def bounded_result(axis: GeneratedAxis, identify: Identify) -> Identification:
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
    result = free = identify(axis)
    bounds: dict[str, float] = {}
    while beyond := _at_bounds(axis, result.preferred):
        bounds |= beyond
        result = identify(_axis_with(axis, bounds))
    held = []
    for name, bound in bounds.items():
        others = {other: at for other, at in bounds.items() if other != name}
        without = identify(_axis_with(axis, others)) if others else free
        held.append(_held(without.preferred, axis, name, bound))
    return _with_held(result, held, free) if held else free


def _axis_with(axis: GeneratedAxis, bounds: Mapping[str, float]) -> GeneratedAxis:
    """An axis whose parameters at a bound are held there."""
    try:
        return build(leave_out(axis.declared, **bounds), native=axis.native.enabled)
    except AxisidError as error:
        said = ", ".join(f"{name} at its bound {bound:g}" for name, bound in bounds.items())
        raise EstimationError(
            f"with {said} there is no axis left: {error.problem.rstrip('.')}. Check the signs "
            "and units of the record.",
            code="nothing-within-bounds",
        ) from error


def _with_held(result: Identification, held: list[Held], free: Identification) -> Identification:
    """The bounded result, which says what is held, with the covariances of the free one."""
    estimates = {
        method: _as_unsure(estimate, free.estimates[method])
        if method in free.estimates
        else estimate
        for method, estimate in result.estimates.items()
    }
    problem = replace(result.problem, held=tuple(held))
    return replace(result, problem=problem, estimates=estimates)


def _as_unsure(estimate: Estimate, free: Estimate) -> Estimate:
    """The same with the covariances that its parameters have where nothing is held."""
    places = _places(estimate.quantities, free.quantities)
    own = _places(estimate.ddm_quantities, free.ddm_quantities)
    if places is None or own is None:
        return estimate

    def of(covariances: Mapping[str, Array], at: list[int]) -> dict[str, Array]:
        return {name: whole[np.ix_(at, at)] for name, whole in covariances.items()}

    return estimate.with_inference(
        covariances=of(free.covariances, places),
        covariance_names=free.covariance_names,
        ddm_covariances=of(free.ddm_covariances, own),
        freedom={n: each[places] for n, each in free.freedom.items()},
        ddm_freedom={n: each[own] for n, each in free.inference.ddm_freedom.items()},
    )


def _places(names: Sequence[Quantity], among: Sequence[Quantity]) -> list[int] | None:
    """Where each is among others; None where one is not."""
    where = {quantity.name: i for i, quantity in enumerate(among)}
    return [where[q.name] for q in names] if all(q.name in where for q in names) else None


def _at_bounds(axis: GeneratedAxis, estimate: Estimate) -> dict[str, float]:
    """Declared parameters that the bounded estimate has at a bound, with that bound."""
    names = {p.name for p in axis.declared.parameters}
    declared = [p if p.name in names else None for p in estimate.form.declared]
    free = estimate.corrected
    if all(p is None or p.allows(x) for p, x in zip(declared, free, strict=True)):
        return {}
    lower = np.array([-np.inf if p is None else p.lower for p in declared])
    upper = np.array([np.inf if p is None else p.upper for p in declared])
    covariance = estimate.covariances["iid"]
    scale = np.sqrt(np.diag(covariance))
    rows = np.linalg.pinv(root(covariance) / scale[:, None]) / scale
    _, sides = least_within(lower, upper, free, rows, np.zeros(len(free)))
    active = zip(declared, sides, strict=True)
    return {p.name: p.lower if side < 0 else p.upper for p, side in active if p and side}


def _held(estimate: Estimate, axis: GeneratedAxis, name: str, bound: float) -> Held:
    """A parameter at its bound, and what it is in an estimate that has it free."""
    (parameter,) = (p for p in axis.declared.parameters if p.name == name)
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
