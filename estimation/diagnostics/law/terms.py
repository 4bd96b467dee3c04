"""The recorded control beside the terms of its law: factors, a constant, a shift, readings.

The rows of a record whose times are uneven may be what the law read, whose stamps alone jitter; or
the samples may be off even times, between which the law read. Which it is, the law itself tells:
the one that it fits. A record that was resampled has the rows of neither, since its control, which
a drive holds, and its noise are drawn between the samples.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.loops import (
    LawTicks,
    as_logged,
    control_along,
    law_ticks,
    limit_in_log,
    position_noise,
    start_of_law,
    terms_along,
    two_clocks,
)
from axisid.estimation.records import Interpolation, Record, at_times
from axisid.estimation.regression import Hac, Solution, factor, least_squares
from axisid.estimation.signals import Prefilter, RowTimes, SampledFilter
from axisid.estimation.thresholds import (
    COMPARISON_CUTOFF,
    LIMIT_TOLERANCE,
    MAX_LAW_RESIDUAL,
    MAX_LIMIT_EXCESS,
    MIN_DISTANCE_FROM_NOISE,
)
from axisid.modeling.declaration import ControlLaw
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.errors import EstimationError

_COINCIDES = 1e-6  # of a sample
LAW_SETTLING = 10  # samples in which the law's memory fills
# constant, or half of a drift, beside the law, by the control's root mean square
_MAX_CONTROL_LEAN = 0.01
# residual with a shift, by that without, up to which it is told
_MAX_EXPLAINED_RESIDUAL = 0.7
#: Names of what is regressed beside the products of gains.
CONSTANT = "constant"
DRIFT = "drift"
INJECTED = "injected"
#: Samples over which a shift of the control is looked for.
MOST_SHIFT = 5
LAGS = 50  # samples over which what the law leaves may be alike
# periods from even times, from which a law may have read something else; rounding is below
_MIN_UNEVEN = 1e-6
# what a law leaves, by what noise between samples with jitter makes, up to which it cannot be
# judged; 1.0 where that noise is all
_MAX_OPEN_RATIO = 2.0
_STAMPS = ": where its stamps jitter and not the sampling, leave resample out"


def compared_with_law(
    axis: GeneratedAxis, law: ControlLaw, record: Record
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """The control, (N,), the law's terms, (N, terms), and which samples to compare, (N,)."""
    control, settle = np.asarray(record.control), settling(law)
    # A control beyond the limit by more is in a wrong unit, not one of a saturated drive.
    limited = np.isclose(np.abs(control), limit_in_log(axis), rtol=LIMIT_TOLERANCE.value, atol=0.0)
    for start, stop in record.masked:
        # A position that was cut off stays in the memory.
        limited[start : stop + LAW_SETTLING] = True
    limited[:settle] = True
    ticks, memory = noisy_ticks(axis, law, record)
    terms = terms_along(axis, ticks, memory)
    if record.added_control is not None:  # as late as the law
        added = as_logged(axis, ticks.added_at_samples(law.delay)[:, None])
        terms = np.hstack([terms, added])
    limited |= at_limit(control, terms, axis.axis.drive.limit)
    if not law.takes_velocity:
        return control, terms, ~limited
    smooth = compared_as(law, record)
    if np.all(np.isfinite(terms)):
        # What the limit cut off would be spread far over the neighbours.
        control = np.where(limited, terms.sum(axis=1), control)
        control, *columns = map(smooth, (control, *terms.T))
        terms = np.column_stack(columns)
    limited[-settle:] = True
    # The low-pass spreads a limited sample over its neighbours.
    return control, terms, ~maximum_filter1d(limited, settle)


def noisy_ticks(axis: GeneratedAxis, law: ControlLaw, record: Record) -> tuple[LawTicks, Array]:
    """What a law measured along a record, with all its noise, and what it remembers first, (m,).

    That is of the low-passed velocity, of which the first controls show it better.
    """
    whole = (0, len(record))
    ticks = law_ticks(axis, record, whole, noisy=True)
    quiet = law_ticks(axis, record, whole) if law.takes_velocity else ticks
    return ticks, start_of_law(axis, record, whole, quiet)


def compared_as(law: ControlLaw, record: Record) -> Callable[[Array], Array]:
    """What both sides are filtered by: a low-pass, where the law reads an ideal velocity."""
    if not law.takes_velocity:
        return lambda signal: signal
    low_pass = Prefilter(cutoff=COMPARISON_CUTOFF.value / record.period)
    smooth = SampledFilter(low_pass, record.period)
    return lambda signal: smooth.motion(signal)[0]


