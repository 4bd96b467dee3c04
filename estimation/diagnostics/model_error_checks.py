"""Checks of the residual and of the simulated loop: missing terms, late signals, outliers.

A misspecification is an error of the model or of a measured column that the residual shows: a
missing term, a parameter that changes, a signal that is late or scaled wrongly, or an outlier.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.estimates import Estimate, NotSimulated
from axisid.estimation.findings import Finding
from axisid.estimation.misspecification import (
    ChangedParameter,
    LackOfFit,
    LateSignal,
    MissingTerm,
    Misspecification,
    OutlyingSample,
    ScaledSignal,
    misspecification_finding,
)
from axisid.estimation.noise_models import NoiseSources, noise_sources
from axisid.estimation.records import Record
from axisid.estimation.signals import RestingAxis, resting_axis
from axisid.estimation.thresholds import (
    MAX_MOVED_PERCENT,
    MAX_SIMULATION_ERROR,
    MIN_MODEL_SHARE,
)
from axisid.estimation.verdict_checks import DEFAULT_LEVELS, Check, Levels, status_of
from axisid.support.missing import Missing, unless_missing

from .agreement_of_estimates import method_check
from .alignment import declared_lateness
from .diagnostic_inputs import DiagnosticInputs


@dataclass(frozen=True, slots=True, kw_only=True)
class MissingTerms(Finding):
    """Missing terms, and parameters that change in the record or have a wrong given value.

    Attributes
    ----------
    found : tuple of MissingTerm or ChangedParameter
        In the order of the part of the force that they explain, the largest first; empty for none.
    may_be_long_delay : bool
        Whether the cause may be a delay or lag of the drive that is declared too long.
    """

    found: tuple[MissingTerm | ChangedParameter, ...]
    may_be_long_delay: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedSignals(Finding):
    """Recorded signals that are late, early, or scaled wrongly relative to their force.

    Attributes
    ----------
    found : tuple of LateSignal or ScaledSignal
        In the order of the part of the force that they explain, the largest first; empty for none.
    """

    found: tuple[LateSignal | ScaledSignal, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Outliers(Finding):
    """Single samples of a measured column that do not fit the samples around them.

    Attributes
    ----------
    found : tuple of OutlyingSample
        The outliers; empty for none.
    is_bounded : bool
        Whether the loss of the estimate bounds the effect of outliers.
    """

    found: tuple[OutlyingSample, ...]
    is_bounded: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class MovedParameter(Finding):
    """The parameter with the largest change by a missing term, or in the course of the record.

    Attributes
    ----------
    parameter : str
        Name of the parameter.
    percent : float
        Change in percent of the value of the parameter.
    most_percent : float
        Change above which the value must not be used, percent.
    is_changing : bool
        Whether the parameter itself changes in the course of the record; otherwise a missing term
        changes the estimate.
    values : (float, float, float) or None
        Value of the parameter without the missing term, with it, and with all missing terms that
        were found; None for a parameter that changes in the course of the record.
    unit : str
        Unit of the parameter.
    cause : Finding or None
        The missing term; None where it is not known.
    """

    parameter: str
    percent: float
    most_percent: float
    is_changing: bool
    values: tuple[float, float, float] | None = None
    unit: str = ""
    cause: Finding | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ResidualAtRepeats(Finding):
    """Split of the residual into a part that repeats with the motion, and noise.

    Attributes
    ----------
    nature : {"systematic", "steps", "small", "none"}
        ``systematic``: most of the residual repeats and is smooth, so that the model is incomplete.
        ``steps``: a part of the residual repeats but is not smooth, as with encoder steps.
        ``small``: a small, smooth part of the residual repeats. ``none``: no significant part
        repeats.
    percent : float
        Power of the part that repeats, in percent of the residual's power.
    repeated, noise : float
        Root mean squares of the repeating part and of the noise, in `unit`.
    repeated_percent : float
        `repeated` in percent of the root mean square of the left side of the equations.
    unit : str
        Unit of the left side.
    left : str
        Name of the left side, "force" or "acceleration".
    period : float or None
        Period of the motion, s; None where the motion repeats after pauses of different lengths.
    """

    nature: Literal["systematic", "steps", "small", "none"]
    percent: float
    repeated: float
    noise: float
    repeated_percent: float
    unit: str
    left: str
    period: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulatedLoop(Finding):
    """Simulation error of the closed loop along the record.

    Attributes
    ----------
    percent : float
        Simulation error, in percent of the left side of the equations (rms).
    left : str
        Name of the left side, "force" or "acceleration".
    reproduces : bool
        Whether the error is below the threshold.
    is_misspecified : bool
        Whether the model is incomplete while the control law is correct, which may be the cause.
    rest : RestingAxis or None
        An axis that rests in too many samples, which may be the cause; None for no such axis.
    noise : NoiseSources or None
        Noise sources of the record; None where they were not measured.
    """

    percent: float
    left: str
    reproduces: bool
    is_misspecified: bool
    rest: RestingAxis | None
    noise: NoiseSources | None


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopNotSimulated(Finding):
    """A closed loop that cannot be simulated with the estimate.

    Attributes
    ----------
    reason : str
        Reason why the simulation failed.
    is_misspecified : bool
        Whether the model is incomplete while the control law is correct, which may be the cause.
    """

    reason: str
    is_misspecified: bool


def outliers_check(case: DiagnosticInputs) -> Check | Missing:
    """Return the check for outliers among single samples of the measured columns.

    Missing without simulated replicas of the record, with which the samples are compared.
    """
    if not isinstance(case.lacking, Missing) and not case.preferred.inference.chains:
        # A HAC covariance would be estimated from the outliers themselves.
        return Missing(
            "the check compares single samples with simulated replicas of the record, and there "
            "are no replicas"
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
    """Return the check for missing terms; a note if another failed check gives a sufficient cause.

    Such a cause is the quantisation of the position, by the check of the method, or a delay of the
    drive that is declared too long, by the check of the alignment. A missing delay is not counted
    where the check of the alignment already fails.

    Parameters
    ----------
    lacking : sequence of Misspecification
        Misspecifications of any kind.
    case : DiagnosticInputs
        Inputs of the record.
    """
    aligned = case.aligned  # reports the delay where it fails
    terms = [lack for lack in lacking if not (lack.kind == "delay" and fails(aligned))]
    found = misspecification_check(
        terms, "missing terms", case.data.axis, case.data.record, case.levels
    )
    if isinstance(found, Missing) or found.status != "fail":
        return found
    if fails(method_check(case.preferred, {}, {}, case.steps, case.levels, law_passed=None)):
        # The bias by quantisation increases the residual. The check of the method reports it.
        return replace(found, status="note")
    # The force acts earlier than the hold assumes; the friction at low speed is then wrong.
    is_early = isinstance(aligned, Check) and fails(aligned) and (aligned.figure or 0.0) < 0
    if is_early and declared_lateness(case.data) > 0:
        finding = _missing_terms(terms, case.data.axis, case.data.record)
        return replace(found, status="note", finding=replace(finding, may_be_long_delay=True))
    return found


def moved_parameters_check(
    found: Check | Missing | None,
    lacking: Sequence[Misspecification] | Missing,
    axis: GeneratedAxis,
    record: Record,
) -> Check | None:
    """Return a failed check if a missing term makes the value of a parameter useless.

    None if no parameter changes as much, or if the check of missing terms does not fail.

    Parameters
    ----------
    found : Check or Missing or None
        Check of missing terms.
    lacking : sequence of Misspecification or Missing
        Misspecifications of any kind, or the reason why they are not known.
    axis : GeneratedAxis
    record : Record
    """
    if not fails(found) or isinstance(lacking, Missing):
        return None
    most = MAX_MOVED_PERCENT.value
    terms = [each for each in lacking if each.check == "missing terms"]
    worst = max(terms, key=lambda each: each.moved_percent, default=None)
    if worst is None or worst.moved_percent <= most:
        return None
    name = worst.moved
    is_changing = worst.parameter == name
    values: tuple[float, float, float] | None = None
    last = lacking[-1].parameters
    if not is_changing and name in worst.parameters and name in last:
        # A parameter that differs between directions has two values.
        after, with_all = (float(np.mean(each[name])) for each in (worst.parameters, last))
        values = (worst.moved_value, after, with_all)
    return Check(
        name="moved parameters",
        status="fail",
        figure=worst.moved_percent,
        threshold=most,
        source="largest change of a parameter in percent of its value, by a missing term or in the "
        f"course of the record. The check fails above {most:g} %, the relative standard error up "
        "to which a parameter is identified. A value with a larger error is no property of the "
        "axis",
        finding=MovedParameter(
            parameter=name,
            percent=worst.moved_percent,
            most_percent=most,
            is_changing=is_changing,
            values=values,
            unit=next((str(q.unit) for q in axis.parameters if q.name == name), ""),
            cause=None if is_changing else misspecification_finding(worst, axis, record),
        ),
    )


def fails(found: Check | Missing | None) -> bool:
    """Return True for a failed check; False for any other check, a `Missing` or None."""
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
    """Return the check for one kind of misspecification, which fails where one was found.

    Parameters
    ----------
    found : sequence of Misspecification
        Misspecifications of any kind.
    name : {"missing terms", "recorded signals", "outliers"}
        Name of the check, which selects the kind: a missing term or a parameter that changes; a
        recorded signal that is late or scaled wrongly; or a single measured sample that is an
        outlier.
    axis : GeneratedAxis
    record : Record
    levels : Levels
    bounded : bool
        Whether the loss bounds the effect of outliers, which are then only a note.
    """
    own = [lack for lack in found if lack.check == name]
    return Check(
        name=name,
        status=status_of(not own, matters=not bounded),
        figure=100 * max((lack.own_share for lack in own), default=0.0),
        threshold=100 * levels.least_share,
        p_value=min((lack.p_value for lack in own), default=None),
        source=_source_of(name, levels),
        finding=_finding_of(own, name, axis, record, bounded=bounded),
    )


#: Subjects of the checks for misspecifications, by name of the check.
_SUBJECTS = {
    "missing terms": "a missing term or by a parameter that changes during the record",
    "recorded signals": "a recorded signal that is late or wrongly scaled",
    "outliers": "a single measured sample that is an outlier",
}


def _source_of(name: str, levels: Levels) -> str:
    """Return the definition of the figure of a check for misspecifications, and its conditions."""
    subject = _SUBJECTS[name]
    return (
        f"largest unmodelled force that is caused by {subject}, in percent of the force (rms). The "
        "part for which the other parameters compensate is not included. The check fails if two "
        "conditions are met. (1) The unmodelled force is significantly larger in the residual than "
        f"in the residuals of simulated replicas (Hotelling's test at {100 * levels.level:g} % "
        "over all hypotheses, by Holm's rule). (2) The unmodelled force is more than "
        f"{100 * levels.least_share:g} % of the total force, or it changes a parameter by more "
        "than half the width of the 95 % interval of this parameter"
    )


def _finding_of(
    own: Sequence[Misspecification],
    name: str,
    axis: GeneratedAxis,
    record: Record,
    *,
    bounded: bool,
) -> MissingTerms | RecordedSignals | Outliers:
    """Return the finding of a check for misspecifications.

    Parameters
    ----------
    own : sequence of Misspecification
        Misspecifications of the kind of this check.
    name : {"missing terms", "recorded signals", "outliers"}
        Name of the check.
    axis : GeneratedAxis
    record : Record
    bounded : bool
        Whether the loss bounds the effect of outliers.
    """
    if name == "missing terms":
        return _missing_terms(own, axis, record)
    found = [misspecification_finding(lack, axis, record) for lack in own]
    if name == "recorded signals":
        signals = [each for each in found if isinstance(each, LateSignal | ScaledSignal)]
        return RecordedSignals(found=tuple(signals))
    samples = [each for each in found if isinstance(each, OutlyingSample)]
    return Outliers(found=tuple(samples), is_bounded=bounded)


def _missing_terms(
    lacking: Sequence[Misspecification], axis: GeneratedAxis, record: Record
) -> MissingTerms:
    """Return the finding of the missing terms and changed parameters among misspecifications."""
    found = [misspecification_finding(lack, axis, record) for lack in lacking]
    terms = [each for each in found if isinstance(each, MissingTerm | ChangedParameter)]
    return MissingTerms(found=tuple(terms))


def lack_of_fit_check(found: LackOfFit | None, preferred: Estimate) -> Check | None:
    """Return the check of the part of the residual that repeats with the motion; at most a note.

    None where the split of the residual, `found`, is None.
    """
    if found is None:
        return None
    coordinate = preferred.form.axis.coordinate
    unit = coordinate.acceleration_unit if preferred.is_direct else coordinate.force_unit
    finding = ResidualAtRepeats(
        nature=_nature_of_residual(found),
        percent=100 * found.share,
        repeated=found.repeated,
        noise=found.noise,
        repeated_percent=100 * found.repeated / found.left,
        unit=str(unit),
        left=preferred.form.left,
        period=found.period,
    )
    return Check(
        name="lack of fit",
        status=status_of(not found.is_mostly_model, matters=False),
        figure=finding.percent,
        threshold=100 * MIN_MODEL_SHARE.value,
        source="power of the residual's repeating part, in percent of the power of the residual. "
        "This part repeats with the reference. Its power is computed from products of the "
        "residuals of different repeats. The part counts if two conditions are met. (1) If the "
        "residual were only noise, a repeating part of this size or more would have a probability "
        "below 1e-3 (test with a HAC covariance over the phases of the period). (2) The part is "
        "smooth from row to row",
        finding=finding,
    )


def _nature_of_residual(found: LackOfFit) -> Literal["systematic", "steps", "small", "none"]:
    """Return the nature of the residual by its repeating part, see `ResidualAtRepeats`."""
    if found.is_mostly_model:
        return "systematic"
    if not found.is_there:
        return "none"
    return "small" if found.is_smooth else "steps"


def simulation_error_check(
    preferred: Estimate, rest: float, *, misspecified: bool = False
) -> Check | Missing:
    """Return the check of the simulation error of an estimate.

    If no loop was simulated because of the estimate, the check fails. If no loop was simulated for
    another reason, such as no control law or no reference, the check is Missing.

    Parameters
    ----------
    preferred : Estimate
        The reported estimate.
    rest : float
        Part of the record's samples at which the axis rests, from 0 to 1.
    misspecified : bool
        Whether the model is incomplete while the control law is correct, which may be the cause.
    """
    simulated, form = preferred.simulated, preferred.form
    if isinstance(simulated, NotSimulated):
        failed = Check(
            name="simulation",
            status="fail",
            source="the closed loop of a recorded axis can be simulated with correct parameters",
            finding=LoopNotSimulated(
                reason=str(simulated).removesuffix("."), is_misspecified=misspecified
            ),
        )
        return failed if simulated.by_estimate else simulated
    error = preferred.simulation_error_percent or 0.0  # None only where nothing was simulated
    good, noise = error < MAX_SIMULATION_ERROR.value, None
    # Noise sources that the simulated replicas were made with.
    if preferred.inference.chains:
        units = form.axis.coordinate.unit, form.axis.drive.unit
        noise = noise_sources(preferred.inference.chains[0], *units)
    return Check(
        name="simulation",
        status=status_of(good),
        figure=error,
        threshold=MAX_SIMULATION_ERROR.value,
        source=f"simulation error in percent of the {form.left} (rms). At 50 % the simulated loop "
        f"explains three quarters of the power of the {form.left}, at 100 % nothing",
        finding=SimulatedLoop(
            percent=error,
            left=form.left,
            reproduces=good,
            is_misspecified=misspecified,
            rest=resting_axis(rest),
            noise=noise,
        ),
    )
