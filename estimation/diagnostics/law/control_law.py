"""The declared control law against what the drive did.

The recorded control is regressed on the law's own terms, computed from the recorded reference and
position, and on a test signal that was added to it. Every factor must be 1. What they are instead
tells the fault: millimetres for metres, a flipped sign, another gain, another clock, a delay. A law
that takes an ideal sensor's velocity is compared after a zero-phase low-pass of both sides, since
that velocity is not recorded; the identification's own filter plays no part.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.checks import Check, passed
from axisid.estimation.loops import hides_command
from axisid.estimation.records import Record, clock_of, law_ratio, other_period
from axisid.estimation.regression import lacking_law, lacking_loop
from axisid.estimation.signals import Neighbours
from axisid.estimation.thresholds import (
    MAX_LAW_RESIDUAL,
    MIN_DISTANCE_FROM_NOISE,
    MIN_SAMPLES_PER_FACTOR,
)
from axisid.modeling.declaration import ControlLaw
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.missing import Missing
from axisid.support.remedy import Note, Remedy

from .by_runs import GainsBeside, said_of_gains
from .factors import (
    best_shift,
    fitted_factors,
    lean_of,
    leaning,
    scaled_factors,
)
from .sentences import (
    CONSTANT,
    INJECTED,
    MAX_FACTOR_ERROR,
    are_alike,
    large_fault,
    late_note,
    off_text,
    one_gain,
    remedy_by_test_signal,
    repair_of,
    small_fault,
)
from .terms import (
    compared_as,
    compared_with_law,
    left_open_percent,
    residual_percent,
    settling,
)
from .unevenly import LawReading, is_uneven, open_for_jitter, other_readings

# least deviation of a factor of a law that reads an ideal velocity, which is in no log: measured,
# up to 2.4e-4 off on twins without noise, 1e-5 to 1e-4 on whole ones
_FACTOR_BLUR = 1e-4
# what a law leaves of the control by what the log leaves open, up to which it may be right: of
# right laws behind logs that round to 1 to 20 um it is 0.6 to 1.1 times that
_MOST_OPEN = MIN_DISTANCE_FROM_NOISE.value


@dataclass(frozen=True, slots=True, kw_only=True)
class LawCheck:
    """The recorded control against the declared law.

    Attributes
    ----------
    factors : dict of str to float
        By product of gains, or by gain of a law that is no sum of such products (how many times the
        declared one it is), and ``injected`` for a test signal that was added to the control; each
        is 1 if the law is the drive's. Empty where the record cannot tell them apart.
    residual_percent : float or None
        ``100 ||control - law|| / ||control||``, with the law as declared; None for a record of
        another period than the law's.
    fitted_residual_percent : float
        The same with the factors: what no gain explains. None without factors.
    delay : int
        Samples by which the recorded control follows the declared law best.
    passed : bool
        Whether instruments simulated with this law can be believed.
    meaning : str
        One sentence for the user, up to the remedy where there is one.
    remedy : Remedy or None
        How it goes on, where something can be set about it.
    deviations : mapping of str to float
        HAC ones of the factors; empty where they are not known.
    found_apart : bool
        Whether the law is the control's, by other gains than a fit has found.
    """

    factors: dict[str, float]
    residual_percent: float | None
    fitted_residual_percent: float | None
    delay: int
    passed: bool
    meaning: str
    remedy: Remedy | None = None
    deviations: Mapping[str, float] = field(default_factory=dict)
    found_apart: bool = False

    @property
    def note(self) -> Note:
        """The whole sentence, to be worded later."""
        return Note(self.meaning, self.remedy)

    @property
    def unexplained(self) -> float:
        """What no factors of the law's terms explain, percent."""
        left = self.fitted_residual_percent
        return float((self.residual_percent if left is None else left) or 0.0)

    @property
    def is_told_by_factors(self) -> bool:
        """Whether the control is the law's but for its factors, which are all there is to mend."""
        left = self.fitted_residual_percent
        explained = (
            left is not None
            and left < MAX_LAW_RESIDUAL.value
            and not (self.delay or self.found_apart)
        )
        return explained and bool(self.factors) and min(self.factors.values()) > 0


