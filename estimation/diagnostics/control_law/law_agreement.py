"""Comparison of the declared control law with the recorded control.

The law is run along the recorded reference and position. Each of its terms, and a test signal that
was added to the control, gets a factor with which the law gives the recorded control. Every factor
must be 1. A law that fails is also run with other gains, compared with a control of another scale,
and run with another clock and another delay. This identifies the fault: a wrong gain, millimetres
instead of metres, a wrong sign. A law that reads the velocity of an ideal sensor is compared after
a zero-phase low-pass of both controls, because that velocity is not recorded. The prefilter of the
identification is not used.

The control is an exact function of reference and position. It therefore determines gains far
better than a fit, whose gains are as uncertain as any parameter. If a fit has found the gains of a
law, the law is compared with the recorded control using the gains that fit the control best. The
gains of the fit must then agree with these gains within the uncertainty of both.
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

# residual of an explanation relative to that of the declared law, up to which the explanation is
# plausible although another one has a smaller residual
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
        drive has the declared law. Only factors that the record identifies are included.
    residual_percent : float or None
        ``100 ||control - law|| / ||control||``, with the law as declared; None for a record with
        another period than the law.
    fitted_residual_percent : float or None
        Residual with the fitted factors, percent of the control: the part that no gain explains.
        None for a record with another period than the law.
    delay : int
        Samples by which the recorded control comes later than by the declared law; 0 unless a shift
        explains the control clearly better.
    passed : bool
        Whether the control follows the law, so that instruments simulated with this law can be
        used.
    finding : Finding
        The difference between control and law, and its explanation.
    reading : {"", "sampled rows", "even times"}
        Samples that the law read, if these are not the samples of the record; otherwise empty.
    deviations : mapping of str to float
        Standard errors of the factors, for autoregressive residuals; empty where they are unknown.
    found_apart : bool
        Whether the control follows the law with other gains than those that a fit has found.
    explanations : tuple of Explanation
        Ways to explain the difference between the control and the law, the simple ones first.
    repaired_percent : float
        Residual with a repair, a change of a column, the law or the drive's limit, percent of the
        control; infinite if no repair is found.
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
        """Sentence for the user; another name of `meaning`, as findings have it."""
        return self.meaning

    @property
    def plausible(self) -> tuple[Explanation, ...]:
        """Explanations of the control that the record cannot distinguish; empty if none suffices.

        An explanation that is clearly worse than another explanation or than a repair is not
        plausible.
        """
        if self.delay or self.found_apart or not self.explanations:
            return ()
        least = min(each.left_percent for each in self.explanations)
        if not self.passed and least >= MAX_LAW_RESIDUAL.value:
            return ()
        enough = _NEGLIGIBLE_PART * (self.residual_percent or 0.0)
        found = plausible(self.explanations, max(min(least, self.repaired_percent), enough))
        # The linearisation about the declared law is not valid for the opposite sign.
        return tuple(each for each in found if not each.turns_a_sign)


def first_failing(laws: Sequence[LawAgreement | Missing]) -> LawAgreement | Missing:
    """Return the first failed comparison of a law, or the first of all if none fails.

    Of several failed comparisons, one without a plausible explanation comes first.
    """
    failing = [each for each in laws if isinstance(each, LawAgreement) and not each.passed]
    return min(failing, key=lambda each: bool(each.plausible), default=laws[0])


def law_agreement(axis: GeneratedAxis, record: Record) -> LawAgreement | Missing:
    """Return the comparison of an axis's control law with a record, or why it is unavailable.

    If the record has uneven times or was resampled, the law may have read other samples. The law is
    then compared with each of these readings of the record. The comparison with the first reading
    is returned for which the law passes. If the law passes with none, it is the comparison with the
    smallest residual, examined for the fault and a remedy.
    """
    law = axis.control
    if law is None:
        return NotUsed(str(lacking_law(axis)))
    incomparable = _incomparable(axis, law, record)
    if incomparable is not None:
        return incomparable
    # The samples of the record, then other readings.
    others = [*other_readings(record)]
    first = _compared(axis, law, record, advises=not others)
    if not others or isinstance(first, Missing) or first.passed:
        return first
    checks: list[tuple[LawAgreement, Reading | None, Record]] = [(first, None, record)]
    for reading, read in others:
        found = _compared(axis, law, read, advises=False)
        if isinstance(found, Missing):
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
            "the samples of the record are not evenly spaced in time. Between the samples, the law "
            "may have read other values, mainly other noise. This makes "
            f"{open_percent:.2g} % of the control uncertain (rms), and the residual of the law is "
            f"{off:.2g} % of the control"
        )
    # The best reading once more, for the fault and a remedy.
    examined = _compared(axis, law, nearest)
    if isinstance(examined, Missing) or reading_of_best is None:
        return examined
    return _by_reading(examined, reading_of_best)


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
        Residual with the samples of the record, percent; None where the law fails with both.
    """
    finding = FoundByReading(
        reading=reading, finding=found.finding, recorded_percent=recorded_percent
    )
    return replace(found, reading=reading, finding=finding)


