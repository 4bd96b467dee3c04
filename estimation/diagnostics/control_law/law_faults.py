"""Faults of a recorded control that does not follow the declared law, and their remedies.

If the position is recorded relative to another zero than the reference, the law sees a constant
tracking error. Its control then has a constant for a law of gains alone, and a ramp for a law that
integrates. A constant error of the recorded control looks the same as the former, so both are
reported.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from operator import itemgetter

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis, build
from axisid.estimation.law_replay import with_limit
from axisid.estimation.records import Record, at_times
from axisid.estimation.records.columns import expected_units, likely_unit
from axisid.estimation.thresholds import MAX_LAW_RESIDUAL, MAX_SCALE_ERROR, MIN_SAMPLES_PER_FACTOR
from axisid.modeling.declaration import ControlLaw, velocity_variants
from axisid.support.arrays import Array
from axisid.support.errors import ModelError

from .control_residuals import (
    CONSTANT,
    DRIFT,
    INJECTED,
    MAX_FACTOR_ERROR,
    MOST_SHIFT,
    compared_with_law,
    law_error_percent,
)
from .gain_regression import GainRegression
from .law_findings import (
    ConstantOrDrift,
    ControlScale,
    ExchangedColumns,
    LateControl,
    LawRepair,
    MovedColumn,
    MovedZero,
    OtherGain,
    OtherGains,
    OtherScale,
    OtherTestSignal,
    OtherVelocity,
    ReferenceClock,
    ScaledColumn,
    UndeclaredLimit,
)

# residual relative to the declared law's, below which a change of columns is reported
_MAX_REPAIRED_RESIDUAL = 0.5
# factor of a control -> recorded unit, and the unit that it was taken for
_UNITS = {
    1e3: ("m", "mm"),
    1e-3: ("mm", "m"),
    math.pi / 180: ("deg", "rad"),
    180 / math.pi: ("rad", "deg"),
}
_UNKNOWN = "NAME"  # for a column without a name in a log
_STEP = 1e-3  # of the reference's range
_CLOCK_STEP = 0.01  # of the clock rate, in samples at the end of the record
_CLOCK_STEPS = 15  # of Gauss-Newton
_MOST_CLOCK = 0.02  # relative; beyond, the times are in another unit


def constant_or_drift(percent: float, lean: Mapping[str, float], unit: str) -> ConstantOrDrift:
    """Return the finding of a control with a constant or a drift next to the law.

    A position relative to another zero leads to such a constant too if the law does not integrate.

    Parameters
    ----------
    percent : float
        Residual, percent of the control.
    lean : mapping of str to float
        Significant constant and drift by name, in `unit`.
    unit : str
        Unit of the control.
    """
    return ConstantOrDrift(
        residual_percent=percent, constant=lean.get(CONSTANT), drift=lean.get(DRIFT), unit=unit
    )


def is_near(factor: float, scale: float) -> bool:
    """Return True if a factor equals a usual factor, `scale`, to 5 %.

    A law with other errors does not determine the factor more accurately.
    """
    return abs(factor / scale - 1) < MAX_FACTOR_ERROR


def late_control(percent: float, shift: int, delay: int | None) -> LateControl:
    """Return the finding of a control that is some samples later or earlier than by the law.

    The law alone does not show whether the law or the log is wrong.

    Parameters
    ----------
    percent : float
        Residual without the shift, percent of the control.
    shift : int
        Samples by which the control comes later.
    delay : int or None
        Declared delay of the law, samples; None for a continuous law.
    """
    is_possible = delay is not None and delay + shift >= 0
    return LateControl(
        residual_percent=percent,
        samples=shift,
        is_at_least=abs(shift) == MOST_SHIFT,
        is_before_law=delay is not None and not is_possible,
        blame="law or log",
        delay=(delay or 0) + shift if is_possible else None,
        shift=-shift,
    )


#: A change that may make a law fit: its finding, and the axis, the law and the record with it.
_Change = tuple[LawRepair, GeneratedAxis, ControlLaw, Record]


def repair_of(
    axis: GeneratedAxis, law: ControlLaw, record: Record, declared: float, shift: int
) -> tuple[float, LawRepair] | None:
    """Return the residual with a change that makes the law fit, percent, and the change.

    None where no change of the columns, of the law or of the drive's limit makes it fit. Kinds of
    changes are tried in order, and the best change of the first kind that fits is returned. A
    change has to halve the residual. Changes with a fitted number come last, because they nearly
    explain a moved column as well.

    Parameters
    ----------
    axis : GeneratedAxis
    law : ControlLaw
        Law of the axis.
    record : Record
        Record without gaps, with a reference and a control.
    declared : float
        Residual without a change, percent of the control: that of the declared law, or with gains
        that explain the control.
    shift : int
        Samples by which the control comes later than by the law. If it is not 0, only columns at
        other times are tried, and none if the shift alone makes the law fit.
    """
    good = min(MAX_LAW_RESIDUAL.value, _MAX_REPAIRED_RESIDUAL * declared)
    kinds = [_changed_columns, _scaled_columns, _mistimed_columns]
    kinds += [_moved_zero, _other_laws, _limited]
    if shift:
        if law_error_percent(axis, law, record.shifted(control=-shift)) < good:
            return None
        kinds = [_mistimed_columns]
    for kind in kinds:
        tried = list[tuple[float, LawRepair]]()
        for repair, of, by, other in kind(axis, law, record):
            tried.append((law_error_percent(of, by, other), repair))
        least, best = min(tried, key=itemgetter(0), default=(np.inf, None))
        if best is not None and least < good:
            return least, best
    return None


def _other_laws(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Change]:
    """Yield changes to a law that computes the velocity in another way, with the same gains.

    Each is a tuple of the finding, the axis with this law, this law, and the unchanged record.
    """
    for name, variant in velocity_variants(law).items():
        yield (
            OtherVelocity(law=name),
            build(replace(axis.axis, control=variant), native=False),
            variant,
            record,
        )


def _moved_zero(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Change]:
    """Yield the record with the zero of the position that explains most of the residual."""
    if (zero := position_zero(axis, law, record)) is None:
        return
    away, control = zero
    repair = MovedZero(
        position=away,
        unit=axis.coordinate.unit,
        column=record.provenance.columns.get("position", _UNKNOWN),
        control=control,
        control_unit=axis.drive.unit,
        exceeds_limit=abs(control or 0.0) > axis.drive.limit,
    )
    yield repair, axis, law, replace(record, position=record.position - away)


def _limited(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Change]:
    """Yield the axis with a limit of the drive that is below the declared one.

    The limit is that of the recorded control where the law asks for more. Nothing is yielded where
    the control reaches the declared limit, or where the law rarely asks for more.
    """
    drive, control = axis.drive, np.asarray(record.control)
    largest = float(np.abs(control).max())
    if drive.logs_what_acts or largest >= drive.limit:
        return
    try:
        _, made, *_ = compared_with_law(with_limit(axis, largest, native=False), law, record)
        cut = np.abs(control[made * np.sign(control) > largest])
        if len(cut) < MIN_SAMPLES_PER_FACTOR.value:
            return
        # The largest control has most of a converter's noise. The median has none.
        limit = float(np.median(cut))
        limited = with_limit(axis, limit, native=False)
    except ModelError:  # no dead band and no step is as large as the limit
        return
    samples = int((made * np.sign(control) > limit).sum())
    yield UndeclaredLimit(limit=limit, unit=drive.unit, samples=samples), limited, law, record


def _mistimed_columns(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Change]:
    """Yield records with a column at another time, or with the reference on another clock."""
    yield from _moved_columns(axis, law, record)
    rate = reference_clock(axis, law, record)
    if rate is None:
        return
    yield ReferenceClock(rate=rate), axis, law, _with_clock(record, rate)


def _with_clock(record: Record, rate: float) -> Record:
    """Return the record with the reference read at ``(1 + rate)`` times the time since the start.

    Samples beyond the end of the recorded reference are masked.
    """
    times = np.arange(float(len(record)))
    later = np.minimum((1 + rate) * times, times[-1])
    reference = at_times(later, times, np.asarray(record.reference), "spline")
    known = int(np.count_nonzero((1 + rate) * times <= times[-1]))
    masked = record.masked if known == len(record) else (*record.masked, (known, len(record)))
    return replace(record, reference=reference, masked=masked)


def reference_clock(axis: GeneratedAxis, law: ControlLaw, record: Record) -> float | None:
    """Return the relative amount by which the reference's clock is fast against the position's.

    It is the amount with which the law gives the recorded control, found by Gauss-Newton steps.
    None where these do not converge, where the clocks hardly differ, and for a constant reference.

    Parameters
    ----------
    axis : GeneratedAxis
    law : ControlLaw
        Law of the axis.
    record : Record
        Record without gaps, with a reference and a control.
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


