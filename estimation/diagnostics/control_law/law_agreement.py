"""The declared control law against what the drive did.

The law is run along the recorded reference and position, and what its terms, and a test signal that
was added to the control, would have to be times themselves to give the recorded control must be 1,
for each. A law that fails is run with other gains, and held against a control of another scale,
which tells the fault: another gain, millimetres for metres, a flipped sign; so are another clock
and a delay. A law that takes an ideal sensor's velocity is compared after a zero-phase low-pass of
both sides, since that velocity is not recorded; the identification's own filter plays no part.

The control follows from reference and position exactly, so that it tells gains far better than a
fit does, which finds them as unsurely as any parameter. A law some of whose gains a fit has found
is held against the control with the gains that the control itself asks for; what was found must
then be those, as surely as both are known.
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
from axisid.support.errors import Missing, first_case, unless_missing

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

# of the declared law's residual, less of which speaks against no explanation
_NEGLIGIBLE_PART = 0.01


@dataclass(frozen=True, slots=True, kw_only=True)
class LawAgreement:
    """The recorded control against the declared law.

    Attributes
    ----------
    factors : dict of str to float
        By product of gains, or by gain of a law that is no sum of such products (how many times the
        declared one it is), ``injected`` for a test signal that was added to the control, and
        ``drive's limit``; each is 1 if the law is the drive's. None of those that the record does
        not tell apart.
    residual_percent : float or None
        ``100 ||control - law|| / ||control||``, with the law as declared; None for a record of
        another period than the law's.
    fitted_residual_percent : float
        The same with the factors: what no gain explains. None for such a record too.
    delay : int
        Samples by which the recorded control follows the declared law best.
    passed : bool
        Whether instruments simulated with this law can be believed.
    finding : Finding
        The difference between control and law, and what explains it.
    reading : {"", "sampled rows", "even times"}
        Samples that the law read, where they are not those of the record.
    deviations : mapping of str to float
        Of the factors, beside an autoregression; empty where they are not known.
    found_apart : bool
        Whether the law is the control's, by other gains than a fit has found.
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
        """Return the sentence for the user: what was found, and what can be done about it."""
        return self.finding.sentence

    @property
    def sentence(self) -> str:
        """Return the same as `meaning`."""
        return self.meaning

    @property
    def plausible(self) -> tuple[Explanation, ...]:
        """Explanations of the control that the record cannot tell apart; empty if none is enough.

        Another column or another law may explain the control better than any of them.
        """
        if self.delay or self.found_apart or not self.explanations:
            return ()
        least = min(each.left_percent for each in self.explanations)
        if not self.passed and least >= MAX_LAW_RESIDUAL.value:
            return ()
        enough = _NEGLIGIBLE_PART * (self.residual_percent or 0.0)
        found = plausible(self.explanations, max(min(least, self.repaired_percent), enough))
        # A straight line from the declared law tells nothing of one with another sign.
        return tuple(each for each in found if not each.turns_a_sign)


def first_failing(laws: Sequence[LawAgreement | Missing]) -> LawAgreement | Missing:
    """The first check that fails its record, those without an explanation first; else the first."""
    failing = [each for each in laws if isinstance(each, LawAgreement) and not each.passed]
    return min(failing, key=lambda each: bool(each.plausible), default=laws[0])


def law_agreement(axis: GeneratedAxis, record: Record) -> LawAgreement | Missing:
    """Check an axis's control law against a record; or say why it cannot be checked."""
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
    off, least = best.residual_percent or 0.0, best.fitted_residual_percent or 0.0
    open_percent = open_for_jitter(axis, law, record, off)
    if open_percent is not None and least >= MAX_LAW_RESIDUAL.value:
        return Missing(
            "the record's samples are off even times, and what the law read between them, noise "
            f"above all, leaves {open_percent:.2g} % of its control open ({off:.2g} % off)"
        )
    there = _compared(axis, law, nearest)
    if isinstance(there, Missing) or reading_of_best is None:
        return there
    return _by_reading(there, reading_of_best)


def _by_reading(
    found: LawAgreement, reading: Reading, recorded_percent: float | None = None
) -> LawAgreement:
    """Return a comparison that says which samples the law read."""
    finding = FoundByReading(
        reading=reading, finding=found.finding, recorded_percent=recorded_percent
    )
    return replace(found, reading=reading, finding=finding)


