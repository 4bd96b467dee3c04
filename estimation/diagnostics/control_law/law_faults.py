"""Which fault it looks like where a recorded control is not the declared law's; what mends it.

A position that is recorded from another zero than the reference is a tracking error to the law that
does not change: a control of so many volts where the law is of gains alone, a ramp where it
integrates. The first is what a constant error of the recorded control is too, so that both are
told.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis, build
from axisid.estimation.law_replay import with_limit
from axisid.estimation.records import Record, at_times
from axisid.estimation.records.columns import expected_units, scale_remedy
from axisid.estimation.thresholds import MAX_LAW_RESIDUAL, MAX_SCALE_ERROR, MIN_SAMPLES_PER_FACTOR
from axisid.modeling.declaration import ControlLaw, velocity_variants
from axisid.support.arrays import Array
from axisid.support.errors import ModelError, first_case

from .control_residuals import (
    DRIFT,
    MAX_FACTOR_ERROR,
    MOST_SHIFT,
    compared_with_law,
    law_error_percent,
)
from .gain_regression import GainRegression

# of the declared law's residual, below which a change of columns is told
_MAX_REPAIRED_RESIDUAL = 0.5


_UNITS = {
    1e3: "metres for millimetres",
    1e-3: "millimetres for metres",
    math.pi / 180: "degrees for radians",
    180 / math.pi: "radians for degrees",
}
_STEP = 1e-3  # of the reference's range
_CLOCK_STEP = 0.01  # samples at the end of a record, by another clock
_CLOCK_STEPS = 15  # of Gauss and Newton
_MOST_CLOCK = 0.02  # beyond, a clock is of another unit


def off_text(percent: float) -> str:
    """How far a control is from the law's, and of what that is a share."""
    return (
        f"off by {percent:.3g} % of the control"
        if percent < 100
        else "off by more than the whole control"
    )


def lean_text(unit: str, lean: Mapping[str, float]) -> str:
    """What a control that leans looks like, in the drive's unit.

    A position from another zero makes as much of a constant, where the law does not integrate.
    """
    leaning = " and ".join(f"a {name} of {value:.3g} {unit}" for name, value in lean.items())
    return (
        "the recorded control is the declared law's but for "
        f"{leaning}{' over the record' * (DRIFT in lean)}: check the offset of the control, the "
        "zero of the position beside the reference, or an integral of the drive that the law does "
        "not declare; it moves friction and offsets"
    )


def scale_text(times: float, left: str = "") -> str:
    """What a control is that is so many times the law's, what is left then, and what to check."""
    if times < 0:
        return (
            f"its sign is opposite to the law's{left}; check the sign of the control, of the "
            "positions or of the gains, and which column is the position and which the reference"
        )
    units = (
        f" (one unit stands for another, such as {unit})"
        for scale, unit in _UNITS.items()
        if is_near(times, scale)
    )
    return (
        f"the control is recorded {times:.4g} times as large as it is{next(units, '')}, which "
        f"scales every estimate{left}; check its unit and scaling, or those that position and "
        "reference share"
    )


def is_near(factor: float, scale: float) -> bool:
    """Whether a factor is one that would be exact, but for what else is wrong."""
    return abs(factor / scale - 1) < MAX_FACTOR_ERROR


def late_note(shift: int, delay: int | None) -> tuple[str, str]:
    """By how much a control is not in time, and what puts it there.

    Which of law and log is to blame, the law alone does not tell.
    """
    start = "the recorded control is not in time with the declared law: it"
    samples = f"{abs(shift)} sample{'s' * (abs(shift) > 1)}"
    if abs(shift) == MOST_SHIFT:
        return f"{start} is shifted by {samples} or more; check the clocks and the columns", ""
    possible = delay is not None and delay + shift >= 0
    early = "earlier" if possible or delay is None else "before the law could give it"
    declared = f"declare delay={(delay or 0) + shift}, or, " * possible
    advice = (
        f"{declared}where the log writes the control "
        f"{'before the drive applies' if shift < 0 else 'after the drive applied'} it, move it "
        f"(add {-shift} to shift.control in run.toml)"
    )
    return f"{start} comes {samples} {'later' if shift > 0 else early}; ", advice