def _moved_columns(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Change]:
    """Yield records with reference, position or a signal shifted by one or two samples."""
    for samples in (1, -1, 2, -2):
        for role in ("reference", "position", *sorted(map(str, law.signals))):
            moved = record.shifted(**{role: samples})
            yield MovedColumn(role=role, samples=samples), axis, law, moved


def _changed_columns(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Change]:
    """Yield records in which a common mistake in the columns is corrected.

    Position and reference may be exchanged; a test signal may enter at another point, have the
    opposite sign, or not enter at all.
    """
    reference, injected = np.asarray(record.reference), record.injected
    moves = bool(np.ptp(reference))
    if moves:
        exchanged = replace(record, position=reference, reference=record.position)
        yield ExchangedColumns(), axis, law, exchanged
    if injected is None:
        return
    if record.injected_at == "control":
        there = replace(record, injected_at="reference")
        yield OtherTestSignal(change="added to the reference"), axis, law, there
    else:
        there = replace(record, injected_at="control")
        yield OtherTestSignal(change="added to the control"), axis, law, there
    opposite = replace(record, injected=-injected)
    yield OtherTestSignal(change="opposite sign"), axis, law, opposite
    if moves:
        yield OtherTestSignal(change="none"), axis, law, replace(record, injected=None)


def _scaled_columns(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Change]:
    """Yield records with one column multiplied by the factor that fits the control best.

    Position and reference follow each other, so the factor is estimated where they are about equal:
    far away the law may be at a limit of its own.
    """
    columns, pair = record.channels(), ("position", "reference")
    covariance = np.cov([columns[role] for role in pair])
    # Without a motion of the reference a test signal alone moves the axis.
    scaled_roles = pair if np.ptp(columns["reference"]) else ()
    near = {r: covariance[0, 1] / covariance[i, i] for i, r in enumerate(scaled_roles)}
    for role in (*pair, *sorted(map(str, law.signals))):

        def scaled(times: float, role: str = role) -> Record:
            """Return the record with the column multiplied by a factor."""
            return record.with_channels({**columns, role: times * columns[role]})

        start = float(near.get(role, 1.0))
        steps, _ = _asked_for(axis, law, scaled(start), scaled((1 + _STEP) * start))
        times = start * (1 + _STEP * steps)
        if not np.isfinite(times):
            continue
        (unit,) = expected_units(role, axis.axis)
        # The record does not contain a scaling that was already applied to the column.
        repair = ScaledColumn(
            role=role,
            times=float(times),
            column=record.provenance.columns.get(role, _UNKNOWN),
            unit=likely_unit(unit, 1 / times, MAX_SCALE_ERROR.value),
        )
        yield repair, axis, law, scaled(times)


