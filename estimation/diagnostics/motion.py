"""Whether the motion told the parameters apart, as checks."""

from collections.abc import Mapping, Sequence

import numpy as np

from axisid.estimation.estimates import FEW_ROWS, Estimate, Value, physical_parameters
from axisid.modeling.quantities import Parameter
from axisid.support.arrays import Array

from .check import Check, passed
from .excitation import Excitation

_MOST_CONDITION = 100.0
_MOST_RELATIVE_SD = 30.0  # percent
_NOTHING = 0.01  # of the force
_NOWHERE = 0.05  # of the largest force, anywhere along the record
_SMALL = 0.1  # of what the force and the motion make of the unit


def conditioning(X: Array) -> Check:
    """Condition number of the regressor with unit columns."""
    condition = float(np.linalg.cond(X / np.linalg.norm(X, axis=0)))
    excited = condition <= _MOST_CONDITION
    return Check(
        name="excitation",
        status=passed(excited),
        figure=condition,
        threshold=_MOST_CONDITION,
        source="condition number of unit columns below 100, common for exciting trajectories",
        meaning="the motion tells the parameters apart"
        if excited
        else "the motion hardly tells some parameters apart; record reversals, several speeds and "
        "acceleration",
    )


def precision(estimate: Estimate, shown: Sequence[Excitation]) -> Check:
    """Every parameter against its own deviation; a vague one with the reason."""
    values = estimate.parameters
    relative = {s.name: _relative_percent(s, values[s.name]) for s in shown}
    vague = [s for s in shown if relative[s.name] > _MOST_RELATIVE_SD]
    small = [s for s in vague if _is_nothing(s, values[s.name])]
    hidden = [s for s in vague if s not in small]
    worst = max(relative.values())
    return Check(
        name="precision",
        status=passed(not hidden),
        figure=worst if np.isfinite(worst) else None,
        threshold=_MOST_RELATIVE_SD,
        source="relative HAC deviation in percent, or the i.i.d. one where it is larger and few "
        "rows tell of the parameter; one whose part of the force is below 1 %, deviation "
        "included, may be as vague as it is, unless it could be as large as the unit allows",
        meaning="; ".join(
            f"{s.name} is not identified by this record, because {s.reason}" for s in hidden
        )
        or (
            f"{', '.join(s.name for s in small)} cannot be told from zero and is less than 1 % of "
            "the force; every other parameter stands well above its deviation"
            if small
            else "every parameter stands well above its deviation"
        ),
    )


def within_bounds(estimate: Estimate, cause: str = "") -> Check:
    """Every parameter against the bounds that it was declared with, physical ones too.

    `cause` is what to blame before signs and units, if anything is.
    """
    axis, values = estimate.form.axis, dict(estimate.parameters)
    physical = physical_parameters(estimate)
    if physical is not None:
        known = {p.name for p in axis.base.known}
        values |= {n: v for n, v in physical.parameters.items() if n not in {*values, *known}}
    bounded = {p.name: p for p in (*axis.base.declared.parameters, *axis.axis.parameters)}
    declared = [p for name, p in bounded.items() if p.is_bounded and name in values]
    outside = [p for p in declared if is_outside(p, values[p.name].value)]
    if not declared:
        return Check.missing("bounds", "no parameter is declared with bounds")
    return Check(
        name="bounds",
        status=passed(not outside),
        figure=float(len(outside)),
        threshold=0.0,
        source="declared physical bounds; parameters outside or at them, none is clipped",
        meaning="every parameter is within its declared bounds"
        if not outside
        else beyond_bounds({p: values[p.name].value for p in outside}, cause),
    )


def is_outside(parameter: Parameter, value: float) -> bool:
    """Whether a value is outside the bounds of its parameter, or at them."""
    return not parameter.lower < value < parameter.upper


def beyond_bounds(values: Mapping[Parameter, float], cause: str = "") -> str:
    """What to say of values outside the bounds of their parameters."""
    said = "; ".join(
        f"{p.name} = {value:.4g} {p.unit} is not within [{p.lower:g}, {p.upper:g}]"
        for p, value in values.items()
    )
    return f"{said}: {cause or 'check the signs and units of the record'}"


def _relative_percent(shown: Excitation, value: Value) -> float:
    """Relative deviation; in few rows residuals are small since the estimate follows them."""
    few = shown.rows < FEW_ROWS
    deviation = max(value.deviation, value.sd) if few else value.deviation
    return 100.0 * deviation / abs(value.value) if value.value else float("inf")


def _is_nothing(shown: Excitation, value: Value) -> bool:
    """Known to be small, not unknown: no other column and no missing motion hides it.

    A term that acts beyond the rows, or beyond the motion, is small in them whatever it is.
    """
    if shown.alike or shown.lacking or not value.value:
        return False
    largest = abs(value.value) + 2 * max(value.deviation, value.sd)
    times = largest / abs(value.value)
    return (
        shown.share * times < _NOTHING
        and shown.largest_share * times < _NOWHERE
        and largest < _SMALL * shown.natural
    )