def _compared(
    axis: GeneratedAxis, law: ControlLaw, record: Record, *, advises: bool = True
) -> LawAgreement | Missing:
    """A law against the samples of a record, with what would mend it where that is asked for."""
    record = record.longest()  # a law's memory does not outlast a gap
    # Behind a low-pass two samples in a period of its cut-off are as good as independent.
    independent_share = 2 * COMPARISON_CUTOFF.value if law.takes_velocity else 1.0
    least = MIN_SAMPLES_PER_FACTOR.value * len(law.terms) / independent_share
    if len(record.position) < 2 * settling(law) + least:
        return Missing(f"the record is too short for it, {len(record.position)} samples")
    control, made, *counted = compared_with_law(axis, law, record)
    if not np.all(np.isfinite(made)):
        return Missing("the declared law is not finite on this record")
    by_gains = GainRegression.of(axis, law, record, *counted)
    if len(by_gains.control) < least:
        return Missing(
            f"{len(by_gains.control)} of its samples are too few to compare; the others are at the "
            "ends, or masked, or the control is at the drive's limit"
        )
    shift = best_shift(made, control, counted[0])
    # A shift that explains the control shows through whatever the log leaves open.
    if by_gains.possible and not shift:
        by_gains = by_gains.unless_rounded()
    left_open = by_gains.open_percent
    if by_gains.is_hidden and not shift:
        return Missing(
            f"the record is sampled every {record.period:.6g} s, the control law runs every "
            f"{law.period:.6g} s, and what it reads between the samples, noise above all, leaves "
            f"{left_open:.2g} % of its control open"
            if by_gains.between
            else "what the log rounds of position and reference leaves "
            f"{left_open:.2g} % of the declared law's control open"
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
    """The check with the factors of its runs in place of those to first order."""
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
    """What a law that fails looks like; what is left where gains explain it, percent of control."""
    declared = by_gains.percent
    large = declared >= MAX_LAW_RESIDUAL.value
    about_mean = by_gains.residuals - by_gains.residuals.mean()
    besides = relative_error_percent(about_mean, by_gains.control)
    by_constant = CONSTANT in by_gains.lean and besides < MAX_LAW_RESIDUAL.value
    if by_constant if large else not by_gains.off:
        leaning = constant_or_drift(declared, by_gains.lean, axis.drive.unit)
        return declared, replace(check, finding=leaning)
    far = [n for n, value in check.factors.items() if n != LIMIT and not is_near(value, 1.0)]
    only_size = (far or by_gains.off) == [INJECTED]
    # A gain may be a little off beside it.
    is_of_gains = by_gains.gains_off or not only_size
    explained, change = explained_by_gains(by_gains) if is_of_gains else (None, None)
    if only_size and change is None:
        size = OtherInjectedSize(residual_percent=declared, is_large=large)
        return declared, replace(check, finding=size)
    unexplained = UnexplainedControl(
        residual_percent=declared,
        is_large=large,
        may_be_injected=large and record.injected is None,
    )
    check = replace(check, finding=explained or unexplained)
    if change is None:
        scaled = by_gains.scale
        # Far from 1, those by runs are not right to first order.
        if by_gains.along.law.gains and not by_gains.along.law.is_polynomial:
            check = replace(check, factors={}, deviations={})
        return declared if scaled is None else scaled[1].percent, check
    # What shows in no slope is right too where the change explains the control.
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

    It is a note where the record was resampled, and its rows before are what the law read.
    """
    needs_no_resampling = law.passed and law.reading == "sampled rows"
    return Check(
        name="control law",
        status="note" if needs_no_resampling else status_of(law.passed),
        figure=law.residual_percent,
        threshold=MAX_LAW_RESIDUAL.value,
        source="residual in percent of the recorded control, 0.24 on the EMPS record; fails too "
        "where a factor of the law differs from 1, or a constant or a drift is found next to the "
        "law, by more than 1 % and three standard errors, for a delay, and for a sampling period "
        "that differs from the law's by more than 0.05 %",
        finding=law.finding,
    )


def _incomparable(
    axis: GeneratedAxis, law: ControlLaw, record: Record
) -> LawAgreement | Missing | None:
    """Why a record is not compared with a law, or is of another one by its period alone."""
    # The period is the only thing of a law that can be checked without a reference.
    clock = law_clock(law, record)
    if clock.other is not None:
        # A law of differences has other gains at another period, and its record another time.
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
            "what was added to the control is in the record only as the drive passes on both: "
            f"its {' and '.join(axis.drive.path.declared)}",
        ),
        (
            record.integrated,
            "no position was recorded; the velocity's integral drifts away from it",
        ),
        (
            clock.resampled and (clock.ratio is None or bool(clock.confirmed)),
            f"the record was resampled at {1 / record.period:.6g} Hz, the control law runs at "
            f"{1 / law.period:.6g} Hz",
        ),
        (True, ""),
    )
    return Missing(why) if why else None


@dataclass(frozen=True, slots=True)
class EstimatedGains:
    """Gains of a law that were found together with parameters.

    Attributes
    ----------
    names : tuple of str
    covariance : (k, k) array
        Of what was found; infinite variances of what is not known at all.
    freedom : float
        Degrees of freedom of that.
    """

    names: tuple[str, ...]
    covariance: Array
    freedom: float


def found_law_agreement(
    axis: GeneratedAxis, record: Record, found: EstimatedGains
) -> LawAgreement | Missing:
    """Check an axis's control law, some gains of which were found, against a record.

    Parameters
    ----------
    axis : GeneratedAxis
        Its law has the gains that were found.
    record : Record
    found : EstimatedGains
        None of its gains is taken as exact.

    Returns
    -------
    LawAgreement or Missing
        Of the law with the values of those gains that the recorded control asks for; it fails where
        they are not the ones that were found. Where that law is not the control's, of the axis's.
    """
    law, first, names = axis.control, law_agreement(axis, record), found.names
    if law is None or not names or isinstance(first, Missing) or first.residual_percent is None:
        return first
    record = record.longest()
    by_gains = GainRegression.of(axis, law, record, *compared_with_law(axis, law, record)[2:])
    best = by_gains.best(names)
    there = law_agreement(axis.with_gains(best.gains), record)
    if isinstance(there, LawAgreement) and there.passed:
        return _beside_found(there, best, law, found)
    return first


def _beside_found(
    there: LawAgreement, best: GainRegression, law: ControlLaw, found: EstimatedGains
) -> LawAgreement:
    """Return the check of the law with the gains of the control, compared with those found."""
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
    """How far (k,) differences are from 0, as deviations of a normal one that is as unlikely.

    What has no chance at all is as far as the least one that a number can be, 37.
    """
    square, directions = wald(off, covariance)
    if not directions:
        return 0.0
    p_value = max(hotelling_p_value(square, directions, freedom), float(np.finfo(float).tiny))
    return -float(ndtri(p_value / 2))