def _asked_for(
    axis: GeneratedAxis, law: ControlLaw, record: Record, moved: Record
) -> tuple[float, Array]:
    """Return the multiple of a small change of the record that fits the control best.

    Parameters
    ----------
    axis : GeneratedAxis
    law : ControlLaw
    record, moved : Record
        The record without and with the small change.

    Returns
    -------
    float
        The multiple; NaN for a change without effect.
    (n,) array
        Effect of the small change on the law's control, in the samples that count.
    """
    control, made, used, _ = compared_with_law(axis, law, record)
    slope = (compared_with_law(axis, law, moved)[1] - made)[used]
    power = float(slope @ slope)
    return float(slope @ (control - made)[used]) / power if power > 0 else math.nan, slope


def position_zero(
    axis: GeneratedAxis, law: ControlLaw, record: Record
) -> tuple[float, float | None] | None:
    """Return the offset of the recorded position from the one that the law read, and its effect.

    The offset, SI, is the one that explains most of the residual of the law. Its effect is the
    constant control with the same effect, or None for a law that integrates, which has no such
    constant. None in place of both where an offset has no effect on the control.

    Parameters
    ----------
    axis : GeneratedAxis
    law : ControlLaw
        Law of the axis.
    record : Record
        Record without gaps, with a reference and a control.
    """
    step = _STEP * float(np.ptp(np.asarray(record.reference))) or _STEP
    steps, slope = _asked_for(axis, law, record, replace(record, position=record.position + step))
    if not np.isfinite(steps):
        return None
    mean = float(np.mean(slope))
    is_constant = float(np.ptp(slope)) <= MAX_SCALE_ERROR.value * abs(mean)
    return -step * steps, mean * steps if is_constant else None


def explained_by_gains(
    by_gains: GainRegression,
) -> tuple[OtherGains | OtherScale | None, GainRegression | None]:
    """Return the finding of other gains or another scale, and the regression with these gains.

    Other gains are preferred; the finding then contains the scale too, because another gain may
    have the same effect as another scale of the recorded control. The finding is None where neither
    explains the control. The regression is None where no gains explain the control.
    """
    percent, declared = by_gains.percent, by_gains.along.law.gains
    changes = by_gains.least_change() if declared else ()
    right = (e for e in changes if e.percent < MAX_LAW_RESIDUAL.value and not e.gains_off)
    best, is_large = next(right, None), percent >= MAX_LAW_RESIDUAL.value
    scale = None if by_gains.scale is None else _control_scale(by_gains.scale[0])
    if best is not None:
        return OtherGains(
            residual_percent=percent,
            is_large=is_large,
            alternatives=tuple(_other_gains(change) for change in changes),
            has_right_gains=len(declared) > len(best.free),
            scale=scale,
            injected_differs=INJECTED in best.off,
        ), best
    if by_gains.scale is None or scale is None:
        return None, None
    return OtherScale(
        residual_percent=percent,
        is_large=is_large,
        scale=scale,
        scaled_percent=by_gains.scale[1].percent,
    ), None


def _control_scale(times: float) -> ControlScale:
    """Return the finding of a scale of the control, with the two units that it may have confused.

    The units are None for a factor that no known pair of units has.
    """
    for factor, units in _UNITS.items():
        if is_near(times, factor):
            return ControlScale(times=float(times), units=units)
    return ControlScale(times=float(times), units=None)


def _other_gains(change: GainRegression) -> tuple[OtherGain, ...]:
    """Return the gains of a regression that have other values than declared."""
    declared, gains = change.along.law.gains, change.gains
    return tuple(
        OtherGain(name=name, value=gains[name], declared=float(declared[name]), times=float(times))
        for name, times in change.times.items()
    )
