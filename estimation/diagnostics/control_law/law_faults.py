"""Which fault it looks like where a recorded control is not the declared law's; what mends it.

A position that is recorded from another zero than the reference is a tracking error to the law that
does not change: a control of so many volts where the law is of gains alone, a ramp where it
integrates. The first is what a constant error of the recorded control is too, so that both are
told.
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

# of the declared law's residual, below which a change of columns is told
_MAX_REPAIRED_RESIDUAL = 0.5
# factor of a control -> unit that stands for another one, and that other one
_UNITS = {
    1e3: ("m", "mm"),
    1e-3: ("mm", "m"),
    math.pi / 180: ("deg", "rad"),
    180 / math.pi: ("rad", "deg"),
}
_UNKNOWN = "NAME"  # of a column of arrays
_STEP = 1e-3  # of the reference's range
_CLOCK_STEP = 0.01  # samples at the end of a record, by another clock
_CLOCK_STEPS = 15  # of Gauss and Newton
_MOST_CLOCK = 0.02  # beyond, a clock is of another unit


def constant_or_drift(percent: float, lean: Mapping[str, float], unit: str) -> ConstantOrDrift:
    """Return the finding of a control with a constant or a drift, by its name, in the drive's unit.

    A position from another zero makes as much of a constant, where the law does not integrate.
    """
    return ConstantOrDrift(
        residual_percent=percent, constant=lean.get(CONSTANT), drift=lean.get(DRIFT), unit=unit
    )


def is_near(factor: float, scale: float) -> bool:
    """Return whether a factor is a usual one, as closely as a law with other errors shows it."""
    return abs(factor / scale - 1) < MAX_FACTOR_ERROR


def late_control(percent: float, shift: int, delay: int | None) -> LateControl:
    """Return the finding of a control that is some samples off the law's, whichever is wrong.

    The law alone does not tell whether law or log is wrong.

    Parameters
    ----------
    percent : float
        Residual without the shift, percent of the control.
    shift : int
        Samples by which the control comes later.
    delay : int or None
        Of the law; None for a continuous one.
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


#: What may mend a law: its finding, and axis, law and record of it.
_Change = tuple[LawRepair, GeneratedAxis, ControlLaw, Record]


def repair_of(
    axis: GeneratedAxis, law: ControlLaw, record: Record, declared: float, shift: int
) -> tuple[float, LawRepair] | None:
    """Return what makes the law fit: columns changed, or its velocity formed otherwise; or None.

    With the residual of the law then, in percent of the control.

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
        tried = list[tuple[float, LawRepair]]()
        for repair, of, by, other in kind(axis, law, record):
            tried.append((law_error_percent(of, by, other), repair))
        least, best = min(tried, key=itemgetter(0), default=(np.inf, None))
        if best is not None and least < good:
            return least, best
    return None


def _other_laws(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Change]:
    for name, variant in velocity_variants(law).items():
        yield (
            OtherVelocity(law=name),
            build(replace(axis.axis, control=variant), native=False),
            variant,
            record,
        )


def _moved_zero(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Change]:
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
    samples = int((made * np.sign(control) > limit).sum())
    yield UndeclaredLimit(limit=limit, unit=drive.unit, samples=samples), limited, law, record


def _mistimed_columns(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Change]:
    """The record with a column some samples earlier or later, or the reference on another clock."""
    yield from _moved_columns(axis, law, record)
    rate = reference_clock(axis, law, record)
    if rate is None:
        return
    yield ReferenceClock(rate=rate), axis, law, _with_clock(record, rate)


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


def _moved_columns(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Change]:
    for samples in (1, -1, 2, -2):
        for role in ("reference", "position", *sorted(map(str, law.signals))):
            moved = record.shifted(**{role: samples})
            yield MovedColumn(role=role, samples=samples), axis, law, moved


def _changed_columns(axis: GeneratedAxis, law: ControlLaw, record: Record) -> Iterator[_Change]:
    """The record as it would be without a common mistake in its columns."""
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
        (unit,) = expected_units(role, axis.axis)
        # What the column was scaled by already is not in the record.
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


def explained_by_gains(
    by_gains: GainRegression,
) -> tuple[OtherGains | OtherScale | None, GainRegression | None]:
    """Return the least change of gains or the scale that explains the control, and the law with it.

    A control that is recorded with another scale is what such a gain may make of it too. The
    finding is None where nothing explains the control, the law where no gains do.
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
    """Return the scale of a control, with the units that such a factor is of."""
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
