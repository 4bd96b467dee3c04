"""Parameters against the bounds that they were declared with, as a check."""

from collections.abc import Mapping, Sequence

from axisid.estimation.checks import Check, passed
from axisid.estimation.estimates import Estimate, Value, physical_parameters
from axisid.estimation.problems import Held
from axisid.estimation.thresholds import MIN_DISTANCE_FROM_NOISE
from axisid.modeling.quantities import Parameter
from axisid.support.missing import Missing
from axisid.support.remedy import Note, Remedy, Setting


def within_bounds(
    estimate: Estimate, cause: Note | None, held: Sequence[Held] = ()
) -> Check | Missing:
    """Every parameter against the bounds that it was declared with, physical ones too.

    Parameters
    ----------
    estimate : Estimate
    cause : Note
        What to blame before signs and units, if anything is.
    held : sequence of Held
        Parameters that are none of the estimate, since they are held at a bound.
    """
    axis, values = estimate.form.axis, dict(estimate.parameters)
    physical = physical_parameters(estimate.method, estimate.form, estimate.distribution)
    if physical is not None:
        known = {p.name for p in axis.base.known}
        values |= {n: v for n, v in physical.parameters.items() if n not in {*values, *known}}
    bounded = {p.name: p for p in (*axis.base.declared.parameters, *estimate.form.declared)}
    declared = [p for name, p in bounded.items() if p.is_bounded and name in values]
    outside = [p for p in declared if not p.is_inside(values[p.name].corrected)]
    if held and not outside:
        return _held_check(held, cause)
    if not declared:
        return Missing("no parameter is declared with bounds")
    if outside and all(_may_be_inside(p, values[p.name]) for p in outside):
        cause = Note(
            f"the 95 % interval of {'each' if len(outside) > 1 else 'it'} reaches within; ",
            Remedy.of("to hold it at the bound, ", Setting("bounded")),
        )
    within = Note("every parameter is within its declared bounds")
    said = bounds_note({p: values[p.name].corrected for p in outside}, cause) if outside else within
    return Check(
        name="bounds",
        status=passed(not outside),
        figure=float(len(outside)),
        threshold=0.0,
        source="declared physical bounds; parameters outside or at them, none is clipped",
        meaning=said.text,
        remedy=said.remedy,
    )


def bounds_note(values: Mapping[Parameter, float], cause: Note | None) -> Note:
    """What to say of values that are not inside the bounds of their parameters."""
    said = "; ".join(p.out_of_bounds(value) for p, value in values.items())
    return Note.of(f"{said}: ", cause or "check the signs and units of the record")


def _may_be_inside(parameter: Parameter, value: Value) -> bool:
    low, high = value.interval
    return low < parameter.upper and high > parameter.lower


def _held_check(held: Sequence[Held], cause: Note | None) -> Check:
    """Parameters at their bounds: what chance takes there, or what contradicts the bound."""
    farthest = max(each.distance for each in held)
    against = farthest > MIN_DISTANCE_FROM_NOISE.value
    said = Note.of("; ".join(each.text for each in held))
    if against:
        blamed = cause or "check the signs and units of the record, and what the model lacks"
        said = Note.of(f"{said.text}, {farthest:.2g} deviations beyond: ", blamed)
    return Check(
        name="bounds",
        status="fail" if against else "note",
        figure=farthest,
        threshold=MIN_DISTANCE_FROM_NOISE.value,
        source="deviations by which a parameter that is held would be beyond its bound",
        meaning=said.text,
        remedy=said.remedy,
    )
