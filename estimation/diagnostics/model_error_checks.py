"""Checks of what a model leaves: terms, signals or samples that it lacks, and what repeats."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.estimates import Estimate, NotSimulated
from axisid.estimation.misspecification import LackOfFit, Misspecification, misspecification_text
from axisid.estimation.records import Record, advised_shift
from axisid.estimation.records.columns import scale_remedy
from axisid.estimation.signals import advice_on_rests
from axisid.estimation.thresholds import (
    MAX_MOVED_PERCENT,
    MAX_SIMULATION_ERROR,
    MIN_DISTANCE_FROM_NOISE,
    MIN_MODEL_SHARE,
)
from axisid.estimation.verdict_checks import DEFAULT_LEVELS, Check, Levels, status_of
from axisid.support.errors import Missing, unless_missing

from .agreement_of_estimates import method_check
from .alignment import declared_lateness
from .diagnostic_inputs import DiagnosticInputs

#: By check of what is lacking: what is said where there is nothing.
_NOTHING: Mapping[str, str] = {
    "missing terms": "nothing that was looked for is in the residuals",
    "recorded signals": "the recorded signals are in time with the forces that they make, and of "
    "their size",
    "outliers": "no single sample leaves its course",
}


def outliers_check(case: DiagnosticInputs) -> Check | Missing:
    """Whether single samples leave their course, by twins of the record."""
    if not isinstance(case.lacking, Missing) and not case.preferred.inference.chains:
        # HAC takes their size from the samples themselves.
        return Missing(
            "single samples are held against twins of the record, of which there are none"
        )
    return misspecification_check(
        case.lacking,
        "outliers",
        case.data.axis,
        case.data.record,
        case.levels,
        bounded=case.preferred.counts is not None,
    )


@unless_missing
def missing_terms_check(
    lacking: Sequence[Misspecification], case: DiagnosticInputs
) -> Check | Missing:
    """Whether the model lacks terms, unless what else is wrong may make them."""
    aligned = case.aligned  # which says how late, where it fails
    terms = [lack for lack in lacking if not (lack.kind == "delay" and fails(aligned))]
    found = misspecification_check(
        terms, "missing terms", case.data.axis, case.data.record, case.levels
    )
    if isinstance(found, Missing) or found.status != "fail":
        return found
    if fails(method_check(case.preferred, {}, {}, case.steps, case.levels, law_passed=None)):
        return replace(found, status="note")  # what the steps move is left, and counts once
    early = isinstance(aligned, Check) and fails(aligned) and (aligned.figure or 0.0) < 0
    if early and declared_lateness(case.data) > 0:  # friction is wrong at low speed then
        return replace(
            found,
            status="note",
            meaning=f"{found.meaning}; the delay or lag that is declared too long, see alignment, "
            "may make it: mend that first",
        )
    return found


def moved_parameters_check(
    found: Check | Missing | None, lacking: Sequence[Misspecification] | Missing
) -> Check | None:
    """Whether what the model lacks moves a parameter so far that its value means nothing.

    Parameters
    ----------
    found : Check or Missing or None
        Whether the model lacks terms: None is returned unless that fails.
    lacking : sequence of Misspecification or Missing
    """
    if not fails(found) or isinstance(lacking, Missing):
        return None
    most = MAX_MOVED_PERCENT.value
    own = [each for each in lacking if each.check == "missing terms"]
    worst = max(own, key=lambda each: each.moved_percent, default=None)
    if worst is None or worst.moved_percent <= most:
        return None
    does = "changes" if worst.parameter == worst.moved else "is moved"
    return Check(
        name="moved parameters",
        status="fail",
        figure=worst.moved_percent,
        threshold=most,
        source=MAX_MOVED_PERCENT.source,
        meaning=f"{worst.moved} {does} by {worst.moved_percent:.2g} % of its value by what the "
        f"model lacks. Do not use a value that is more than {most:g} % off: correct the model or "
        "the record first",
    )


def fails(found: Check | Missing | None) -> bool:
    """Whether it is a check that fails."""
    return isinstance(found, Check) and found.status == "fail"


@unless_missing
def misspecification_check(
    found: Sequence[Misspecification],
    name: str,
    axis: GeneratedAxis,
    record: Record,
    levels: Levels = DEFAULT_LEVELS,
    *,
    bounded: bool = False,
) -> Check:
    """Whether something of a kind is in the residuals that the model lacks.

    Parameters
    ----------
    found : sequence of Misspecification
        Of any kind.
    name : {"missing terms", "recorded signals", "outliers"}
        A term or a parameter that changes; a recorded signal that is late or of another size; or a
        single sample of what was measured that leaves its course.
    axis : GeneratedAxis
    record : Record
    levels : Levels
    bounded : bool
        Whether the loss has bounded what outliers do, which are no more than a note then.
    """
    own = [lack for lack in found if lack.check == name]
    meaning = "; ".join(misspecification_text(lack, axis, record) for lack in own) or _NOTHING[name]
    if own and name == "recorded signals":
        meaning += f": {_advice(axis, record, own[0])}"
    elif own and name == "outliers" and not bounded:
        meaning += (
            '; empty such cells and read with resample="auto", or let such rows count for '
            'less, loss="huber"'
        )
    return Check(
        name=name,
        status=status_of(not own, matters=not bounded),
        figure=100 * max((lack.own_share for lack in own), default=0.0),
        threshold=100 * levels.least_share,
        p_value=min((lack.p_value for lack in own), default=None),
        source="percent of the force, root mean square; fails where the residuals hold more of it "
        f"than those of twins (Hotelling's test, {100 * levels.level:g} % over all that is looked "
        f"for, by Holm's rule) and it is more than {100 * levels.least_share:g} % of the force "
        "beside what the parameters make of it, or moves one by more than its interval",
        meaning=meaning,
    )


def _advice(axis: GeneratedAxis, record: Record, found: Misspecification) -> str:
    value, deviation, name = found.values[0], found.deviation, found.parameter
    if found.at_the_end:
        return (
            f"check that the column of {name} is the right one, and its clock. Check first what "
            "else fails"
        )
    if found.kind == "late signal":
        return advised_shift(name, value, max(MIN_DISTANCE_FROM_NOISE.value * deviation, 0.5))
    column = record.provenance.columns.get(name, "NAME")
    (declared,) = (s for s in axis.signals if s.name == name)
    # A factor within 2 % of that of another unit is that.
    vague = 0.02 + MIN_DISTANCE_FROM_NOISE.value * deviation / abs(value)
    return scale_remedy(name, column, str(declared.unit), 1 / value, vague) or (
        f"check its unit and its scale (columns {name}={column}:UNIT*{value:.4g}), and what is "
        "declared as known of its force"
    )


def lack_of_fit_check(found: LackOfFit | None, preferred: Estimate) -> Check | None:
    """How much of what is left is the model's, by what is left again where the motion repeats."""
    if found is None:
        return None
    coordinate = preferred.form.axis.coordinate
    unit = coordinate.acceleration_unit if preferred.is_direct else coordinate.force_unit
    noise = f"{found.noise:.2g} {unit} is noise"
    again = "repeats" if found.period is None else f"repeats every {found.period:.4g} s"
    return Check(
        name="lack of fit",
        status=status_of(not found.is_mostly_model, matters=False),
        figure=100 * found.share,
        threshold=100 * MIN_MODEL_SHARE.value,
        source="percent of the residuals' power that is left again where the reference repeats, "
        "from the products of residuals of different repeats; it counts where noise "
        "repeats as much but for a chance of 1e-3 (HAC over the phases), and where it goes on from "
        "row to row",
        meaning=f"{100 * found.share:.0f} % of what the model leaves is the model: "
        f"{found.repeated:.2g} {unit} ({100 * found.repeated / found.left:.2g} % of the "
        f"{preferred.form.left}) {again}, {noise}"
        if found.is_mostly_model
        else f"{found.repeated:.2g} {unit} of what the model leaves {again} but jumps from "
        f"row to row, as the steps of an encoder do, {noise}"
        if found.is_there and not found.is_smooth
        else f"most of what the model leaves is noise: {found.repeated:.2g} {unit} {again}, {noise}"
        if found.is_there
        else f"what the model leaves is noise: nothing of it {again}, {noise}",
    )


