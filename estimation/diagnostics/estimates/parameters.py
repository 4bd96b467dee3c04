"""Parameters against what was declared of them: bounds, values, the drive's gain; as checks."""

from collections.abc import Iterable, Sequence

import numpy as np

from axisid.estimation.checks import Check, passed
from axisid.estimation.estimates import Estimate, Physical, physical_parameters
from axisid.estimation.parameters import GAIN
from axisid.estimation.problems import Held
from axisid.estimation.thresholds import LEVEL, MIN_DISTANCE_FROM_NOISE
from axisid.modeling.declaration import Drive, known_text
from axisid.modeling.quantities import Parameter
from axisid.support.missing import Missing
from axisid.support.remedy import Note, Remedy, Setting

_MAX_FROM_NOMINAL = 5.0  # times the nominal value, of the whole interval
NOMINAL_VALUES = "nominal values"
# between identified and declared drive gain; beyond, a known value is of another record
_MAX_GAIN_RATIO = 2.0


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
    reaching = [values[p.name].interval for p in outside]
    if outside and all(
        low < p.upper and high > p.lower for p, (low, high) in zip(outside, reaching, strict=True)
    ):
        cause = Note(
            f"the 95 % interval of {'each' if len(outside) > 1 else 'it'} reaches within; ",
            Remedy.of("to hold it at the bound, ", Setting("bounded")),
        )
    said = Note("every parameter is within its declared bounds")
    if outside:
        listed = "; ".join(p.out_of_bounds(values[p.name].corrected) for p in outside)
        said = Note.of(f"{listed}: ", cause or "check the signs and units of the record")
    return Check(
        name="bounds",
        status=passed(not outside),
        figure=float(len(outside)),
        threshold=0.0,
        source="declared physical bounds; parameters outside or at them, none is clipped",
        meaning=said.text,
        remedy=said.remedy,
    )


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


def fixed_check(estimate: Estimate, level: float = LEVEL.value) -> Check | Missing | None:
    """Whether the record contradicts what was fixed; nothing if nothing could be asked."""
    physical = physical_parameters(estimate.method, estimate.form, estimate.distribution)
    if physical is None or not (physical.base.known or physical.dof):
        return None
    if physical.p_value is None:
        why = "the record alone does not determine what was fixed, so that it cannot contradict it"
        return Missing(physical.undetermined[-1] if physical.undetermined else why)
    good = physical.p_value >= level
    return Check(
        name="fixed values" if physical.base.known else "physical parameters",
        status=passed(good),
        figure=physical.statistic,
        threshold=None,
        p_value=physical.p_value,
        source=f"Hotelling's T squared with {physical.dof} restrictions, covariance of the "
        "estimate and declared deviations, less the bias of filter and noise; fails below "
        f"{100 * level:g} %",
        meaning="the record agrees with them" if good else _contradiction(physical, estimate),
    )


def _contradiction(physical: Physical, estimate: Estimate) -> str:
    """What was fixed beside what the record alone says of it, where it says anything."""
    sides = []
    for p in physical.base.known:
        said = f"{p.name} is fixed at {known_text(p)} {p.unit}"
        if alone := estimate.parameters.get(p.name):
            deviation = np.hypot(alone.deviation, alone.sd_gain)
            said += f", the record alone gives {alone.corrected:.4g} +- {deviation:.2g}"
        sides.append(said)
    what = f": {'; '.join(sides)}" if sides else ""
    unknown = "; its bias, which could do it too, is not known without a control law"
    return (
        f"no values of the parameters agree with the record{' and what was fixed' * bool(sides)} "
        f"(squared distance {physical.statistic:.3g}, restrictions {physical.dof}){what}. "
        "Check what was fixed, the drive gain and the terms of the model"
        f"{unknown * (estimate.filter_bias is None)}"
    )


def nominal_check(
    found: Iterable[tuple[Parameter, float, tuple[float, float]]],
) -> Check | None:
    """Remark values that are another order of size than declared; None where none is.

    A column in another unit makes such values, which nothing else tells where no law is simulated.
    Of parameters that may have either sign, such as an offset, any size is as declared.

    Parameters
    ----------
    found : iterable of (Parameter, float, (float, float))
        Each with its value and its interval, all of which is as far.
    """
    most, far = _MAX_FROM_NOMINAL, dict[Parameter, float]()
    for parameter, value, interval in found:
        if parameter.lower >= 0 < parameter.nominal:
            ratio, *ends = np.array([value, *interval]) / parameter.nominal
            if min(ratio, *ends) > most or max(ratio, *ends) < 1 / most:
                far[parameter] = float(ratio)
    if not far:
        return None
    listed = ", ".join(
        f"{p.name} = {ratio * p.nominal:.4g} {p.unit} is {ratio:.2g} times its nominal "
        f"{p.nominal:.4g}"
        for p, ratio in far.items()
    )
    return Check(
        name=NOMINAL_VALUES,
        status="note",
        figure=next(iter(far.values())),
        threshold=most,
        source="chosen: units are apart by 6.28, 9.81, 57.3 or powers of ten",
        meaning=f"{listed}: check the units of the record's columns and the drive's gain, or "
        "declare another nominal value",
    )


def gain_check(estimate: Estimate, drive: Drive) -> Check | None:
    """Whether the identified gain is the declared one; None where none is identified.

    The parameters are of the identified gain whatever comes of it.
    """
    if GAIN not in estimate.parameters:
        return None
    value = estimate.parameters[GAIN]
    deviation = float(np.hypot(value.deviation, drive.relative_sd * drive.gain))
    distance = abs(value.corrected - drive.gain) / deviation if deviation > 0 else np.inf
    same = distance <= MIN_DISTANCE_FROM_NOISE.value
    ratio = value.corrected / drive.gain
    near = 1 / _MAX_GAIN_RATIO < ratio < _MAX_GAIN_RATIO
    said = f"the drive gain is {value.corrected:.5g} +- {value.deviation:.2g} {value.unit}"
    if not near:
        said += (
            f", and {drive.gain:g} is declared: check that the known values are in the order of "
            "the records, and their units"
        )
    return Check(
        name="drive gain",
        status=passed(same, matters=not near),
        figure=distance if np.isfinite(distance) else None,
        threshold=MIN_DISTANCE_FROM_NOISE.value,
        source="distance of the identified gain from the declared one, in deviations of both; a "
        "note, and a failure where one is twice the other or more, or of the other sign",
        meaning="the identified gain is the declared one"
        if same
        else said
        if not near
        else f"{said}, {100 * (ratio - 1):+.2g} % from the declared {drive.gain:g}: the parameters "
        "are of the identified one; declare it for what is identified without a known force",
    )
