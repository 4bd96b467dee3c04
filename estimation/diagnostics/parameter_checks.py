"""What is printed of each parameter, against what was declared of it and how surely it is known.

Too few rows, a value within its own deviation, one beyond its bounds or of another order of size
than declared, a record that contradicts what was fixed, and a drive gain that is not the declared
one.
"""

from collections.abc import Iterable, Sequence

import numpy as np

from axisid.estimation.diagnostic_checks import Check, status_of
from axisid.estimation.estimates import Estimate, Value, physical_parameters
from axisid.estimation.estimation_problem import ParameterAtBound
from axisid.estimation.parameters import GAIN
from axisid.estimation.thresholds import (
    CHECK_LEVEL,
    MAX_RELATIVE_DEVIATION,
    MIN_DISTANCE_FROM_NOISE,
    MIN_ROWS_PER_PARAMETER,
    NEGLIGIBLE_FORCE,
    NEGLIGIBLE_PEAK_FORCE,
)
from axisid.modeling.declaration import Drive, known_text
from axisid.modeling.quantities import Parameter
from axisid.support.errors import Missing, first_case

from .parameter_excitation import Excitation

_NEGLIGIBLE_SIZE = 0.1  # of a vague parameter, in what force and motion make of its unit
_MAX_FROM_NOMINAL = 5.0  # times the nominal value, of the whole interval
NOMINAL_VALUES = "nominal values"
# between identified and declared drive gain; beyond, a known value is of another record
_MAX_GAIN_RATIO = 2.0


def rows_check(rows: int, parameters: int, remedy: str) -> Check | None:
    """Whether rows are enough to tell how sure so many parameters are."""
    if rows >= MIN_ROWS_PER_PARAMETER.value * parameters:
        return None
    return Check(
        name="rows",
        status="fail",
        figure=rows / parameters,
        threshold=MIN_ROWS_PER_PARAMETER.value,
        source=MIN_ROWS_PER_PARAMETER.source,
        meaning=f"{rows} rows for {parameters} parameters are few: standard deviations cannot be "
        f"believed; {remedy}",
    )


def precision(estimate: Estimate, excitation: Sequence[Excitation]) -> Check:
    """Every parameter against its own deviation; a vague one with the reason."""
    values, relative = estimate.parameters, dict[str, float]()
    for s in excitation:
        value = values[s.name]
        # In few rows residuals are small since the estimate follows them.
        few = s.rows < MIN_ROWS_PER_PARAMETER.value
        deviation = max(value.deviation, value.sd) if few else value.deviation
        relative[s.name] = 100 * deviation / abs(value.corrected) if value.corrected else np.inf
    vague = [s for s in excitation if relative[s.name] > MAX_RELATIVE_DEVIATION.value]
    small = [s for s in vague if _is_nothing(s, values[s.name])]
    by_reason: dict[str, list[str]] = {}
    for s in vague:
        if s not in small:
            by_reason.setdefault(s.reason, []).append(s.name)
    return precision_check(
        max(relative.values()),
        [
            f"{'none of ' * (len(names) > 1)}{', '.join(names)} is {'not ' * (len(names) == 1)}"
            f"identified by this record, because {reason}"
            for reason, names in by_reason.items()
        ],
        [s.name for s in small],
        "force",
        "relative HAC deviation in percent, or the i.i.d. one where it is larger and few "
        "rows tell of the parameter; one whose part of the force is below 1 %, deviation "
        "included, may be as vague as it is, unless it could be as large as the unit allows",
    )


def precision_check(
    worst: float, unclear: Sequence[str], small: Sequence[str], of: str, source: str
) -> Check:
    """The check of parameters against their deviations.

    Parameters
    ----------
    worst : float
        Largest relative deviation, %.
    unclear : sequence of str
        What is said of each parameter that is not known.
    small : sequence of str
        Names of those that are as vague, and matter little.
    of : str
        What these are less than 1 % of.
    source : str
        What the figure is.
    """
    clear = first_case(
        (not small, "every"),
        (
            True,
            f"{', '.join(small)} cannot be told from zero and is less than 1 % of the {of}; every "
            "other",
        ),
    )
    return Check(
        name="precision",
        status=status_of(not unclear),
        figure=worst if np.isfinite(worst) else None,
        threshold=MAX_RELATIVE_DEVIATION.value,
        source=source,
        meaning="; ".join(unclear) or f"{clear} parameter stands well above its deviation",
    )


def _is_nothing(excitation: Excitation, value: Value) -> bool:
    """Known to be small, not unknown: no other column and no missing motion hides it.

    A term that acts beyond the rows, or beyond the motion, is small in them whatever it is.
    """
    if excitation.alike or excitation.lacking or not value.value:
        return False
    largest = abs(value.value) + 2 * max(value.deviation, value.sd)
    times = largest / abs(value.value)
    return (
        excitation.share * times < NEGLIGIBLE_FORCE.value
        and excitation.largest_share * times < NEGLIGIBLE_PEAK_FORCE.value
        and largest < _NEGLIGIBLE_SIZE * excitation.natural
    )