def simulation_error_check(
    preferred: Estimate, rest: float, *, misspecified: bool = False
) -> Check | Missing:
    """The simulation error of an estimate.

    Parameters
    ----------
    preferred : Estimate
    rest : float
        Part of the record's samples at which the axis stands.
    misspecified : bool
        Whether the model lacks something under a law that is right, from which this follows.
    """
    simulated, form = preferred.simulated, preferred.form
    cause = "mend first what the model lacks, which may make it" * misspecified
    if isinstance(simulated, NotSimulated):
        failed = Check(
            name="simulation",
            status="fail",
            source="an axis that was recorded can be simulated",
            meaning="the loop cannot be simulated with the estimate, as that of an axis that was "
            f"recorded can: {str(simulated).removesuffix('.')}{f'; {cause}' * misspecified}",
        )
        return failed if simulated.by_estimate else simulated
    error = preferred.simulation_error_percent or 0.0  # none but where nothing was simulated
    good = error < MAX_SIMULATION_ERROR.value
    but = f" but for {error:.2g} %" * (error >= 10.0)  # less is not said
    units = form.axis.coordinate.unit, form.axis.drive.unit
    noise = "".join(f" ({chain.told(*units)})" for chain in preferred.inference.chains[:1])
    blamed = (
        advice_on_rests(rest)
        or cause
        or f"check the law, signs and units, or see whether the record is noise{noise}, or a "
        "motion that the model does not have"
    )
    return Check(
        name="simulation",
        status=status_of(good),
        figure=error,
        threshold=MAX_SIMULATION_ERROR.value,
        source="simulation error in percent of the left side; at 50 the loop explains three "
        "quarters of its power, at 100 nothing",
        meaning=f"the simulated loop follows the record{but}"
        if good
        else f"the simulated loop leaves {error:.3g} % of the {form.left} unexplained; {blamed}",
    )