def _compared(
    axis: GeneratedAxis, law: ControlLaw, record: Record, *, advises: bool = True
) -> LawAgreement | Missing:
    """Return the comparison of a law with the samples of a record; Missing if not possible.

    The residual, a constant and a drift, the factors of the terms and the best shift of the control
    decide whether the law passes. With `advises`, a failed comparison is examined further, for the
    fault and a remedy. Missing where too few samples can be compared, or the samples between those
    of the log, or the rounding of the log, make the control too uncertain.
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
    # Controls, and the masks of compared and of limited samples.
    control, made, *masks = compared_with_law(axis, law, record)
    if not np.all(np.isfinite(made)):
        return Missing("the output of the declared law is not finite along this record")
    by_gains = GainRegression.of(axis, law, record, *masks)
    if len(by_gains.control) < least:
        return Missing(
            f"only {len(by_gains.control)} samples can be compared, and {least:.0f} are needed. "
            "The other samples are at the ends of the record or masked, or the control is at the "
            "limit of the drive there"
        )
    # Uncertainty of the control by the log. It does not hide a shift that explains the control.
    shift = best_shift(made, control, masks[0])
    if by_gains.possible and not shift:
        by_gains = by_gains.unless_rounded()
    uncertain_percent = by_gains.open_percent
    if by_gains.is_hidden and not shift:
        if by_gains.between:
            return Missing(
                f"the record is sampled every {record.period:.6g} s, and the control law runs "
                f"every {law.period:.6g} s. The law reads values between the samples that are not "
                f"in the log, mainly noise. This makes {uncertain_percent:.2g} % of the control "
                "uncertain (rms)"
            )
        return Missing(
            "the log rounds position and reference. This makes "
            f"{uncertain_percent:.2g} % of the control of the declared law uncertain (rms)"
        )
    # The comparison with the declared gains.
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
            residual_percent=declared,
            open_percent=uncertain_percent if by_gains.between else None,
        ),
    )
    if check.passed or not advises:
        return check
    # The fault: a repair if one explains the control better, then a shift, then other gains.
    explained, with_fault = _with_fault(axis, record, check, by_gains)
    repair = repair_of(axis, law, record, explained, shift) if explained else None
    if repair is not None:
        percent, change = repair
        return replace(
            check,
            repaired_percent=percent,
            finding=RepairedLaw(residual_percent=declared, repaired_percent=percent, repair=change),
        )
    if shift:
        late = late_control(declared, shift, None if law.continuous else law.delay)
        return replace(check, finding=late)
    return _with_gains_of_runs(with_fault)


def _with_gains_of_runs(check: LawAgreement) -> LawAgreement:
    """Return the comparison with its own factors in its explanation by gains.

    The factors of the comparison may be from runs of the law with fitted gains, and are then more
    accurate than the linearised ones of the explanation. Without factors, explanations by gains are
    removed.
    """
    fitted_percent = check.fitted_residual_percent
    if fitted_percent is None or not check.factors:
        others = [each for each in check.explanations if GAINS not in each.kind]
        return replace(check, explanations=tuple(others))
    by_runs = Explanation(
        kind=(GAINS,),
        values={name: factor - 1 for name, factor in check.factors.items()},
        deviations=check.deviations,
        left_percent=fitted_percent,
    )
    others = [each for each in check.explanations if each.kind != by_runs.kind]
    return replace(check, explanations=(by_runs, *others))


def _with_fault(
    axis: GeneratedAxis, record: Record, check: LawAgreement, by_gains: GainRegression
) -> tuple[float, LawAgreement]:
    """Return the residual that a repair has to improve on, and the comparison with its fault.

    The faults are tried in order: a constant or a drift, another size of the test signal, other
    gains, and another scale of the control. The residual is in percent of the control: that with
    the single gain or the scale that explains the control, otherwise that with the declared gains.

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
    percent_about_mean = relative_error_percent(about_mean, by_gains.control)
    by_constant = CONSTANT in by_gains.lean and percent_about_mean < MAX_LAW_RESIDUAL.value
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
    # Factors of the terms by the fitted gains. Gains without a visible effect count as correct.
    times = {**dict.fromkeys(by_gains.along.law.gains, 1.0), **change.times}
    steps = change.gain_steps[0]
    times |= {name: 1 + steps[name] for name in by_gains.added if name in steps}
    factors = {}
    for name, powers in by_gains.powers.items():
        if powers.keys() <= times.keys():
            factors[name] = float(np.prod([times[gain] ** n for gain, n in powers.items()]))
    factors |= {name: value for name, (value, _) in by_gains.at_limit.items()}
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

    It is a note if the record was resampled and the law passes with the rows before resampling.
    """
    needs_no_resampling = law.passed and law.reading == "sampled rows"
    return Check(
        name="control law",
        status="note" if needs_no_resampling else status_of(law.passed),
        figure=law.residual_percent,
        threshold=MAX_LAW_RESIDUAL.value,
        source="residual of the declared law in percent of the recorded control (rms). For "
        "comparison, the residual of the correct law on the public EMPS record is 0.24 %. The "
        "check also fails in these cases. (1) A factor by which the gains of the law are "
        "multiplied to fit the recorded control differs from 1 by more than 1 % and by more than "
        "three standard errors. (2) The recorded control contains a constant that the law does not "
        "give. This constant is larger than 1 % of the control and than three of its standard "
        "errors. (3) The recorded control contains a drift that the law does not give. This drift "
        "is larger than 2 % of the control and than three of its standard errors. (4) The control "
        "is delayed. (5) The sample period differs from that of the law by more than 0.05 %",
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
    # A confirmed difference of the periods is reported before the reason itself.
    confirmed = f"{clock.confirmed}; " if clock.confirmed else ""
    lacking = lacking_loop(axis, record)
    if lacking is not None:
        return Missing(f"{confirmed}{lacking}")
    if record.control is None:
        return Missing(f"{confirmed}the record has no control")
    if record.added_control is not None and hides_command(axis):
        return Missing(
            "the test signal was added to the control. The log has the sum only after the "
            f"{' and '.join(axis.drive.path.declared)} of the drive, so that the output of the law "
            "is not known"
        )
    if record.integrated:
        return Missing(
            "no position was recorded, and the integral of the velocity drifts away from the "
            "position"
        )
    if clock.resampled and (clock.ratio is None or clock.confirmed):
        return Missing(
            f"the record was resampled at {1 / record.period:.6g} Hz, and the control law runs at "
            f"{1 / law.period:.6g} Hz"
        )
    return None


@dataclass(frozen=True, slots=True)
class EstimatedGains:
    """Gains of a law that a fit has estimated together with the parameters.

    Attributes
    ----------
    names : tuple of str
        Names of the k gains.
    covariance : (k, k) array
        Covariance of the estimated gains; the variance of a gain that the record does not identify
        is infinite.
    freedom : float
        Degrees of freedom of the covariance.
    """

    names: tuple[str, ...]
    covariance: Array
    freedom: float


def found_law_agreement(
    axis: GeneratedAxis, record: Record, found: EstimatedGains
) -> LawAgreement | Missing:
    """Return the comparison of a record with a control law whose gains were estimated.

    The gains are fitted to the recorded control, and must agree with the estimated gains within the
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
    # The gains that fit the recorded control best, and the comparison with these gains.
    by_gains = GainRegression.of(axis, law, record, *compared_with_law(axis, law, record)[2:])
    best = by_gains.best(names)
    with_best_gains = law_agreement(axis.with_gains(best.gains), record)
    if isinstance(with_best_gains, LawAgreement) and with_best_gains.passed:
        return _compared_with_found(with_best_gains, best, law, found)
    return first