#: What may mend a law: what is then said, and axis, law and record of it.
_Repair = tuple[str, GeneratedAxis, ControlLaw, Record]


def repair_of(
    axis: GeneratedAxis, law: ControlLaw, record: Record, declared: float, shift: int
) -> tuple[float, str] | None:
    """What would make the law fit: columns changed, or its velocity formed otherwise; or None.

    The residual of the law then, in percent of the control, and the words.

    It leaves half of what is `declared` at the most: of what the declared law leaves, or gains
    that explain the control. Where that is only some samples early or late, there is nothing else
    to mend. What has numbers of its own explains what a moved column does, nearly, and comes last.
    """
    good = min(MAX_LAW_RESIDUAL.value, _MAX_REPAIRED_RESIDUAL * declared)
    kinds = [_changed_columns, _scaled_columns, _mistimed_columns]
    kinds += [_moved_zero, _other_laws, _limited]
    if shift:
        if law_error_percent(axis, law, record.shifted(control=-shift)) < good:
            return None
        kinds = [_mistimed_columns]
    for kind in kinds:
        tried = [
            (law_error_percent(of, by, other), said)
            for said, of, by, other in kind(axis, law, record)
        ]
        least, note = min(tried, key=lambda each: each[0], default=(np.inf, None))
        if note is not None and least < good:
            return least, note
    return None


def _other_laws(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Repair]:
    for name, variant in velocity_variants(law).items():
        yield (
            f"it is that of the law {name} with the same gains, which forms the velocity in "
            "another way: declare that",
            build(replace(axis.axis, control=variant), native=False),
            variant,
            record,
        )


def _moved_zero(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Repair]:
    if (zero := position_zero(axis, law, record)) is None:
        return
    away, control = zero
    unit, drive = axis.coordinate.unit, axis.drive
    name = record.provenance.columns.get("position", "NAME")
    back = f"columns position={name}:UNIT{-away:+.3g}{unit}"
    constant = f"{control or 0.0:.3g} {drive.unit}"
    said = first_case(
        (control is None, f": take that off ({back})"),
        (
            abs(control or 0.0) > drive.limit,
            f", which the law makes {constant} of, more than the drive gives: take "
            f"that off the position ({back})",
        ),
        (
            True,
            f", or with a constant of {constant} off the control, which the law "
            "makes of it: a constant force that the model does not explain, or an offset that "
            "should be nothing, would say that it is the control's; take the one off the position "
            f"({back}), or check the control's offset, or an integral of the drive that the "
            "law does not declare",
        ),
    )
    yield (
        f"it is with the position {away:+.3g} {unit} away from its zero beside the "
        f"reference (a constant tracking error of as much){said}",
        axis,
        law,
        replace(record, position=record.position - away),
    )


def _limited(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Repair]:
    drive, control = axis.drive, np.asarray(record.control)
    largest = float(np.abs(control).max())
    if drive.logs_what_acts or largest >= drive.limit:
        return
    try:
        _, made, *_ = compared_with_law(with_limit(axis, largest, native=False), law, record)
        cut = np.abs(control[made * np.sign(control) > largest])
        if len(cut) < MIN_SAMPLES_PER_FACTOR.value:
            return
        # The largest has the most of a converter's noise, the median has none.
        limit = float(np.median(cut))
        limited = with_limit(axis, limit, native=False)
    except ModelError:  # no dead band and no step is as large as the limit
        return
    yield (
        f"it is with a drive that is at its limit of {limit:.6g} {drive.unit} in "
        f"{(made * np.sign(control) > limit).sum()} samples: declare that limit",
        limited,
        law,
        record,
    )


