"""Estimates within declared bounds: what would go beyond one is held there, the rest identified.

The bounded estimate is the point within the bounds that is nearest to the free one, by the
covariance of independent residuals; of least squares that is the bounded least squares of the same
rows. What it has at a bound is held, the others are identified anew with it, until none goes beyond
its bound, and none that is held would come back.

What a bound holds is not known, so the others are as unsure as its parameter lets them be: they
have the covariance that they have without bounds. The bounded estimate is, by that covariance,
nearer to whatever is within the bounds than the free one is, so that it is enough.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis, Quantity, build
from axisid.estimation.estimates import Estimate
from axisid.estimation.problems import Held
from axisid.estimation.thresholds import INTERVAL_LEVEL
from axisid.modeling.declaration import leave_out
from axisid.modeling.quantities import Parameter
from axisid.support.arrays import Array
from axisid.support.errors import AxisidError, EstimationError

from .result import Identification

#: Identifies an axis, from records that it knows.
Identify = Callable[[GeneratedAxis], Identification]
_Bounds = Mapping[str, float]
_ROUNDING = 1e-13  # of a correlation matrix


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
    search = _BoundedSearch(axis, identify)
    bounds: dict[str, float] = {}
    for _ in range(2 * len(axis.declared.parameters)):
        if beyond := _at_bounds(axis, search.result(bounds).preferred):
            bounds |= beyond
            continue
        held = [search.held(name, bounds) for name in bounds]
        back = [each.name for each in held if not each.distance and each.is_inside]
        if not back:
            result = search.result(bounds)
            return _with_held(result, held, search.result({})) if held else result
        bounds = {name: bound for name, bound in bounds.items() if name != back[0]}
    raise EstimationError(
        f"which of {', '.join(bounds)} are at their bounds does not settle; identify without "
        "bounds, and leave out what the record does not show.",
        code="bounds-unsettled",
    )


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

    return replace(
        estimate.with_inference(
            covariances=of(free.covariances, places),
            covariance_names=free.covariance_names,
            ddm_covariances=of(free.ddm_covariances, own),
        ),
        freedom={name: freedom[places] for name, freedom in free.freedom.items()},
        ddm_freedom={name: freedom[own] for name, freedom in free.ddm_freedom.items()},
    )


def _places(names: Sequence[Quantity], among: Sequence[Quantity]) -> list[int] | None:
    """Where each is among others; None where one is not."""
    where = {quantity.name: i for i, quantity in enumerate(among)}
    return [where[q.name] for q in names] if all(q.name in where for q in names) else None


@dataclass(frozen=True, slots=True)
class _BoundedSearch:
    """Results with some parameters held, each made once."""

    axis: GeneratedAxis
    identify: Identify
    _made: dict[frozenset[tuple[str, float]], Identification] = field(default_factory=dict)

    def result(self, bounds: _Bounds) -> Identification:
        key = frozenset(bounds.items())
        if key not in self._made:
            self._made[key] = self.identify(self._with(bounds))
        return self._made[key]

    def held(self, name: str, bounds: _Bounds) -> Held:
        """A parameter at its bound, and what it is free, with the others at theirs."""
        others = {other: bound for other, bound in bounds.items() if other != name}
        (parameter,) = (p for p in self.axis.declared.parameters if p.name == name)
        return _held(self.result(others).preferred, parameter, bounds[name])

    def _with(self, bounds: _Bounds) -> GeneratedAxis:
        if not bounds:
            return self.axis
        try:
            return build(leave_out(self.axis.declared, **bounds), native=self.axis.native.enabled)
        except AxisidError as error:
            said = ", ".join(f"{name} at its bound {bound:g}" for name, bound in bounds.items())
            raise EstimationError(
                f"with {said} there is no axis left: {error.problem.rstrip('.')}. Check the signs "
                "and units of the record.",
                code="nothing-within-bounds",
            ) from error


def _at_bounds(axis: GeneratedAxis, estimate: Estimate) -> dict[str, float]:
    """Declared parameters that the bounded estimate has at a bound, with that bound."""
    from scipy.optimize import lsq_linear

    names = {p.name for p in axis.declared.parameters}
    declared = [p if p.name in names else None for p in estimate.form.declared]
    free = estimate.corrected
    if all(p is None or p.allows(x) for p, x in zip(declared, free, strict=True)):
        return {}
    lower = np.array([-np.inf if p is None else p.lower for p in declared])
    upper = np.array([np.inf if p is None else p.upper for p in declared])
    covariance = estimate.covariances["iid"]
    scale = np.sqrt(np.diag(covariance))
    sizes, directions = np.linalg.eigh(covariance / np.outer(scale, scale))
    root = directions.T / np.sqrt(np.maximum(sizes, _ROUNDING))[:, None]
    found = lsq_linear(root, root @ (free / scale), (lower / scale, upper / scale), "bvls")
    active = zip(declared, found.active_mask, strict=True)
    return {p.name: p.lower if side < 0 else p.upper for p, side in active if p and side}


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