def within_bounds(
    estimate: Estimate, cause: str | None, held: Sequence[ParameterAtBound] = ()
) -> Check | Missing:
    """Every parameter against the bounds that it was declared with, physical ones too.

    Parameters
    ----------
    estimate : Estimate
    cause : str
        What to blame before signs and units, if anything is.
    held : sequence of ParameterAtBound
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
        return at_bound_check(held, cause)
    if not declared:
        return Missing("no parameter is declared with bounds")
    reaching = zip(outside, (values[p.name].interval for p in outside), strict=True)
    if outside and all(low < p.upper and high > p.lower for p, (low, high) in reaching):
        cause = (
            f"the 95 % interval of {'each' if len(outside) > 1 else 'it'} reaches within; "
            "leave it at the bound with bounded"
        )
    listed = "; ".join(p.out_of_bounds(values[p.name].corrected) for p in outside)
    return Check(
        name="bounds",
        status=status_of(not outside),
        figure=float(len(outside)),
        threshold=0.0,
        source="declared physical bounds; parameters outside or at them, none is clipped",
        meaning=f"{listed}: {cause or 'check signs and units of the record and the drive gain'}"
        if outside
        else "every parameter is within its declared bounds",
    )


def at_bound_check(held: Sequence[ParameterAtBound], cause: str | None = None) -> Check:
    """Parameters at their bounds: what chance takes there, or what contradicts the bound.

    Parameters
    ----------
    held : sequence of ParameterAtBound
        One at least.
    cause : str, optional
        What to blame before signs and units.
    """
    farthest = max(each.distance for each in held)
    against = farthest > MIN_DISTANCE_FROM_NOISE.value
    blamed = cause or "check the signs and units of the record, and what the model lacks"
    return Check(
        name="bounds",
        status="fail" if against else "note",
        figure=farthest,
        threshold=MIN_DISTANCE_FROM_NOISE.value,
        source="deviations by which a parameter that is held would be beyond its bound",
        meaning="; ".join(each.text for each in held)
        + f", {farthest:.2g} deviations beyond: {blamed}" * against,
    )


def fixed_check(estimate: Estimate, level: float = CHECK_LEVEL.value) -> Check | Missing | None:
    """Whether the record contradicts what was fixed; nothing if nothing could be asked."""
    physical = physical_parameters(estimate.method, estimate.form, estimate.distribution)
    if physical is None or not (physical.known or physical.dof):
        return None
    if physical.p_value is None:
        why = "the record alone does not determine what was fixed, so that it cannot contradict it"
        return Missing([why, *physical.undetermined][-1])
    sides = []
    for p in physical.known:
        sides.append(f"{p.name} is fixed at {known_text(p.known, p.known_sd)} {p.unit}")
        if alone := estimate.parameters.get(p.name):
            deviation = np.hypot(alone.deviation, alone.sd_gain)
            sides[-1] += f", the record alone gives {alone.corrected:.4g} +- {deviation:.2g}"
    fault = (
        f"no values of the parameters agree with the record{' and what was fixed' * bool(sides)} "
        f"(squared distance {physical.statistic:.3g}, restrictions {physical.dof})"
        f"{': ' * bool(sides)}{'; '.join(sides)}. "
        "Check what was fixed, the drive gain and the terms of the model"
        + "; its bias, which could do it too, is not known without a control law"
        * (estimate.filter_bias is None)
    )
    good = physical.p_value >= level
    return Check(
        name="fixed values" if physical.known else "physical parameters",
        status=status_of(good),
        figure=physical.statistic,
        threshold=None,
        p_value=physical.p_value,
        source=f"Hotelling's T squared with {physical.dof} restrictions, covariance of the "
        "estimate and declared deviations, less the bias of filter and noise; fails below "
        f"{100 * level:g} %",
        meaning="the record agrees with them" if good else fault,
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
    found = f"the drive gain is {value.corrected:.5g} +- {value.deviation:.2g} {value.unit}"
    said = first_case(
        (same, "the identified gain is the declared one"),
        (
            near,
            f"{found}, {100 * (ratio - 1):+.2g} % from the declared {drive.gain:g}: the parameters "
            "are of the identified one; declare it for what is identified without a known force",
        ),
        (
            True,
            f"{found}, and {drive.gain:g} is declared: check that the known values are in the "
            "order of the records, and their units",
        ),
    )
    return Check(
        name="drive gain",
        status=status_of(same, matters=not near),
        figure=distance if np.isfinite(distance) else None,
        threshold=MIN_DISTANCE_FROM_NOISE.value,
        source="distance of the identified gain from the declared one, in deviations of both; a "
        "note, and a failure where one is twice the other or more, or of the other sign",
        meaning=said,
    )
