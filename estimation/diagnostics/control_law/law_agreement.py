"""Comparison of the declared control law with the recorded control.

The law is run along the recorded reference and position. Each of its terms, and a test signal that
was added to the control, gets a factor with which the law gives the recorded control. Every factor
must be 1. A law that fails is also run with other gains, compared with a control of another scale,
and run with another clock and another delay. This identifies the fault: a wrong gain, millimetres
instead of metres, a wrong sign. A law that reads the velocity of an ideal sensor is compared after
a zero-phase low-pass of both sides, because that velocity is not recorded. The prefilter of the
identification is not used.

The control is an exact function of reference and position. It therefore determines gains far
better than a fit, whose gains are as uncertain as any parameter. A law with gains that a fit has
found is compared with the control using the gains that fit the control best. The gains of the fit
must then agree with these within the uncertainty of both.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from scipy.special import ndtri

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.findings import Finding
from axisid.estimation.law_replay import LIMIT
from axisid.estimation.records import Record, law_clock
from axisid.estimation.regression import hotelling_p_value, lacking_law, lacking_loop, wald
from axisid.estimation.signals import hides_command
from axisid.estimation.thresholds import (
    COMPARISON_CUTOFF,
    MAX_LAW_RESIDUAL,
    MAX_SCALE_ERROR,
    MIN_DISTANCE_FROM_NOISE,
    MIN_SAMPLES_PER_FACTOR,
)
from axisid.estimation.verdict_checks import Check, NotUsed, status_of
from axisid.modeling.declaration import ControlLaw
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.missing import Missing, unless_missing
from axisid.support.wording import first_case

from .control_residuals import (
    CONSTANT,
    INJECTED,
    best_shift,
    compared_with_law,
    open_for_jitter,
    other_readings,
    settling,
)
from .gain_regression import GAINS, Explanation, GainRegression, plausible
from .law_faults import (
    constant_or_drift,
    explained_by_gains,
    is_near,
    late_control,
    repair_of,
)
from .law_findings import (
    FoundByReading,
    FoundGainsAgree,
    FoundGainsDiffer,
    LawReproduced,
    OtherInjectedSize,
    Reading,
    RepairedLaw,
    UnexplainedControl,
)

# part of the declared law's residual; an explanation with a smaller residual is not rejected
_NEGLIGIBLE_PART = 0.01


@dataclass(frozen=True, slots=True, kw_only=True)
class LawAgreement:
    """Comparison of the recorded control with the declared law.

    Attributes
    ----------
    factors : dict of str to float
        Factors with which the law gives the recorded control, by product of gains; by gain
        (relative to the declared gain) for a law that is not a sum of such products; ``injected``
        for a test signal that was added to the control; and ``drive's limit``. Each is 1 if the
        drive has the declared law. Factors that the record does not distinguish are left out.
    residual_percent : float or None
        ``100 ||control - law|| / ||control||``, with the law as declared; None for a record with
        another period than the law.
    fitted_residual_percent : float or None
        Residual with the fitted factors, percent of the control: the part that no gain explains.
        None for a record with another period than the law.
    delay : int
        Samples by which the recorded control follows the declared law best.
    passed : bool
        Whether instruments that are simulated with this law can be used.
    finding : Finding
        The difference between control and law, and its explanation.
    reading : {"", "sampled rows", "even times"}
        Samples that the law read, where these are not the samples of the record.
    deviations : mapping of str to float
        Standard errors of the factors, for autoregressive residuals; empty where they are unknown.
    found_apart : bool
        Whether the control follows the law with other gains than a fit has found.
    explanations : tuple of Explanation
        Ways to explain the difference between the control and the law, the simple ones first.
    repaired_percent : float
        ``fitted_residual_percent`` with another column or another law; infinite if none is found.
    """

    factors: dict[str, float]
    residual_percent: float | None
    fitted_residual_percent: float | None
    delay: int
    passed: bool
    finding: Finding
    reading: Reading | Literal[""] = ""
    deviations: Mapping[str, float] = field(default_factory=dict)
    found_apart: bool = False
    explanations: tuple[Explanation, ...] = ()
    repaired_percent: float = math.inf

    @property
    def meaning(self) -> str:
        """Sentence for the user: the finding and the remedy."""
        return self.finding.sentence

    @property
    def sentence(self) -> str:
        """Sentence for the user, the same as `meaning`."""
        return self.meaning

    @property
    def plausible(self) -> tuple[Explanation, ...]:
        """Explanations of the control that the record cannot distinguish; empty if none suffices.

        Explanations that are clearly worse than another column or another law are left out.
        """
        if self.delay or self.found_apart or not self.explanations:
            return ()
        least = min(each.left_percent for each in self.explanations)
        if not self.passed and least >= MAX_LAW_RESIDUAL.value:
            return ()
        enough = _NEGLIGIBLE_PART * (self.residual_percent or 0.0)
        found = plausible(self.explanations, max(min(least, self.repaired_percent), enough))
        # A linearisation about the declared law does not hold for a law with another sign.
        return tuple(each for each in found if not each.turns_a_sign)


def first_failing(laws: Sequence[LawAgreement | Missing]) -> LawAgreement | Missing:
    """Return the first failed comparison of a law, or the first of all if none fails.

    Of several failed comparisons, one without a plausible explanation comes first.
    """
    failing = [each for each in laws if isinstance(each, LawAgreement) and not each.passed]
    return min(failing, key=lambda each: bool(each.plausible), default=laws[0])


def law_agreement(axis: GeneratedAxis, record: Record) -> LawAgreement | Missing:
    """Return the comparison of an axis's control law with a record, or why it is unavailable.

    If the record has uneven times or was resampled, the law may have read other samples. It is then
    compared with each of these readings of the record. The first reading with which the law passes
    is returned, otherwise the one with the smallest residual.
    """
    if (law := axis.control) is None:
        return NotUsed(str(lacking_law(axis)))
    if (incomparable := _incomparable(axis, law, record)) is not None:
        return incomparable
    others = [*other_readings(record)]
    first = _compared(axis, law, record, advises=not others)
    if not others or isinstance(first, Missing) or first.passed:
        return first
    checks: list[tuple[LawAgreement, Reading | None, Record]] = [(first, None, record)]
    for reading, read in others:
        if isinstance(found := _compared(axis, law, read, advises=False), Missing):
            continue
        if found.passed:
            return _by_reading(found, reading, first.residual_percent)
        checks.append((found, reading, read))
    best, reading_of_best, nearest = min(
        checks, key=lambda each: each[0].fitted_residual_percent or 0.0
    )
    # No reading passes. Jitter may make the control too uncertain to judge the law.
    off, least = best.residual_percent or 0.0, best.fitted_residual_percent or 0.0
    open_percent = open_for_jitter(axis, law, record, off)
    if open_percent is not None and least >= MAX_LAW_RESIDUAL.value:
        return Missing(
            "the samples of the record are not evenly spaced in time, and the law may have read "
            "other values, mainly other noise, between them. This makes "
            f"{open_percent:.2g} % of the control uncertain (rms), and the residual of the law is "
            f"{off:.2g} % of the control"
        )
    there = _compared(axis, law, nearest)
    if isinstance(there, Missing) or reading_of_best is None:
        return there
    return _by_reading(there, reading_of_best)


def _by_reading(
    found: LawAgreement, reading: Reading, recorded_percent: float | None = None
) -> LawAgreement:
    """Return a comparison whose finding names the samples that the law read.

    Parameters
    ----------
    found : LawAgreement
        Comparison with these samples.
    reading : {"sampled rows", "even times"}
    recorded_percent : float or None
        Residual with the samples of the record, percent; None where the law fails with either.
    """
    finding = FoundByReading(
        reading=reading, finding=found.finding, recorded_percent=recorded_percent
    )
    return replace(found, reading=reading, finding=finding)


def _compared(
    axis: GeneratedAxis, law: ControlLaw, record: Record, *, advises: bool = True
) -> LawAgreement | Missing:
    """Return the comparison of a law with the samples of a record; Missing if not possible.

    The residual, the factors of the terms and the best shift of the control decide whether the law
    passes. With `advises`, a failed comparison is examined further, for the fault and a remedy.
    """
    record = record.longest()  # the internal state of a law is unknown after a gap
    # After a low-pass, two samples in a period of its cut-off are nearly independent.
    independent_share = 2 * COMPARISON_CUTOFF.value if law.takes_velocity else 1.0
    least = MIN_SAMPLES_PER_FACTOR.value * len(law.terms) / independent_share
    if len(record.position) < 2 * settling(law) + least:
        return Missing(
            f"the longest part of the record without a gap has {len(record.position)} samples, and "
            f"the comparison needs {2 * settling(law) + least:.0f}. Record a longer motion"
        )
    control, made, *counted = compared_with_law(axis, law, record)
    if not np.all(np.isfinite(made)):
        return Missing("the output of the declared law is not finite along this record")
    by_gains = GainRegression.of(axis, law, record, *counted)
    if len(by_gains.control) < least:
        return Missing(
            f"only {len(by_gains.control)} samples can be compared, and {least:.0f} are needed. "
            "The other samples are at the ends of the record or masked, or the control is at the "
            "limit of the drive there"
        )
    shift = best_shift(made, control, counted[0])
    # A shift that explains the control is visible despite what the log leaves uncertain.
    if by_gains.possible and not shift:
        by_gains = by_gains.unless_rounded()
    left_open = by_gains.open_percent
    if by_gains.is_hidden and not shift:
        if by_gains.between:
            return Missing(
                f"the record is sampled every {record.period:.6g} s, and the control law runs "
                f"every {law.period:.6g} s. It reads values between the samples that are not in "
                f"the log, mainly noise, which makes {left_open:.2g} % of the control uncertain "
                "(rms)"
            )
        return Missing(
            "the log rounds position and reference, which makes "
            f"{left_open:.2g} % of the control of the declared law uncertain (rms)"
        )
    declared, factors = by_gains.percent, by_gains.factors
    check = LawAgreement(
        factors={name: value for name, (value, _) in factors.items()},
        deviations={name: deviation for name, (_, deviation) in factors.items()},
        residual_percent=declared,
        fitted_residual_percent=relative_error_percent(by_gains.gain_steps[2], by_gains.control),
        delay=shift,
        explanations=by_gains.explanations,
        passed=not (by_gains.off or by_gains.lean or declared >= MAX_LAW_RESIDUAL.value or shift),
        finding=LawReproduced(
            residual_percent=declared, open_percent=left_open if by_gains.between else None
        ),
    )
    if check.passed or not advises:
        return check
    explained, fault = _fault(axis, record, check, by_gains)
    if explained and (repair := repair_of(axis, law, record, explained, shift)):
        percent, change = repair
        return replace(
            check,
            repaired_percent=percent,
            finding=RepairedLaw(residual_percent=declared, repaired_percent=percent, repair=change),
        )
    if shift:
        late = late_control(declared, shift, None if law.continuous else law.delay)
        return replace(check, finding=late)
    return _with_gains_of_runs(fault)


def _with_gains_of_runs(check: LawAgreement) -> LawAgreement:
    """Return the comparison whose explanation by gains has the factors of the comparison itself.

    Those factors may be from replays of the law with fitted gains, and are then more accurate than
    the linearised ones. Without factors, the explanation by gains is removed.
    """
    left = check.fitted_residual_percent
    if left is None or not check.factors:
        others = [each for each in check.explanations if GAINS not in each.kind]
        return replace(check, explanations=tuple(others))
    by_runs = Explanation(
        kind=(GAINS,),
        values={name: factor - 1 for name, factor in check.factors.items()},
        deviations=check.deviations,
        left_percent=left,
    )
    others = [each for each in check.explanations if each.kind != by_runs.kind]
    return replace(check, explanations=(by_runs, *others))


def _fault(
    axis: GeneratedAxis, record: Record, check: LawAgreement, by_gains: GainRegression
) -> tuple[float, LawAgreement]:
    """Return the residual that a repair has to improve on, and the comparison with its fault.

    The faults are tried in order: a constant or a drift, another size of the test signal, other
    gains, and another scale of the control. The residual is in percent of the control: with the
    gains or the scale that explain the control, otherwise with the declared gains.

    Parameters
    ----------
    axis : GeneratedAxis
    record : Record
    check : LawAgreement
        The failed comparison.
    by_gains : GainRegression
        Regression of the control on the gains of the law.
    """
    # A constant or a drift alone.
    declared = by_gains.percent
    large = declared >= MAX_LAW_RESIDUAL.value
    about_mean = by_gains.residuals - by_gains.residuals.mean()
    besides = relative_error_percent(about_mean, by_gains.control)
    by_constant = CONSTANT in by_gains.lean and besides < MAX_LAW_RESIDUAL.value
    if by_constant if large else not by_gains.off:
        leaning = constant_or_drift(declared, by_gains.lean, axis.drive.unit)
        return declared, replace(check, finding=leaning)
    # Only the test signal has another size.
    far = [n for n, value in check.factors.items() if n != LIMIT and not is_near(value, 1.0)]
    only_size = (far or by_gains.off) == [INJECTED]
    # A gain may be slightly wrong as well.
    is_of_gains = by_gains.gains_off or not only_size
    explained, change = explained_by_gains(by_gains) if is_of_gains else (None, None)
    if only_size and change is None:
        size = OtherInjectedSize(residual_percent=declared, is_large=large)
        return declared, replace(check, finding=size)
    # Other gains, another scale, or no explanation.
    unexplained = UnexplainedControl(
        residual_percent=declared,
        is_large=large,
        may_be_injected=large and record.injected is None,
    )
    check = replace(check, finding=explained or unexplained)
    if change is None:
        scaled = by_gains.scale
        # The linearised factors are wrong far from 1.
        if by_gains.along.law.gains and not by_gains.along.law.is_polynomial:
            check = replace(check, factors={}, deviations={})
        return declared if scaled is None else scaled[1].percent, check
    # Gains without a visible effect are correct too where the change explains the control.
    times = {**dict.fromkeys(by_gains.along.law.gains, 1.0), **change.times}
    steps = change.gain_steps[0]
    times |= {name: 1 + steps[name] for name in by_gains.added if name in steps}
    factors = {
        name: float(np.prod([times[gain] ** power for gain, power in powers.items()]))
        for name, powers in by_gains.powers.items()
        if powers.keys() <= times.keys()
    } | {name: value for name, (value, _) in by_gains.at_limit.items()}
    check = replace(
        check,
        factors=factors,
        deviations={name: sd for name, (_, sd) in change.factors.items() if name in factors},
        fitted_residual_percent=change.percent,
    )
    return declared if len(change.free) > 1 else change.percent, check


@unless_missing
def law_check(law: LawAgreement) -> Check:
    """Return the check of the declared law against the recorded control.

    It is a note where the record was resampled, and the law read the rows before resampling.
    """
    needs_no_resampling = law.passed and law.reading == "sampled rows"
    return Check(
        name="control law",
        status="note" if needs_no_resampling else status_of(law.passed),
        figure=law.residual_percent,
        threshold=MAX_LAW_RESIDUAL.value,
        source="residual of the declared law in percent of the recorded control (rms); it is 0.24 "
        "% on the EMPS record. The check also fails where a factor of the law differs from 1 by "
        "more than 1 % and three standard errors, where a constant or a drift is more than 1 % of "
        "the control and three standard errors, where the control is delayed, and where the sample "
        "period differs from that of the law by more than 0.05 %",
        finding=law.finding,
    )


def _incomparable(
    axis: GeneratedAxis, law: ControlLaw, record: Record
) -> LawAgreement | Missing | None:
    """Return the reason why a record cannot be compared with a law; None if it can be.

    A record with another sample period than the law gives a failed comparison instead.
    """
    # The period is the only property of a law that can be checked without a reference.
    clock = law_clock(law, record)
    if clock.other is not None:
        # A law with differences has other gains at another period, and the record is not in time.
        return LawAgreement(
            factors={},
            residual_percent=None,
            fitted_residual_percent=None,
            delay=0,
            passed=False,
            finding=clock.other,
        )
    clocks = f"{clock.confirmed}; " * bool(clock.confirmed)
    lacking = lacking_loop(axis, record)
    why = first_case(
        (lacking is not None, f"{clocks}{lacking}"),
        (record.control is None, f"{clocks}the record has no control"),
        (
            record.added_control is not None and hides_command(axis),
            "the test signal was added to the control, and the log has their sum only behind the "
            f"{' and '.join(axis.drive.path.declared)} of the drive, which hides the output of the "
            "law",
        ),
        (
            record.integrated,
            "no position was recorded, and the integral of the velocity drifts away from it",
        ),
        (
            clock.resampled and (clock.ratio is None or bool(clock.confirmed)),
            f"the record was resampled at {1 / record.period:.6g} Hz, and the control law runs at "
            f"{1 / law.period:.6g} Hz",
        ),
        (True, ""),
    )
    return Missing(why) if why else None


@dataclass(frozen=True, slots=True)
class EstimatedGains:
    """Gains of a law that were estimated together with the parameters.

    Attributes
    ----------
    names : tuple of str
        Names of the k gains.
    covariance : (k, k) array
        Covariance of the estimated gains; infinite variances of gains that the record does not
        identify.
    freedom : float
        Degrees of freedom of the covariance.
    """

    names: tuple[str, ...]
    covariance: Array
    freedom: float


def found_law_agreement(
    axis: GeneratedAxis, record: Record, found: EstimatedGains
) -> LawAgreement | Missing:
    """Return the comparison of a control law with estimated gains with a record.

    The gains are fitted to the recorded control, and must agree with the estimated ones within the
    uncertainty of both.

    Parameters
    ----------
    axis : GeneratedAxis
        Axis whose law has the estimated gains.
    record : Record
    found : EstimatedGains
        Names and covariance of the gains that were estimated.

    Returns
    -------
    LawAgreement or Missing
        Comparison of the law with the gains that fit the recorded control best. It fails where
        these gains differ from the estimated gains. Where the control does not follow the law with
        these gains, the comparison is that of the law with the estimated gains. Missing where the
        law cannot be compared.
    """
    law, first, names = axis.control, law_agreement(axis, record), found.names
    if law is None or not names or isinstance(first, Missing) or first.residual_percent is None:
        return first
    record = record.longest()
    by_gains = GainRegression.of(axis, law, record, *compared_with_law(axis, law, record)[2:])
    best = by_gains.best(names)
    there = law_agreement(axis.with_gains(best.gains), record)
    if isinstance(there, LawAgreement) and there.passed:
        return _compared_with_found(there, best, law, found)
    return first


def _compared_with_found(
    there: LawAgreement, best: GainRegression, law: ControlLaw, found: EstimatedGains
) -> LawAgreement:
    """Return the comparison with the law, failed if the gains of control and fit differ.

    Parameters
    ----------
    there : LawAgreement
        Comparison of the law with the gains that fit the recorded control, which passes.
    best : GainRegression
        Regression that fitted these gains.
    law : ControlLaw
        Law with the gains of the fit.
    found : EstimatedGains
        Names and covariance of the gains of the fit.
    """
    asked, was = (np.array([of[name] for name in found.names]) for of in (best.gains, law.gains))
    covariance = found.covariance + best.covariance(found.names) * np.outer(was, was)
    apart = apart_in_deviations(asked - was, covariance, found.freedom)
    large = bool(np.any(np.abs(asked - was) > MAX_SCALE_ERROR.value * np.abs(was)))
    gains = {name: best.gains[name] for name in found.names}
    if not (large and apart > MIN_DISTANCE_FROM_NOISE.value):
        agree = FoundGainsAgree(finding=there.finding, gains=gains, standard_errors=apart)
        return replace(there, finding=agree)
    differ = FoundGainsDiffer(
        residual_percent=there.residual_percent,
        gains=gains,
        found={name: float(law.gains[name]) for name in found.names},
        standard_errors=apart,
    )
    return replace(there, passed=False, found_apart=True, finding=differ)


def apart_in_deviations(off: Array, covariance: Array, freedom: float) -> float:
    """Return the joint distance of k differences from 0, in standard errors.

    It is the distance at which a normally distributed number has the p-value of Hotelling's test. A
    p-value of 0 counts as the smallest positive number, which gives a distance of 37.

    Parameters
    ----------
    off : (k,) array
        Differences.
    covariance : (k, k) array
        Covariance of the differences.
    freedom : float
        Degrees of freedom of the covariance.
    """
    square, directions = wald(off, covariance)
    if not directions:
        return 0.0
    p_value = max(hotelling_p_value(square, directions, freedom), float(np.finfo(float).tiny))
    return -float(ndtri(p_value / 2))