def first_law(records: Sequence[tuple[GeneratedAxis, Record]]) -> LawCheck | Missing:
    """The check of the first of several records that fails it, else that of the first of all.

    Each record comes with its axis, whose law may have gains that are known of it.
    """
    return first_failing([check_law(axis, record) for axis, record in records])


def first_failing(laws: Sequence[LawCheck | Missing]) -> LawCheck | Missing:
    """The first check that fails its record, those before that factors tell; else the first."""
    failing = [each for each in laws if isinstance(each, LawCheck) and not each.passed]
    return min(failing, key=lambda each: each.is_told_by_factors, default=laws[0])


def check_law(axis: GeneratedAxis, record: Record) -> LawCheck | Missing:
    """Check an axis's control law against a record; or say why it cannot be checked."""
    law = axis.axis.control
    if law is None:
        return Missing.of(lacking_law(axis).note)
    incomparable = _incomparable(axis, law, record)
    if incomparable is not None:
        return incomparable
    found = _compared(axis, law, record, advises=False)
    if isinstance(found, Missing) or found.passed:
        return found
    return _read_otherwise(axis, law, record, found) or _compared(axis, law, record)


def _read_otherwise(
    axis: GeneratedAxis, law: ControlLaw, record: Record, found: LawCheck
) -> LawCheck | Missing | None:
    """The check by what else the law may have read where times are uneven; None for nothing."""
    if not is_uneven(record):
        return None
    every = [
        (_compared(axis, law, each.record, advises=False), each) for each in other_readings(record)
    ]
    told = [(check, reading) for check, reading in every if isinstance(check, LawCheck)]
    for check, reading in told:
        if check.passed:
            return _with_reading(check, found, reading)
    best, nearest = min([(found, None), *told], key=lambda each: each[0].unexplained)
    left = open_for_jitter(axis, record, float(best.residual_percent or 0.0))
    if left is None or best.unexplained < MAX_LAW_RESIDUAL.value:
        if nearest is None:
            return None
        said = _compared(axis, law, nearest.record)
        return said if isinstance(said, Missing) else _with_reading(said, found, nearest)
    return Missing(
        "the record's samples are off even times, and what the law read between them, noise above "
        f"all, leaves {left:.2g} % of its control open ({best.residual_percent:.2g} % off)"
    )


def _with_reading(law: LawCheck, found: LawCheck, reading: LawReading) -> LawCheck:
    """A check of what the law may have read, which says so, beside that of the samples."""
    as_it_is = f"it is {found.residual_percent:.2g} % off as the record has them"
    if not law.passed:
        return replace(law, meaning=f"{reading.said}, {law.meaning}")
    return replace(
        law,
        meaning=f"{law.meaning}, {reading.said}; {as_it_is}" + ": " * (reading.remedy is not None),
        remedy=reading.remedy,
    )


def _compared(
    axis: GeneratedAxis, law: ControlLaw, record: Record, *, advises: bool = True
) -> LawCheck | Missing:
    """A law against the samples of a record, with what would mend it where that is asked for."""
    record = record.longest()  # a law's memory does not outlast a gap
    if len(record.position) < 2 * settling(law) + MIN_SAMPLES_PER_FACTOR.value * len(law.terms):
        return Missing(f"the record is too short for it, {len(record.position)} samples")
    control, terms, used = compared_with_law(axis, law, record)
    if not np.all(np.isfinite(terms)):
        return Missing("the declared law is not finite on this record")
    if used.sum() < MIN_SAMPLES_PER_FACTOR.value * terms.shape[1]:
        return Missing("the control is at the drive's limit, or masked, nearly all the time")
    left_open = left_open_percent(axis, record, used)
    declared = residual_percent(control, terms, used)
    if left_open > MAX_LAW_RESIDUAL.value and declared < _MOST_OPEN * left_open:
        return Missing(
            f"the record is sampled every {record.period:.6g} s, the control law runs every "
            f"{law.period:.6g} s, and what it reads between the samples, noise above all, leaves "
            f"{left_open:.2g} % of its control open"
        )
    shift = best_shift(terms.sum(axis=1), control, used)
    # An integral shows its start along the whole record, and wrong gains move what starts it.
    by_terms = law.is_polynomial and not law.balanced and not hides_command(axis)
    told = (
        _by_products(axis, law, record, control, terms, used)
        if not law.gains or by_terms
        else _by_gains(axis, law, record, used, shift)
    )
    if isinstance(told, Missing):
        return told
    (check, faulty), declared = told, float(told[0].residual_percent or 0.0)
    between = f"; what it reads between the samples leaves {left_open:.2g} % open"
    check = replace(
        check,
        delay=shift,
        passed=check.passed and declared < MAX_LAW_RESIDUAL.value and not shift,
        meaning=f"the declared law reproduces the recorded control to {declared:.2g} % of "
        f"its norm{between * (left_open > 0)}",
    )
    if check.passed or not advises:
        return check
    explained, fault = faulty(check)
    if explained and (repair := repair_of(axis, law, record, explained, shift)):
        said = f"the recorded control is not the declared law's ({off_text(declared)}), but "
        return replace(check, meaning=said + repair.text, remedy=repair.remedy)
    if shift:
        late = late_note(shift, None if law.continuous else law.delay)
        return replace(check, meaning=late.text, remedy=late.remedy)
    return fault