def _mistimed_columns(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Repair]:
    """The record with a column some samples earlier or later, or the reference on another clock."""
    yield from _moved_columns(axis, law, record)
    rate = reference_clock(axis, law, record)
    if rate is None:
        return
    fast = "fast" if rate > 0 else "slow"
    yield (
        f"it is with the times of the reference {1e6 * abs(rate):.4g} ppm "
        f"{'shorter' if rate > 0 else 'longer'}: the clock that stamps the reference is "
        f"{fast} by as much compared with that of the position. Record both with one clock",
        axis,
        law,
        _with_clock(record, rate),
    )


def _with_clock(record: Record, rate: float) -> Record:
    """The record with the reference of ``(1 + rate)`` times each time since the first sample."""
    times = np.arange(float(len(record)))
    later = np.minimum((1 + rate) * times, times[-1])
    reference = at_times(later, times, np.asarray(record.reference), "spline")
    known = int(np.count_nonzero((1 + rate) * times <= times[-1]))
    masked = record.masked if known == len(record) else (*record.masked, (known, len(record)))
    return replace(record, reference=reference, masked=masked)


def reference_clock(axis: GeneratedAxis, law: ControlLaw, record: Record) -> float | None:
    """How much faster the reference has to run to give the recorded control; None without end.

    By Gauss and Newton, relative to the clock of the position.

    Parameters
    ----------
    axis : GeneratedAxis
    law : ControlLaw
        Of the axis.
    record : Record
        Of one piece, with a reference and a control.
    """
    if not np.ptp(np.asarray(record.reference)):
        return None
    rate, step = 0.0, _CLOCK_STEP / len(record)
    for _ in range(_CLOCK_STEPS):
        here, moved = _with_clock(record, rate), _with_clock(record, rate + step)
        steps, _slope = _asked_for(axis, law, here, moved)
        change = step * steps
        if not np.isfinite(change) or abs(rate + change) > _MOST_CLOCK:
            return None
        rate += change
        if abs(change) < step:
            return rate if abs(rate) * len(record) > _CLOCK_STEP else None
    return None


def _moved_columns(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Repair]:
    for samples in (1, -1, 2, -2):
        for role in ("reference", "position", *sorted(map(str, law.signals))):
            way = "later" if samples > 0 else "earlier"
            yield (
                f"it is with the {role} {abs(samples)} sample{'s' * (abs(samples) > 1)} {way}: "
                f"where the log wrote it at another time, move it (add {samples} to shift.{role} "
                "in run.toml)",
                axis,
                law,
                record.shifted(**{role: samples}),
            )


def _changed_columns(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Repair]:
    """The record as it would be without a common mistake in its columns."""
    reference, injected = np.asarray(record.reference), record.injected
    moves, is_added = bool(np.ptp(reference)), injected is not None
    there = "reference" if record.injected_at == "control" else "control"
    columns: tuple[tuple[bool, str, dict[str, Any]], ...] = (
        (
            moves,
            "position and reference exchanged: check which column is which",
            {"position": reference, "reference": record.position},
        ),
        (is_added, f"the test signal added to the {there}", {"injected_at": there}),
        (
            is_added,
            "the test signal times -1: check its sign",
            {"injected": None if injected is None else -injected},
        ),
        (
            is_added and moves,
            "no test signal: check which column it is",
            {"injected": None},
        ),
    )
    for may_be, said, changed in columns:
        if may_be:
            yield f"it is with {said}", axis, law, replace(record, **changed)


