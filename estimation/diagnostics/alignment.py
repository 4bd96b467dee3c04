"""Estimation of the delay of the recorded force, as an additional parameter of the model.

A drive holds its force from one sample to the next, so that a central-difference acceleration
belongs to a force half a sample earlier than the recorded one. A filter or a bus adds to the delay.
Half a sample changes viscous friction by several standard errors.

A control that is logged at another time than it acts, and a law with another delay, look the same
in the recorded control: it follows the declared law some samples earlier or later. The motion shows
the difference. A control that is recorded when it acts moves the axis in agreement with its hold. A
control that is logged when it is computed moves the axis whole samples later.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.diagnostics.control_law import FoundByReading, LateControl, LawAgreement
from axisid.estimation.estimation_problem import Problem
from axisid.estimation.findings import Finding
from axisid.estimation.methods import METHODS, filtered_record
from axisid.estimation.misspecification import Misspecification, RecordScores, scores_of
from axisid.estimation.records import Record, law_clock
from axisid.estimation.signals import FilteredRecord, Prefilter
from axisid.estimation.thresholds import (
    MAX_DELAY_DEVIATION,
    MAX_MISALIGNMENT,
    MIN_DISTANCE_FROM_NOISE,
    NO_DELAY,
)
from axisid.estimation.verdict_checks import Check, status_of
from axisid.support.arrays import Array, Exact
from axisid.support.missing import Missing, unless_missing

from .alignment_findings import (
    DeclaredTooLong,
    DelayBeyondRange,
    EffectOfDelay,
    ForceDelay,
    LoggedAtOtherTime,
    OtherHold,
    UndeclaredDelay,
)

_EARLIEST, _LATEST = -1, 3  # range of the search for the delay, samples
_MOST_DECLARED = 8  # samples of a declared delay that the record may show to be absent
_MAX_STEPS = 10  # of Gauss-Newton
_CONVERGED = 1e-3  # step up to which the search has converged, samples


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Alignment(Exact):
    """Delay of the force, estimated together with the parameters of the model.

    Attributes
    ----------
    best : float
        Samples by which the force acts after it is recorded. The prefilter assumes 0 with the hold
        ``raw``, and about 0.5 with ``zoh``.
    deviation : float
        Standard error of the delay, samples: from simulated replicas of the record, otherwise HAC.
    at_the_end : bool
        Whether the delay is at an end of its search range.
    by_instruments : bool
        Whether the delay is estimated with the simulated loop; otherwise with the measured motion,
        whose noise may bias it.
    sensitivity : (p,) array
        Change of each estimated parameter per sample of delay.
    names : tuple of str
        Names of these parameters, as in the axis of the record.
    units : tuple of str
        Units of these parameters.
    """

    best: float
    deviation: float
    at_the_end: bool
    by_instruments: bool
    sensitivity: Array
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()


def estimate_delay(
    axis: GeneratedAxis, record: Record, prefilter: Prefilter
) -> Alignment | Missing:
    """Estimate the delay of the force by least squares, or return why it cannot be estimated.

    Noise in the motion may bias the delay. `identify` estimates it with instruments, see
    ``result.diagnosis.alignment``.

    Parameters
    ----------
    axis : GeneratedAxis
    record : Record
    prefilter : Prefilter
        Filter of the rows. Its hold affects only the start of the search.
    """
    data = filtered_record(axis, record, prefilter)
    fit = METHODS["idm-ls"].fit(Problem(axis=axis, data=(data,)))
    physical = fit.form.physical(fit.solution.theta)[0]
    return alignment_of(scores_of(data, physical, None, range(len(physical))))


@unless_missing
def alignment_of(scores: RecordScores) -> Alignment | Missing:
    """Return the estimated delay of the force in a record, from the residuals of its model.

    The estimate is found by Gauss-Newton steps. The column of the delay is the change of the
    modelled force in a sample, along the simulated loop where there is one. Each step shifts a
    cubic spline of the recorded force. The errors of the filter along the loop and the mean effect
    of noise in the simulated replicas are subtracted. Missing where the parameters of the model
    explain a delay as well.

    Parameters
    ----------
    scores : RecordScores
        Residuals of the record and of its simulated replicas, with the columns of the parameters.
    """
    # Column of the delay in the rows.
    data, force = scores.data, scores.form.equations(scores.signals).predicted(scores.physical)
    column = scores.along.reduce(scores.along.by_stretch(np.gradient, force))[:, None]
    # Range of the search. A declared delay may be absent, so that the force acts as much earlier.
    declared = math.floor(declared_lateness(data) / data.period)
    tried = (min(_EARLIEST, -1 - min(declared, _MOST_DECLARED)), _LATEST)
    # Start of the search: the delay of the hold.
    is_held_by_loop = (
        scores.by_loop
        and data.record.force is None
        and data.axis.jumps
        and data.prefilter.hold == "raw"
    )
    start = data.hold_delay
    if is_held_by_loop:  # the simulated loop holds a command whatever the filter assumes
        start = law_clock(data.axis.control, data.record).hold_delay
    # Gauss-Newton steps up to convergence, or up to an end of the range.
    delay, deviation = start, np.inf
    for _ in range(_MAX_STEPS):
        tested = _delayed(scores, delay - start).test(column[:, None])
        step = float(tested.values[0, 0])
        if step == 0 or not math.isfinite(step):
            return Missing("the parameters of the model explain a delay of the force as well")
        deviation = float(np.sqrt(tested.covariances[0, 0, 0]))
        delay += step
        if abs(step) < _CONVERGED or not tried[0] < delay < tried[1]:
            break
    parameters = [data.axis.parameters[j] for j in scores.free]
    return Alignment(
        best=float(np.clip(delay, *tried)),
        deviation=deviation,
        at_the_end=not tried[0] < delay < tried[1],
        by_instruments=scores.by_loop,
        sensitivity=scores.moved_by(column, np.ones(1)),
        names=tuple(p.name for p in parameters),
        units=tuple(p.unit for p in parameters),
    )


def _delayed(scores: RecordScores, samples: float) -> RecordScores:
    """Return the scores of a record whose force is delayed by some samples.

    The residuals change by the change of the force, without the part that the parameters explain.
    The columns stay as they are.
    """
    from scipy.ndimage import shift

    delayed = scores.along.by_stretch(
        lambda force: shift(force, samples, order=3, mode="nearest") - force,
        scores.data.signals.force,
    )
    column, residuals = scores.along.reduce(delayed)[:, None], scores.residuals.copy()
    residuals[:, 0] += column[:, 0] + scores.columns @ scores.moved_by(column, np.ones(1))
    return replace(scores, residuals=residuals)


@unless_missing
def alignment_check(
    delay: Alignment,
    data: FilteredRecord,
    *,
    late: Misspecification | Missing | None,
    half_widths: Mapping[str, float],
    law: LawAgreement | Missing,
    timing: int | Missing,
) -> Check | Missing:
    """Return the check of the estimated delay of the force against the delay of the hold.

    The check fails where the search for missing terms finds a delay. Without that search, it fails
    where the estimate is at the end of its range, or where the force acts significantly earlier
    than the hold assumes and this changes a parameter by more than half the width of its interval.
    It is a note where the comparison with the control law shows the same shift of the log, so that
    the shift is counted once. Missing where the delay is too uncertain.

    Parameters
    ----------
    delay : Alignment
        Estimated delay.
    data : FilteredRecord
    late : Misspecification, Missing or None
        The delay among the missing terms; None where there is none; Missing where missing terms
        could not be searched.
    half_widths : mapping of str to float
        Half widths of the 95 % intervals by parameter.
    law : LawAgreement or Missing
        Comparison of the control law with the record.
    timing : int or Missing
        Whole samples after its recording at which the force acts, see `force_timing`.
    """
    # The comparison with the law shows the same whole samples: the control is logged elsewhere.
    role = "control" if data.record.force is None else "force"
    shift = 0 if isinstance(timing, Missing) or role == "force" else timing
    by_log = isinstance(law, LawAgreement) and law.delay == -shift != 0
    # Distance of the delay from that of the hold, and its significance.
    assumed, apart = data.hold_delay, delay.best - data.hold_delay
    noise = MIN_DISTANCE_FROM_NOISE.value * delay.deviation
    is_far = delay.at_the_end and abs(apart) > noise
    if delay.deviation > MAX_DELAY_DEVIATION.value and not is_far:
        return Missing(
            f"the standard error of the delay of the force is {delay.deviation:.2g} samples, and a "
            f"comparison needs {MAX_DELAY_DEVIATION.value:g} samples or less"
        )
    if isinstance(late, Missing):
        is_early = apart < -noise and any(
            abs(slope * apart) > half_widths[name]
            for name, slope in zip(delay.names, delay.sensitivity, strict=True)
        )
        aligned = not (delay.at_the_end or is_early)
    else:
        aligned = late is None
    return Check(
        name="alignment",
        status=status_of(aligned, matters=not by_log),
        figure=apart,
        p_value=late.p_value if isinstance(late, Misspecification) else None,
        source="estimated delay of the force minus the delay that was assumed when force and "
        "motion were aligned (option hold), in samples. A force that a drive holds over each "
        "sample acts half a sample late. With simulated replicas, the check fails if the search "
        "for missing terms finds a delay. Without them, it fails in two cases. (1) The estimate is "
        "at the end of its range. (2) The force acts earlier than assumed by more than three "
        "standard errors, and this changes a parameter by more than half the width of the 95 % "
        "interval of this parameter",
        finding=ForceDelay(
            delay=delay.best,
            standard_error=delay.deviation,
            is_at_end=delay.at_the_end,
            by_instruments=delay.by_instruments,
            hold=data.prefilter.hold,
            supposed=assumed,
            apart=apart,
            is_aligned=aligned,
            role=role,
            remedies=() if aligned else _remedies(delay, data, timing, role, by_log=by_log),
            effects=_effects(delay),
        ),
    )


def _effects(delay: Alignment) -> tuple[EffectOfDelay, ...]:
    """Return the change of each parameter per sample of delay."""
    slopes = delay.sensitivity.tolist()
    return tuple(
        EffectOfDelay(parameter=name, per_sample=slope, unit=unit)
        for name, slope, unit in zip(delay.names, slopes, delay.units, strict=True)
    )


def _remedies(
    delay: Alignment, data: FilteredRecord, timing: int | Missing, role: str, *, by_log: bool
) -> tuple[Finding, ...]:
    """Return changes that align force and motion, in the order in which to try them.

    If the other hold explains the delay, it is the only change. Otherwise the changes are another
    declared delay of the drive, and a shift of the column in the log.

    Parameters
    ----------
    delay : Alignment
        Estimated delay of the force.
    data : FilteredRecord
    timing : int or Missing
        Whole samples after its recording at which the force acts, see `force_timing`.
    role : {"control", "force"}
        Column that gives the force.
    by_log : bool
        Whether the control law shows that the log wrote the control at another time.
    """
    # Samples by which the force acts later than the hold assumes.
    axis, period, late = data.axis, data.record.period, delay.best - data.hold_delay
    declared = declared_lateness(data)
    # The force is early because the declared delay of the drive is too long.
    is_declared = 0 < -late * period * (1 - NO_DELAY.value) < declared
    # The other hold, and the delay that it assumes.
    zoh_delay = law_clock(axis.control, data.record).hold_delay
    other, other_delay = ("zoh", zoh_delay) if data.prefilter.hold == "raw" else ("raw", 0.0)
    if abs(delay.best - other_delay) <= MAX_MISALIGNMENT.value and not is_declared:
        # If the log is slower than the loop, a logged control acts for a part of a sample.
        return (OtherHold(hold=other, or_law_period=axis.control is None and other == "raw"),)
    # A shift of the column in the log, and a delay beyond the search range.
    by_shift: tuple[Finding, ...] = ()
    if timing and not isinstance(timing, Missing):  # whole samples, as by a shift in the log
        by_shift = (LoggedAtOtherTime(role=role, samples=timing),)
    if delay.at_the_end and late > 0 and not by_shift:
        return (DelayBeyondRange(role=role, samples=round(late), seconds=late * period),)
    # A declared delay of the drive cannot be the cause.
    is_continuous = axis.control is not None and axis.control.continuous
    if by_log or data.record.force is not None or is_continuous:
        return by_shift
    # A shorter or a longer declared delay of the drive.
    if late < 0 and declared:
        remaining = declared + late * period
        too_long = DeclaredTooLong(
            declared=declared,
            excess=-late * period,
            is_at_least=delay.at_the_end,
            remaining=0.0 if remaining < NO_DELAY.value * declared else remaining,
        )
        return (too_long, *by_shift)
    if late <= 0 or delay.at_the_end:
        return by_shift
    undeclared = UndeclaredDelay(seconds=late * period, is_further=bool(declared))
    return (undeclared, *by_shift)


def declared_lateness(data: FilteredRecord) -> float:
    """Return the declared delay of the force relative to the recorded control, s.

    It is the sum of delay and lag of the drive for a logged command, the lag for a logged control
    that already includes the delay, and otherwise 0.
    """
    drive = data.axis.drive
    return float({"command": drive.delay + drive.lag, "applied": drive.lag}.get(drive.logged, 0.0))


@unless_missing
def force_timing(found: Alignment, data: FilteredRecord) -> int | Missing:
    """Return the whole samples between the recording of the force and its action.

    The delay of the hold is not counted. Missing where the estimated delay, `found`, is uncertain,
    at the end of its range, or not near a whole number of samples.
    """
    if found.deviation > MAX_DELAY_DEVIATION.value or found.at_the_end:
        return Missing("the motion does not show when the force acts")
    apart = found.best - data.hold_delay
    margin = max(MAX_MISALIGNMENT.value, MIN_DISTANCE_FROM_NOISE.value * found.deviation)
    if abs(apart - round(apart)) > min(margin, 0.5):
        return Missing(
            f"the force acts {apart:.2f} samples after it is recorded, which is not a whole number"
        )
    return round(apart)


def law_in_time(law: LawAgreement, data: FilteredRecord, timing: int | Missing) -> LawAgreement:
    """Return the comparison of a law, with the source of a late control: the law or the log.

    The motion shows the source. A comparison without a late control is returned unchanged.

    Parameters
    ----------
    law : LawAgreement
        Comparison of the control law with the record.
    data : FilteredRecord
    timing : int or Missing
        Whole samples between the recording of the force and its action, see `force_timing`.
    """
    finding = law.finding
    if isinstance(finding, FoundByReading) and isinstance(finding.finding, LateControl):
        late = _with_source(finding.finding, data, timing)
        return replace(law, finding=replace(finding, finding=late))
    if isinstance(finding, LateControl):
        return replace(law, finding=_with_source(finding, data, timing))
    return law


def _with_source(late: LateControl, data: FilteredRecord, timing: int | Missing) -> LateControl:
    """Return the finding of a late control, with the source and the remedy that the motion shows.

    If the force acts whole samples after its recording, the log is wrong. Otherwise the declared
    delay of the law is wrong, or, for a control that comes before any law could give it, the
    position or the reference.
    """
    law = data.axis.control
    if late.is_at_least or law is None or law.continuous:
        return late
    if isinstance(timing, Missing):
        return replace(late, unknown=timing.reason)
    if data.record.force is not None:
        return late
    if timing:
        return replace(late, blame="log", shift=timing, delay=None)
    delay = law.delay + late.samples
    if delay < 0 and not law.delay:
        return replace(late, blame="position or reference", shift=late.samples, delay=None)
    return replace(late, blame="law", delay=max(delay, 0), shift=0)
