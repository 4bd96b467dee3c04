"""Faults of a recorded control that does not follow the declared law, and their remedies.

If the position is recorded relative to another zero than the reference, the law sees a constant
tracking error. Its control then has a constant for a law without an integral, and a ramp for a law
that integrates. The constant looks the same as a constant error of the recorded control, so both
are reported.
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

# residual with a change, relative to that without, below which the change is reported
_MAX_REPAIRED_RESIDUAL = 0.5
# by factor of a control: the recorded unit, and the unit that it was taken for
_UNITS = {
    1e3: ("m", "mm"),
    1e-3: ("mm", "m"),
    math.pi / 180: ("deg", "rad"),
    180 / math.pi: ("rad", "deg"),
}
_UNKNOWN = "NAME"  # for a column without a name in a log
_STEP = 1e-3  # small change for a derivative: of a factor, or of a zero relative to the range
_CLOCK_STEP = 0.01  # small change of the clock rate, in samples at the end of the record
_CLOCK_STEPS = 15  # largest number of Gauss-Newton steps
# largest relative difference between two clocks; if it is larger, the times are in another unit
_MOST_CLOCK = 0.02


def constant_or_drift(percent: float, lean: Mapping[str, float], unit: str) -> ConstantOrDrift:
    """Return the finding of a control with a constant or a drift in addition to the law.

    If the law does not integrate, a position relative to another zero has the same effect as a
    constant.

    Parameters
    ----------
    percent : float
        Residual of the law, percent of the control.
    lean : mapping of str to float
        Significant constant and drift by name, in `unit`.
    unit : str
        Unit of the control.
    """
    return ConstantOrDrift(
        residual_percent=percent, constant=lean.get(CONSTANT), drift=lean.get(DRIFT), unit=unit
    )


def is_near(factor: float, scale: float) -> bool:
    """Return True if a factor equals a usual factor, `scale`, within 5 %.

    With other errors in the law, the control does not determine the factor more accurately.
    """
    return abs(factor / scale - 1) < MAX_FACTOR_ERROR


def late_control(percent: float, shift: int, delay: int | None) -> LateControl:
    """Return the finding of a control that comes some samples later or earlier than by the law.

    The comparison alone does not show whether the law or the log is wrong.

    Parameters
    ----------
    percent : float
        Residual without the shift, percent of the control.
    shift : int
        Samples by which the control comes later; negative for an earlier control.
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

    None where no change of the columns, of the law or of the drive's limit makes the law fit. Kinds
    of changes are tried in order, and the best change of the first kind that fits is returned. With
    a change, the residual must be below its threshold and less than half of that without.

    Parameters
    ----------
    axis : GeneratedAxis
        Axis with the declared law.
    law : ControlLaw
        Law of the axis.
    record : Record
        Record without gaps, with a reference and a control.
    declared : float
        Residual without a change, percent of the control: that of the declared law, or with gains
        that explain the control.
    shift : int
        Samples by which the control comes later than by the law. If it is not 0, only columns at
        other times are tried, and nothing if the shift alone makes the law fit.
    """
    most = min(MAX_LAW_RESIDUAL.value, _MAX_REPAIRED_RESIDUAL * declared)
    # Kinds of changes: functions that yield changes.
    kinds = [_changed_columns, _scaled_columns, _mistimed_columns]
    kinds += [_moved_zero, _other_laws, _limited]
    if shift:
        if law_error_percent(axis, law, record.shifted(control=-shift)) < most:
            return None
        kinds = [_mistimed_columns]
    for kind in kinds:
        tried = list[tuple[float, LawRepair]]()
        for repair, changed_axis, changed_law, changed_record in kind(axis, law, record):
            percent = law_error_percent(changed_axis, changed_law, changed_record)
            tried.append((percent, repair))
        least, best = min(tried, key=itemgetter(0), default=(np.inf, None))
        if best is not None and least < most:
            return least, best
    return None


def _other_laws(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Change]:
    """Yield changes to a law that computes the velocity in another way, with the same gains."""
    for name, variant in velocity_variants(law).items():
        yield (
            OtherVelocity(law=name),
            build(replace(axis.axis, control=variant), native=False),
            variant,
            record,
        )


def _moved_zero(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Change]:
    """Yield a change of the position's zero: the one that explains most of the residual.

    Nothing is yielded where another zero has no effect on the control.
    """
    zero = position_zero(axis, law, record)
    if zero is None:
        return
    offset, control = zero
    repair = MovedZero(
        position=offset,
        unit=axis.coordinate.unit,
        column=record.provenance.columns.get("position", _UNKNOWN),
        control=control,
        control_unit=axis.drive.unit,
        exceeds_limit=abs(control or 0.0) > axis.drive.limit,
    )
    yield repair, axis, law, replace(record, position=record.position - offset)


def _limited(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Change]:
    """Yield a change to a limit of the drive that is below the declared limit.

    The limit is the size of the recorded control where the output of the law is larger than any
    recorded control. Nothing is yielded where the control reaches the declared limit, and for too
    few such samples.
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
        # The noise of a converter makes the largest control too large, but not the median.
        limit = float(np.median(cut))
        limited = with_limit(axis, limit, native=False)
    except ModelError:  # no dead band and no step is as large as the limit
        return
    samples = int((made * np.sign(control) > limit).sum())
    yield UndeclaredLimit(limit=limit, unit=drive.unit, samples=samples), limited, law, record


