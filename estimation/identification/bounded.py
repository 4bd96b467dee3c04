"""Estimates within declared bounds: what would go beyond one is held there, the rest identified.

The bounded estimate is the point within the bounds that is nearest to the free one, by the
covariance of independent residuals; of least squares that is the bounded least squares of the same
rows. What it has at a bound is held, the others are identified anew with it, until none goes beyond
its bound, and none that is held would come back.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis, build
from axisid.estimation.estimates import Estimate
from axisid.estimation.problems import Held
from axisid.estimation.thresholds.estimates import INTERVAL_LEVEL
from axisid.modeling.declaration import leave_out
from axisid.modeling.quantities import Parameter
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
    search = _Search(axis, identify)
    bounds: dict[str, float] = {}
    for _ in range(2 * len(axis.declared.parameters)):
        if beyond := _at_bounds(axis, search.result(bounds).preferred):
            bounds |= beyond
            continue
        held = [search.held(name, bounds) for name in bounds]
        back = [each.name for each in held if not each.distance and each.is_inside]
        if not back:
            result = search.result(bounds)
            return replace(result, problem=replace(result.problem, held=tuple(held)))
        bounds = {name: bound for name, bound in bounds.items() if name != back[0]}
    raise EstimationError(
        f"which of {', '.join(bounds)} are at their bounds does not settle; identify without "
        "bounds, and leave out what the record does not show.",
        code="bounds-unsettled",
    )


@dataclass(frozen=True, slots=True)
class _Search:
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
