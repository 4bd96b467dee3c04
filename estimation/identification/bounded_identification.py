"""Identification with declared parameters fixed at their bounds.

The bounded estimate is the point within the declared bounds that is nearest to the free estimate,
by the covariance of independent residuals. For least squares this is bounded least squares of the
same rows. Parameters that it has at a bound are fixed there, and the others are identified again,
until none is beyond its bound. The true value of a fixed parameter is not known, so the others keep
the covariance that they have without bounds. This covariance is large enough: measured with it, the
bounded estimate is nearer to every point within the bounds than the free estimate.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from scipy.special import stdtrit

from axisid.codegen.generated_axes import GeneratedAxis, build
from axisid.estimation.estimates import Estimate
from axisid.estimation.estimation_problem import ParameterAtBound
from axisid.estimation.regression import covariance_root
from axisid.estimation.thresholds import INTERVAL_LEVEL
from axisid.estimation.unknowns import bounded_quadratic_minimum
from axisid.modeling.declaration import leave_out
from axisid.support.errors import AxisidError, EstimationError

from .result import Identification


def bounded_identification(
    axis: GeneratedAxis, identify: Callable[[GeneratedAxis], Identification]
) -> Identification:
    """Return the result with every declared parameter within its bounds.

    Parameters that the bounded estimate has at a bound are fixed there, and the axis is identified
    again, until no parameter is beyond its bound. The covariances are those of the identification
    without bounds, because the true value of a fixed parameter is not known. If the first
    identification is within all bounds, it is returned unchanged.

    Parameters
    ----------
    axis : GeneratedAxis
    identify : callable
        Returns the identification of an axis without regard to bounds.

    Raises
    ------
    EstimationError
        With the parameters at their bounds, there is nothing to identify, or no inertia.
    """
    result = free = identify(axis)
    bounds: dict[str, float] = {}
    # Fix the parameters that the bounded estimate has at a bound, until there are no more of them.
    while beyond := _bounds_reached(axis, result.preferred):
        bounds |= beyond
        result = identify(axis_at_bounds(axis, bounds))
    if not bounds:
        return free
    # For each fixed parameter, its estimate while only the other fixed parameters are fixed.
    fixed = []
    for name, bound in bounds.items():
        others = {other: at for other, at in bounds.items() if other != name}
        without = identify(axis_at_bounds(axis, others)) if others else free
        fixed.append(_parameter_at_bound(without.preferred, axis, name, bound))
    estimates = {
        method: _with_free_covariances(estimate, free.estimates.get(method, estimate))
        for method, estimate in result.estimates.items()
    }
    return replace(result, problem=replace(result.problem, held=tuple(fixed)), estimates=estimates)


def axis_at_bounds(axis: GeneratedAxis, bounds: Mapping[str, float]) -> GeneratedAxis:
    """Return the axis with some parameters fixed at the given bounds, and so removed from it.

    Parameters
    ----------
    axis : GeneratedAxis
    bounds : mapping of str to float
        Value of the bound by name of the parameter, SI.

    Raises
    ------
    EstimationError
        The axis with these values cannot be identified: no parameter or no inertia is left.
    """
    try:
        return build(leave_out(axis.declared, **bounds), native=axis.native.enabled)
    except AxisidError as error:
        fixed = ", ".join(f"{name} at its bound {bound:g}" for name, bound in bounds.items())
        raise EstimationError(
            f"no axis can be identified with {fixed}: {str(error).rstrip('.')}. Check the signs "
            "and units of the record.",
            code="bounds",
        ) from error


def _with_free_covariances(estimate: Estimate, free: Estimate) -> Estimate:
    """Return an estimate with the covariances that its parameters have in the free estimate.

    Without the fixed parameters, other parameters may form a base parameter together that the free
    estimate does not have. The estimate is then returned unchanged.

    Parameters
    ----------
    estimate : Estimate
        Estimate with some parameters fixed at a bound.
    free : Estimate
        Estimate by the same method with no parameter fixed.
    """
    names = [q.name for q in free.quantities]
    ddm_names = [q.name for q in free.ddm_quantities]
    # Indices of the estimate's parameters among those of the free estimate.
    try:
        kept = [names.index(q.name) for q in estimate.quantities]
        kept_ddm = [ddm_names.index(q.name) for q in estimate.ddm_quantities]
    except ValueError:  # the free estimate has other base parameters
        return estimate
    return estimate.with_inference(
        covariances={n: each[np.ix_(kept, kept)] for n, each in free.covariances.items()},
        covariance_notes=free.covariance_notes,
        ddm_covariances={
            n: each[np.ix_(kept_ddm, kept_ddm)] for n, each in free.ddm_covariances.items()
        },
        freedom={n: each[kept] for n, each in free.freedom.items()},
        ddm_freedom={n: each[kept_ddm] for n, each in free.inference.ddm_freedom.items()},
    )


def _bounds_reached(axis: GeneratedAxis, estimate: Estimate) -> dict[str, float]:
    """Return the bounds, SI, of the parameters that the bounded estimate has at a bound, by name.

    The bounded estimate is the point within the bounds that is nearest to `estimate`, by the
    covariance for independent residuals. Only declared parameters have bounds; sums of parameters
    and local parameters have none. Empty where the estimate itself is within all bounds.
    """
    names, free = {p.name for p in axis.declared.parameters}, estimate.corrected
    declared = [p if p.name in names else None for p in estimate.form.declared]
    if all(p is None or p.allows(x) for p, x in zip(declared, free, strict=True)):
        return {}
    # Bounded minimum of the squared distance from the estimate, in standard errors.
    lower = np.array([-np.inf if p is None else p.lower for p in declared])
    upper = np.array([np.inf if p is None else p.upper for p in declared])
    covariance = estimate.covariances["iid"]
    scale = np.sqrt(np.diag(covariance))
    rows = np.linalg.pinv(covariance_root(covariance) / scale[:, None]) / scale
    _, sides = bounded_quadratic_minimum(lower, upper, free, rows, np.zeros(len(free)))
    return {
        p.name: p.lower if side < 0 else p.upper
        for p, side in zip(declared, sides, strict=True)
        if p and side
    }


def _parameter_at_bound(
    estimate: Estimate, axis: GeneratedAxis, name: str, bound: float
) -> ParameterAtBound:
    """Return the description of a parameter that is fixed at its bound.

    `estimate` is an estimate in which this parameter is free. The description has its free value,
    and the end of its one-sided 95 % confidence interval that begins at the bound.
    """
    value = estimate.parameters[name]
    is_lower = any((p.name, p.lower) == (name, bound) for p in axis.declared.parameters)
    dof = dict(zip(estimate.parameters, estimate.freedom[estimate.chosen], strict=True))[name]
    half_width = float(stdtrit(dof, INTERVAL_LEVEL.value)) * value.deviation
    end = value.corrected + (half_width if is_lower else -half_width)
    return ParameterAtBound(
        name=name,
        unit=value.unit,
        bound=bound,
        is_lower=is_lower,
        free=value.corrected,
        deviation=value.deviation,
        reach=max(bound, end) if is_lower else min(bound, end),
    )