def _mistimed_columns(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Change]:
    """Yield changes to a column at another time, and to a reference with another clock."""
    yield from _moved_columns(axis, law, record)
    rate = reference_clock(axis, law, record)
    if rate is None:
        return
    yield ReferenceClock(rate=rate), axis, law, _with_clock(record, rate)


def _with_clock(record: Record, rate: float) -> Record:
    """Return the record with the reference at ``(1 + rate)`` times the time since the start.

    The reference is interpolated. Samples beyond the end of the recorded reference are masked.
    """
    times = np.arange(float(len(record)))
    later = np.minimum((1 + rate) * times, times[-1])
    reference = at_times(later, times, np.asarray(record.reference), "spline")
    known = int(np.count_nonzero((1 + rate) * times <= times[-1]))
    masked = record.masked if known == len(record) else (*record.masked, (known, len(record)))
    return replace(record, reference=reference, masked=masked)


def reference_clock(axis: GeneratedAxis, law: ControlLaw, record: Record) -> float | None:
    """Return the relative amount by which the clock of the reference is faster than the position's.

    With this amount, the law gives the recorded control; it is found by Gauss-Newton steps. None
    where these do not converge, where the clocks hardly differ, and for a constant reference.

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
        current, changed = _with_clock(record, rate), _with_clock(record, rate + step)
        steps, _ = _best_multiple(axis, law, current, changed)
        change = step * steps
        if not np.isfinite(change) or abs(rate + change) > _MOST_CLOCK:
            return None
        rate += change
        if abs(change) < step:
            return rate if abs(rate) * len(record) > _CLOCK_STEP else None
    return None


def _moved_columns(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Change]:
    """Yield shifts of reference, position or a signal by one or two samples."""
    for samples in (1, -1, 2, -2):
        for role in ("reference", "position", *sorted(map(str, law.signals))):
            moved = record.shifted(**{role: samples})
            yield MovedColumn(role=role, samples=samples), axis, law, moved


def _changed_columns(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Change]:
    """Yield corrections of common mistakes in the columns.

    Position and reference may be exchanged. A test signal may enter at another point, have the
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
        moved = replace(record, injected_at="reference")
        yield OtherTestSignal(change="added to the reference"), axis, law, moved
    else:
        moved = replace(record, injected_at="control")
        yield OtherTestSignal(change="added to the control"), axis, law, moved
    opposite = replace(record, injected=-injected)
    yield OtherTestSignal(change="opposite sign"), axis, law, opposite
    if moves:
        yield OtherTestSignal(change="none"), axis, law, replace(record, injected=None)