def _compared_with_found(
    with_best_gains: LawAgreement, best: GainRegression, law: ControlLaw, found: EstimatedGains
) -> LawAgreement:
    """Return the comparison with the law, failed if the gains of control and fit differ.

    The gains differ if their joint distance is significant and at least one gain differs by more
    than 1 %.

    Parameters
    ----------
    with_best_gains : LawAgreement
        Comparison of the law with the gains that fit the recorded control, which passes.
    best : GainRegression
        Regression that fitted these gains.
    law : ControlLaw
        Law with the gains of the fit.
    found : EstimatedGains
        Names and covariance of the gains of the fit.
    """
    # Gains of the control and of the fit, and the distance between them.
    of_control = np.array([best.gains[name] for name in found.names])
    of_fit = np.array([law.gains[name] for name in found.names])
    differences = of_control - of_fit
    covariance = found.covariance + best.covariance(found.names) * np.outer(of_fit, of_fit)
    apart = apart_in_deviations(differences, covariance, found.freedom)
    is_large = bool(np.any(np.abs(differences) > MAX_SCALE_ERROR.value * np.abs(of_fit)))
    gains = {name: best.gains[name] for name in found.names}
    if not (is_large and apart > MIN_DISTANCE_FROM_NOISE.value):
        agree = FoundGainsAgree(finding=with_best_gains.finding, gains=gains, standard_errors=apart)
        return replace(with_best_gains, finding=agree)
    differ = FoundGainsDiffer(
        residual_percent=with_best_gains.residual_percent,
        gains=gains,
        found={name: float(law.gains[name]) for name in found.names},
        standard_errors=apart,
    )
    return replace(with_best_gains, passed=False, found_apart=True, finding=differ)


def apart_in_deviations(off: Array, covariance: Array, freedom: float) -> float:
    """Return the joint distance of k differences from 0, in standard errors.

    It is the distance from 0 at which a single normally distributed number has the same p-value as
    Hotelling's test of the differences. A p-value of 0 counts as the smallest positive number,
    which gives a distance of 37.

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