def _scaled_columns(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Repair]:
    """The record with one column times what the law asks for.

    Position and reference follow each other, so that the law is asked where they are about alike:
    far away it may be at a limit of its own.
    """
    columns, pair = record.channels(), ("position", "reference")
    covariance = np.cov([columns[role] for role in pair])
    # Without a motion of the reference a test signal alone moves the axis.
    told = pair if np.ptp(columns["reference"]) else ()
    near = {r: covariance[0, 1] / covariance[i, i] for i, r in enumerate(told)}
    for role in (*pair, *sorted(map(str, law.signals))):

        def scaled(times: float, role: str = role) -> Record:
            return record.with_channels({**columns, role: times * columns[role]})

        start = float(near.get(role, 1.0))
        steps, _ = _asked_for(axis, law, scaled(start), scaled((1 + _STEP) * start))
        times = start * (1 + _STEP * steps)
        if not np.isfinite(times):
            continue
        name, (unit,) = record.provenance.columns.get(role, "NAME"), expected_units(role, axis.axis)
        remedy = scale_remedy(role, name, unit, 1 / times, MAX_SCALE_ERROR.value) or (
            f"columns {role}={name}:UNIT*{times:.4g}"
        )
        # What the column was scaled by already is not in the record.
        yield (
            f"it is with the {role} times {times:.4g}: correct its unit, scaling or sign (where "
            f"none is said of it, {remedy})",
            axis,
            law,
            scaled(times),
        )


def _asked_for(
    axis: GeneratedAxis, law: ControlLaw, record: Record, moved: Record
) -> tuple[float, Array]:
    """How many times a step of the record explains most of what the law leaves; what one changes.

    That is of the control, in the samples that count. NaN where the step does nothing.
    """
    control, made, used, _ = compared_with_law(axis, law, record)
    slope = (compared_with_law(axis, law, moved)[1] - made)[used]
    power = float(slope @ slope)
    return float(slope @ (control - made)[used]) / power if power > 0 else math.nan, slope


def position_zero(
    axis: GeneratedAxis, law: ControlLaw, record: Record
) -> tuple[float, float | None] | None:
    """How far the recorded position is from where the law read it; None where that does nothing.

    By how much it is more than the one beside the reference, SI, which explains most of what the
    law leaves; and the constant control that does the same, None for a law that integrates.

    Parameters
    ----------
    axis : GeneratedAxis
    law : ControlLaw
        Of the axis.
    record : Record
        Of one piece, with a reference and a control.
    """
    step = _STEP * float(np.ptp(np.asarray(record.reference))) or _STEP
    steps, slope = _asked_for(axis, law, record, replace(record, position=record.position + step))
    if not np.isfinite(steps):
        return None
    mean = float(np.mean(slope))
    is_constant = float(np.ptp(slope)) <= MAX_SCALE_ERROR.value * abs(mean)
    return -step * steps, mean * steps if is_constant else None


def explained_by_gains(by_gains: GainRegression) -> tuple[str, GainRegression | None]:
    """The least change of gains that explains the control, in words, and the law with it.

    A control that is recorded with another scale is what such a gain may make of it too.
    """
    declared, said = by_gains.along.law.gains, ""
    changes = by_gains.least_change() if declared else ()
    right = (e for e in changes if e.percent < MAX_LAW_RESIDUAL.value and not e.gains_off)
    if (best := next(right, None)) is not None:
        ways = "; or ".join(
            " and ".join(
                f"{name} is {times:.4g} times the declared one, {change.gains[name]:.5g} for "
                f"{declared[name]:.5g}"
                for name, times in change.times.items()
            )
            for change in changes
        )
        these = "that" if len(best.free) == 1 else "these"
        rest = first_case(
            (len(changes) > 1, "the record does not tell which"),
            (
                len(declared) > len(best.free),
                f"and every other gain is right; declare {these}",
            ),
            (True, f"declare {these}"),
        )
        said = f"{ways}, {rest}"
    if by_gains.scale is not None:
        times, scaled = by_gains.scale
        said = (
            f"{said}; or {scale_text(times)}: the law alone does not tell which"
            if said
            else scale_text(times, f", with which it would be {off_text(scaled.percent)}")
        )
    return said, best