def law_beside(axis: GeneratedAxis, law: ControlLaw, record: Record) -> GainsBeside:
    """A law beside a record with which it can be compared, by its gains."""
    record = record.longest()
    _, _, used = compared_with_law(axis, law, record)
    return GainsBeside.of(axis, law, record, used, compared_as(law, record))


#: A check that is not worded yet, and what words it where it fails, with what explains the control.
_Told = tuple[LawCheck, Callable[[LawCheck], tuple[float, LawCheck]]]


def _by_products(
    axis: GeneratedAxis,
    law: ControlLaw,
    record: Record,
    control: Array,
    terms: Array,
    used: NDArray[np.bool_],
) -> _Told:
    """Of a law that is a sum of products of gains with signals that have none."""
    names = [str(product) for product, _ in law.terms]
    names += [] if record.added_control is None else [INJECTED]
    following = Neighbours.of(np.flatnonzero(used), 1)
    factors, deviations, fitted = fitted_factors(control[used], terms[used], names, following)
    if law.takes_velocity:  # which is in no log
        blur = _FACTOR_BLUR
        deviations = {name: float(np.hypot(own, blur)) for name, own in deviations.items()}
    scaled = scaled_factors(factors, deviations)
    if law.takes_velocity and abs(scaled.get(INJECTED, np.inf) - 1) < MAX_FACTOR_ERROR:
        del scaled[INJECTED]  # the velocity that is compared is not the sensor's to a hundredth
    left, declared = (control - terms.sum(axis=1))[used], residual_percent(control, terms, used)
    lean = lean_of(left, control[used], following)

    def fault(check: LawCheck) -> tuple[float, LawCheck]:
        simple = bool(one_gain(law, factors)) or are_alike(factors)
        explained = fitted if fitted is not None and simple else declared
        if declared < MAX_LAW_RESIDUAL.value:
            said = small_fault(axis, record, scaled, lean, factors)
            return explained, replace(check, meaning=said)
        level = relative_error_percent(left - left.mean(), control[used]) < MAX_LAW_RESIDUAL.value
        constant = lean.get(CONSTANT) if level else None
        said = large_fault(law, factors, deviations, declared, fitted, constant)
        remedy = remedy_by_test_signal(record, fitted, constant)
        return explained, replace(check, meaning=said, remedy=remedy)

    check = LawCheck(
        factors=factors,
        deviations=deviations,
        residual_percent=declared,
        fitted_residual_percent=fitted,
        delay=0,
        passed=not (scaled or lean),
        meaning="",
    )
    return check, fault