def _scaled_columns(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Change]:
    """Yield changes of the scale of a column: the factor that fits the control best.

    The control is linearised about a start value of the factor. For position and reference, it is
    the value with which they are about equal, because the law may be at a limit of its own far away
    from it; for a signal, it is 1.
    """
    columns, pair = record.channels(), ("position", "reference")
    covariance = np.cov([columns[role] for role in pair])
    # With a constant reference, a test signal alone moves the axis.
    starts = {}
    if np.ptp(columns["reference"]):
        starts = {r: covariance[0, 1] / covariance[i, i] for i, r in enumerate(pair)}
    for role in (*pair, *sorted(map(str, law.signals))):

        def scaled(times: float, role: str = role) -> Record:
            """Return the record with the column multiplied by a factor."""
            return record.with_channels({**columns, role: times * columns[role]})

        start = float(starts.get(role, 1.0))
        steps, _ = _best_multiple(axis, law, scaled(start), scaled((1 + _STEP) * start))
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


def _best_multiple(
    axis: GeneratedAxis, law: ControlLaw, record: Record, changed: Record
) -> tuple[float, Array]:
    """Return the multiple of a small change of the record that fits the control best.

    Parameters
    ----------
    axis : GeneratedAxis
    law : ControlLaw
    record, changed : Record
        The record without and with the small change.

    Returns
    -------
    float
        The multiple; NaN for a change without effect.
    (n,) array
        Effect of the small change on the law's control, in the samples that count.
    """
    control, made, used, _ = compared_with_law(axis, law, record)
    effect = (compared_with_law(axis, law, changed)[1] - made)[used]
    power = float(effect @ effect)
    multiple = float(effect @ (control - made)[used]) / power if power > 0 else math.nan
    return multiple, effect


def position_zero(
    axis: GeneratedAxis, law: ControlLaw, record: Record
) -> tuple[float, float | None] | None:
    """Return the offset of the recorded position from the one that the law read, and its effect.

    The offset, SI, explains most of the residual of the law. The second number is the constant of
    the control with the same effect; None for a law that integrates, which has no such constant.
    None in place of both where an offset has no effect on the control.

    Parameters
    ----------
    axis : GeneratedAxis
    law : ControlLaw
        Law of the axis.
    record : Record
        Record without gaps, with a reference and a control.
    """
    step = _STEP * float(np.ptp(np.asarray(record.reference))) or _STEP
    moved = replace(record, position=record.position + step)
    steps, effect = _best_multiple(axis, law, record, moved)
    if not np.isfinite(steps):
        return None
    mean = float(np.mean(effect))
    is_constant = float(np.ptp(effect)) <= MAX_SCALE_ERROR.value * abs(mean)
    return -step * steps, mean * steps if is_constant else None


def explained_by_gains(
    by_gains: GainRegression,
) -> tuple[OtherGains | OtherScale | None, GainRegression | None]:
    """Return the finding of other gains or another scale, and the regression with these gains.

    Other gains are preferred. The finding then contains the scale too, because another gain may
    have the same effect as another scale of the recorded control. The finding is None where neither
    explains the control. The regression is None where no gains explain the control.

    Parameters
    ----------
    by_gains : GainRegression
        Regression of the residual on the gains, with the declared gains.
    """
    percent, declared = by_gains.percent, by_gains.along.law.gains
    is_large = percent >= MAX_LAW_RESIDUAL.value
    # The first of the smallest changes of gains that explains the control.
    changes = by_gains.least_change() if declared else ()
    enough = (e for e in changes if e.percent < MAX_LAW_RESIDUAL.value and not e.gains_off)
    best = next(enough, None)
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
    """Return the fitted gains of a regression, with their declared values."""
    declared, gains = change.along.law.gains, change.gains
    return tuple(
        OtherGain(name=name, value=gains[name], declared=float(declared[name]), times=float(times))
        for name, times in change.times.items()
    )