def settling(law: ControlLaw) -> int:
    """Samples at the start that are not compared."""
    return round(1 / COMPARISON_CUTOFF.value) if law.takes_velocity else LAW_SETTLING


def law_error_percent(axis: GeneratedAxis, law: ControlLaw, record: Record) -> float:
    """What a law leaves of the recorded control, percent."""
    return residual_percent(*compared_with_law(axis, law, record))


def residual_percent(control: Array, terms: Array, used: NDArray[np.bool_]) -> float:
    """What a law leaves of a control, percent, as `compared_with_law` gives the two."""
    return relative_error_percent((control - terms.sum(axis=1))[used], control[used])


def at_limit(control: Array, terms: Array, limit: float) -> NDArray[np.bool_]:
    """Where the law asks for more than the limit, and gets it but for a converter's noise, (N,)."""
    wanted = terms.sum(axis=1)
    there = np.abs(control) >= (1 - MAX_LIMIT_EXCESS.value) * limit
    return np.asarray(there & (wanted * np.sign(control) > limit))


def left_open_percent(axis: GeneratedAxis, record: Record, used: NDArray[np.bool_]) -> float:
    """How far the control of a right law may be from the recorded one, percent of that.

    Between the samples of a log the position is taken by a cubic spline. What that misses is the
    noise that the law measured, and a motion faster than the log: how much the control may differ
    by them is measured, with noise of the same size added to the positions, and with every second
    sample left out of the spline.

    Parameters
    ----------
    axis : GeneratedAxis
        With a control law.
    record : Record
        Of one piece, with a reference and a control.
    used : (N,) array of bool
        Samples that are compared.

    Returns
    -------
    float
        0 where law and log have one clock, or the law reads samples of the log alone.
    """
    whole = (0, len(record))
    clocks = two_clocks(axis, record, whole)
    if clocks is None:
        return 0.0
    ticks = law_ticks(axis, record, whole)
    start = start_of_law(axis, record, whole, ticks)
    if np.allclose(clocks.times, np.round(clocks.times), rtol=0, atol=_COINCIDES):
        return 0.0  # every position that the law read is in the log
    noise = position_noise(record.position) * np.random.default_rng(0).normal(size=len(ticks))
    undisturbed = control_along(axis, ticks, start)
    every_second = record.position[::2]
    drawn = at_times(clocks.times / 2, np.arange(float(len(every_second))), every_second, "spline")
    off = [
        control_along(axis, replace(ticks, position=position), start) - undisturbed
        for position in (ticks.position + noise, drawn)
    ]
    control = np.asarray(record.control)
    by_noise, by_spline = (relative_error_percent(each[used], control[used]) for each in off)
    return float(np.hypot(by_noise, by_spline))