def _by_gains(
    axis: GeneratedAxis, law: ControlLaw, record: Record, used: NDArray[np.bool_], shift: int
) -> _Told | Missing:
    """Of a law that is limited, filtered or has an integral, by runs of it."""
    beside = GainsBeside.of(axis, law, record, used, compared_as(law, record))
    declared, left = beside.percent(beside.point), beside.left(beside.point)
    # A shift that explains the control shows through whatever the log rounds.
    if not shift and _is_hidden(declared, beside):
        beside = beside.unless_rounded()
    if not shift and _is_hidden(declared, beside):
        return Missing(
            "what the log rounds of position and reference leaves "
            f"{beside.open_percent:.2g} % of the declared law's control open"
        )
    times = beside.times(beside.point)
    off = [name for name, (_, clear) in times.items() if clear]
    leans = [leaning(each, beside.neighbours)[0] for each in beside.left_open(beside.point)]
    open_ = MIN_DISTANCE_FROM_NOISE.value * np.abs([np.zeros(2), *leans]).max(axis=0)
    lean = lean_of(left, beside.compared(beside.along.control), beside.neighbours, open_)
    large = declared >= MAX_LAW_RESIDUAL.value

    def fault(check: LawCheck) -> tuple[float, LawCheck]:
        start = f"the recorded control is not the declared law's ({off_text(declared)}): "
        flipped = beside.flipped_percent(MAX_LAW_RESIDUAL.value) if large and not shift else None
        if flipped is not None:
            said = (
                f"{start}its sign is opposite to the law's, with which it would be "
                f"{off_text(flipped)}; check the sign of the control or of the positions"
            )
            return 0.0, replace(check, factors={}, meaning=said)
        if not large:
            start = "the recorded control is the declared law's but for its gains: "
        said, change = said_of_gains(beside, start)
        explained = declared if change is None or len(change.times) > 1 else change.percent
        if not (off or large):
            return explained, replace(check, meaning=small_fault(axis, record, {}, lean, {}))
        if change is None:
            remedy = remedy_by_test_signal(record, None) if large else None
            return explained, replace(check, factors={}, meaning=said, remedy=remedy)
        factors = {**dict.fromkeys(times, 1.0), **change.times}
        return explained, replace(
            check, factors=factors, fitted_residual_percent=change.percent, meaning=said
        )

    check = LawCheck(
        factors={name: value for name, (value, _) in times.items()},
        residual_percent=declared,
        fitted_residual_percent=declared,
        delay=0,
        passed=not (off or lean),
        meaning="",
    )
    return check, fault


def _is_hidden(declared: float, beside: GainsBeside) -> bool:
    """Whether what the log rounds hides whether the law is right."""
    rounded = beside.open_percent
    is_much = max(declared, rounded) >= MAX_LAW_RESIDUAL.value
    return is_much and declared < _MOST_OPEN * rounded


def law_check(law: LawCheck | Missing) -> Check | Missing:
    """The declared law against the recorded control."""
    if isinstance(law, Missing):
        return law
    return Check(
        name="control law",
        # What is to be said of a law that fits is said.
        status="note" if law.passed and law.remedy is not None else passed(law.passed),
        figure=law.residual_percent,
        threshold=MAX_LAW_RESIDUAL.value,
        source="residual in percent of the recorded control, 0.24 on the EMPS record; fails too "
        "where a factor is off 1, or a constant or a drift beside the law there, by more than 1 % "
        "and three deviations, for a delay, and for a "
        "sampling period that is more than 0.05 % from the law's",
        meaning=law.meaning,
        remedy=law.remedy,
    )


def _incomparable(
    axis: GeneratedAxis, law: ControlLaw, record: Record
) -> LawCheck | Missing | None:
    """Why a record is not compared with a law, or is of another one by its period alone."""
    clock = clock_of(record)
    # The period is the only thing of a law that can be checked without a reference.
    apart = other_period(law, record.period, clock)
    if apart is not None and not apart.confirmed:
        # A law of differences has other gains at another period, and its record another time.
        return LawCheck(
            factors={},
            residual_percent=None,
            fitted_residual_percent=None,
            delay=0,
            passed=False,
            meaning=apart.note.text,
            remedy=apart.note.remedy,
        )
    lacking = lacking_loop(axis, record)
    if lacking is not None or record.control is None:
        clocks = f"{apart.note.text}; " if apart is not None else ""
        why = "the record has no control" if lacking is None else lacking.note
        return Missing.of(Note.of(clocks, why))
    if record.added_control is not None and hides_command(axis):
        return Missing(
            "what was added to the control is in the record only as the drive passes on both: its "
            f"{' and '.join(axis.axis.drive.path.declared)}"
        )
    if record.integrated:
        return Missing("no position was recorded; the velocity's integral drifts away from it")
    if clock.step != 1 and (apart is not None or law_ratio(law, record.period, clock) is None):
        return Missing(
            f"the record was resampled at {1 / record.period:.6g} Hz, the control law runs at "
            f"{1 / law.period:.6g} Hz"
        )
    return None