def hac_fit(
    target: Array, columns: Array, names: Sequence[str], neighbours: RowTimes
) -> tuple[Solution, Array]:
    """Least squares of residuals that may be alike over `LAGS` samples, and its covariance.

    Raises
    ------
    EstimationError
        The columns cannot be told apart.
    """
    fit = least_squares(target, factor(columns, names, neighbours=neighbours))
    return fit, Hac(min(LAGS, len(target) // 4)).matrix(fit)


def fitted_factors(
    control: Array, terms: Array, names: list[str], neighbours: RowTimes
) -> tuple[dict[str, float], dict[str, float], float | None]:
    """A control fitted by the terms of its law, each with a factor.

    Factors and their HAC deviations by name, none where the terms cannot be told apart, and what
    the factors leave of the control, percent. A term that is always zero has no factor.
    """
    moving = np.any(terms != 0, axis=0)
    kept = [name for name, moves in zip(names, moving, strict=True) if moves]
    if not kept:
        return {}, {}, None
    try:
        fit, covariance = hac_fit(control, terms[:, moving], kept, neighbours)
    except EstimationError:
        return {}, {}, None
    deviations = np.sqrt(np.diag(covariance))
    factors, unsure = (
        dict(zip(kept, map(float, of_each), strict=True)) for of_each in (fit.theta, deviations)
    )
    return factors, unsure, relative_error_percent(fit.residuals, control)


def lean_of(
    left: Array,
    control: Array,
    neighbours: RowTimes,
    left_open: Array | tuple[float, float] = (0.0, 0.0),
) -> dict[str, float]:
    """A constant and a drift over the record that stand out of what the law leaves, by name.

    Parameters
    ----------
    left, control : (n,) array
    neighbours : RowTimes
    left_open : (2,) array_like
        How large either may be for what the log does not write.
    """
    values, deviations = leaning(left, neighbours)
    least = _MAX_CONTROL_LEAN * float(np.sqrt(np.mean(control**2))) * np.array([1.0, 2.0])
    far = np.maximum(least, MIN_DISTANCE_FROM_NOISE.value * deviations)
    return {
        name: float(value)
        for name, value, limit in zip(
            (CONSTANT, DRIFT), values, np.maximum(far, left_open), strict=True
        )
        if abs(value) > limit
    }


def leaning(left: Array, neighbours: RowTimes) -> tuple[Array, Array]:
    """Constant and drift of what is left, and their deviations, (2,) each."""
    half = neighbours.places - neighbours.places.mean()
    terms = np.column_stack([np.ones(len(left)), half / np.ptp(half)])
    fit, covariance = hac_fit(left, terms, (CONSTANT, DRIFT), neighbours)
    return fit.theta, np.sqrt(np.diag(covariance))


def best_shift(predicted: Array, control: Array, used: NDArray[np.bool_]) -> int:
    """Shift that explains the control clearly better than none, else 0."""
    rows = np.flatnonzero(used)
    rows = rows[(rows >= MOST_SHIFT) & (rows < len(control) - MOST_SHIFT)]
    errors = {
        shift: float(np.linalg.norm(control[rows] - predicted[rows - shift]))
        for shift in range(-MOST_SHIFT, MOST_SHIFT + 1)
    }
    best = min(errors, key=lambda shift: errors[shift])
    return best if errors[best] < _MAX_EXPLAINED_RESIDUAL * errors[0] else 0


def is_uneven(record: Record) -> bool:
    """Whether the samples of a record, or of the one that it was resampled from, are off at all."""
    whole = record.longest()
    return record.sampled is not None or bool(
        np.max(np.abs(whole.time - _even_times(whole))) > _MIN_UNEVEN * record.period
    )


def other_readings(record: Record) -> Iterator[tuple[str, Record, str]]:
    """What else a law may have read than the samples of a record as they are.

    In words, the record, and what is to be done if it fits.
    """
    raw = (record if record.sampled is None else record.sampled).longest()
    if record.sampled is not None:
        yield "in the rows as they were sampled", raw, _STAMPS
    for roles in (["position"], ["position", "reference", "injected"]):
        yield "at even times by the stamps", _evenly(raw, roles), ""


def open_for_jitter(axis: GeneratedAxis, record: Record, off: float) -> float | None:
    """How much of the control jitter leaves open, percent, where that may be all that is off.

    None where the law's control would move too little for it: by the jitter, or by noise that the
    law measured at other times than the log.

    Parameters
    ----------
    axis : GeneratedAxis
    record : Record
    off : float
        Percent of the control that the law leaves, of the reading that fits best.
    """
    raw = (record if record.sampled is None else record.sampled).longest()
    even = _evenly(raw, ["position"])
    as_read, between = (_control(axis, each, each.position) for each in (raw, even))
    if relative_error_percent(as_read - between, np.asarray(raw.control)) < MAX_LAW_RESIDUAL.value:
        return None
    noise = position_noise(even.position) * np.random.default_rng(0).normal(size=len(even))
    moved = _control(axis, even, even.position + noise) - between
    left = relative_error_percent(moved, np.asarray(raw.control))
    return left if off < _MAX_OPEN_RATIO * left else None


def _control(axis: GeneratedAxis, record: Record, position: Array) -> Array:
    """What the law makes of a record with other positions."""
    whole = (0, len(record))
    ticks = law_ticks(axis, replace(record, position=position), whole)
    return control_along(axis, ticks, start_of_law(axis, record, whole, ticks))


def _even_times(record: Record) -> Array:
    """The even times that fit those of a record without gaps best, (N,), s."""
    count, first = np.arange(len(record), dtype=float), record.time[0]
    line = np.polyfit(count, record.time - first, 1)
    return np.asarray(np.polyval(line, count) + first, dtype=float)


def _evenly(record: Record, roles: Sequence[str]) -> Record:
    """A record without gaps with columns at the even times that fit its own best.

    As `--resample` does, position and reference go by cubic splines, and so does what was added to
    the reference; a signal that was added to the control by straight lines.
    """
    times, columns = _even_times(record), {**record.channels()}
    for role in columns.keys() & {*roles}:
        straight = role == "injected" and record.injected_at != "reference"
        how: Interpolation = "linear" if straight else "spline"
        columns[role] = at_times(times, record.time, columns[role], how)
    return record.with_channels(columns)
