"""Residual of a recorded control relative to its law: samples that count, shifts, other readings.

A record with uneven times has two possible readings. The law read the recorded rows, and only their
time stamps jitter; or the rows were sampled at uneven times, and the law read other values at even
times between them. The reading that fits the law is taken. A resampled record has neither of the
two, because resampling interpolates the noise and the control, which the drive holds constant.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, stdtrit

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.law_replay import (
    LAW_SETTLING,
    LawInputs,
    law_along,
    law_ticks,
    position_noise,
    start_of_law,
)
from axisid.estimation.records import Record, at_times
from axisid.estimation.regression import (
    Solution,
    autoregression_of,
    autoregressive_covariance,
    factor,
    least_squares,
)
from axisid.estimation.signals import Prefilter, RowTimes, SampledFilter, as_logged, limit_in_log
from axisid.estimation.simulation import law_of
from axisid.estimation.thresholds import (
    COMPARISON_CUTOFF,
    LIMIT_TOLERANCE,
    MAX_LAW_RESIDUAL,
    MAX_LIMIT_EXCESS,
    MIN_DISTANCE_FROM_NOISE,
)
from axisid.modeling.declaration import ControlLaw
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.caching import cached_while_alive

from .law_findings import Reading

# relative distance of a factor from a usual one, for a law that does not fit; beyond, they differ
MAX_FACTOR_ERROR = 0.05
# residual with a shift, relative to that without, up to which the shift is reported
_MAX_EXPLAINED_RESIDUAL = 0.7
#: Names of the regressors next to the products of gains.
CONSTANT = "constant"
DRIFT = "drift"
INJECTED = "injected"
#: The product of gains that stands for the part of the law that no gain multiplies.
NO_GAINS = "1"
#: Samples within which a shift of the control is searched.
MOST_SHIFT = 5
# distance from even times in periods, from which a law may have read other values; rounding is less
_MIN_UNEVEN = 1e-6
# residual of a law, relative to the effect of noise between samples with jitter, up to which the
# law cannot be judged; it is 1.0 where that noise is the only difference
_MAX_OPEN_RATIO = 2.0


def compared_with_law(
    axis: GeneratedAxis, law: ControlLaw, record: Record
) -> tuple[Array, Array, NDArray[np.bool_], NDArray[np.bool_]]:
    """Return the recorded control, the computed control, and two masks of samples, (N,) each.

    The computed control is the sum of the output of the law and a test signal. The first mask has
    the samples that count. The second has the samples whose control is not that of the law, at a
    limit or masked, before the low-pass spreads them over their neighbours. Both controls are
    low-passed for a law that reads an ideal velocity.
    """
    control, settle = np.asarray(record.control), settling(law)
    # A control further beyond the limit is in a wrong unit, and not that of a saturated drive.
    limited = np.isclose(np.abs(control), limit_in_log(axis), rtol=LIMIT_TOLERANCE.value, atol=0.0)
    for start, stop in record.masked:
        # A masked position stays in the internal state of the law for some samples.
        limited[start : stop + LAW_SETTLING] = True
    limited[:settle] = True
    ticks, memory = noisy_ticks(axis, record)
    made = law_along(axis, ticks, memory) + as_logged(axis, ticks.added_at_samples(law.delay))
    limited |= at_limit(control, made, axis.drive.limit)
    if not law.takes_velocity:
        return control, made, ~limited, limited
    if np.all(np.isfinite(made)):
        smooth = comparison_filter(law, record)
        # The filter would spread the saturated part far over the neighbours.
        control, made = smooth(np.where(limited, made, control)), smooth(made)
    spread = limited.copy()
    spread[-settle:] = True
    from scipy.ndimage import maximum_filter1d

    # The low-pass spreads a limited sample over its neighbours.
    return control, made, ~maximum_filter1d(spread, settle), limited


@cached_while_alive
def noisy_ticks(axis: GeneratedAxis, record: Record) -> tuple[LawInputs, Array]:
    """Return the noisy inputs of a law along a record, and its initial internal state, (m,).

    The initial state is estimated with the low-passed velocity, which the first controls show
    better.
    """
    whole = (0, len(record))
    ticks = law_ticks(axis, record, whole, noisy=True)
    quiet = law_ticks(axis, record, whole) if law_of(axis).takes_velocity else ticks
    return ticks, start_of_law(axis, record, whole, quiet)


def comparison_filter(law: ControlLaw, record: Record) -> Callable[[Array], Array]:
    """Return the filter of both controls: a low-pass for a law that reads an ideal velocity."""
    if not law.takes_velocity:
        return lambda signal: signal
    smooth = SampledFilter(Prefilter(cutoff=COMPARISON_CUTOFF.value / record.period), record.period)
    return lambda signal: smooth.motion(signal)[0]


def settling(law: ControlLaw) -> int:
    """Return the number of samples at the start that are not compared."""
    return round(1 / COMPARISON_CUTOFF.value) if law.takes_velocity else LAW_SETTLING


def law_error_percent(axis: GeneratedAxis, law: ControlLaw, record: Record) -> float:
    """Return the residual of a law in percent of the recorded control."""
    control, made, used, _ = compared_with_law(axis, law, record)
    return relative_error_percent((control - made)[used], control[used])


def at_limit(control: Array, made: Array, limit: float) -> NDArray[np.bool_]:
    """Return a mask of the samples at the limit, within a converter's noise, by the law, (N,)."""
    there = np.abs(control) >= (1 - MAX_LIMIT_EXCESS.value) * limit
    return np.asarray(there & (made * np.sign(control) > limit))


def coloured_fit(
    target: Array, columns: Array, names: Sequence[str], neighbours: RowTimes, period: float
) -> tuple[Solution, Array]:
    """Return a least-squares fit and its covariance for autoregressive residuals.

    The covariance is enlarged for few independent samples, so that a distance of
    `MIN_DISTANCE_FROM_NOISE` standard errors has the p-value that it has for a normal distribution.

    Raises
    ------
    EstimationError
        The columns are linearly dependent.
    """
    fit = least_squares(target, factor(columns, names, neighbours=neighbours))
    # The autocorrelation continues through samples that are left out.
    at = neighbours.places - neighbours.places[0]
    every, taken = np.zeros((int(at[-1]) + 1, 2 + len(names))), float(len(names))
    every[at] = np.column_stack([np.ones(len(at)), fit.residuals, fit.influence])
    model = autoregression_of([every[:, 1]], period, [every[:, 0] > 0])
    spans = [slice(0, len(every))]
    applied = autoregressive_covariance(every[:, 2:], model, spans, len(target), taken)
    far = MIN_DISTANCE_FROM_NOISE.value
    wider = stdtrit(applied.freedom, ndtr(far)) / far
    return fit, applied.matrix * np.outer(wider, wider)


def offset_and_drift(left: Array, neighbours: RowTimes, period: float) -> tuple[Array, Array]:
    """Return the constant and the drift of a residual, and their standard errors, (2,) each."""
    time = neighbours.places - neighbours.places.mean()
    columns = np.column_stack([np.ones(len(left)), time / np.ptp(time)])
    fit, covariance = coloured_fit(left, columns, (CONSTANT, DRIFT), neighbours, period)
    return fit.theta, np.sqrt(np.diag(covariance))


def best_shift(predicted: Array, control: Array, used: NDArray[np.bool_]) -> int:
    """Return the shift in samples that explains the control clearly better than none, else 0."""
    rows = np.flatnonzero(used)
    rows = rows[(rows >= MOST_SHIFT) & (rows < len(control) - MOST_SHIFT)]
    errors = {
        shift: float(np.linalg.norm(control[rows] - predicted[rows - shift]))
        for shift in range(-MOST_SHIFT, MOST_SHIFT + 1)
    }
    best = min(errors, key=lambda shift: errors[shift])
    return best if errors[best] < _MAX_EXPLAINED_RESIDUAL * errors[0] else 0


def other_readings(record: Record) -> Iterator[tuple[Reading, Record]]:
    """Yield the other samples that a law may have read, for a record with uneven times."""
    raw = (record.sampled or record).longest()
    if record.sampled is not None:
        yield "sampled rows", raw
    elif np.max(np.abs(raw.time - _even_times(raw))) <= _MIN_UNEVEN * record.period:
        return
    roles = [each for each in ("position", "reference", "injected") if each in raw.channels()]
    for count in range(1, len(roles) + 1):
        yield "even times", _evenly(raw, *roles[:count])


def open_for_jitter(
    axis: GeneratedAxis, law: ControlLaw, record: Record, off: float
) -> float | None:
    """Return the uncertainty of the control by jitter, percent, where it may explain the residual.

    None where it cannot: the control of the law changes too little by the jitter, or by noise that
    the law measured at other times than the log.

    Parameters
    ----------
    axis : GeneratedAxis
    law : ControlLaw
    record : Record
    off : float
        Residual of the law with the reading that fits best, percent of the control.
    """
    raw = (record.sampled or record).longest()
    even, control = _evenly(raw, "position"), np.asarray(raw.control)
    noise = position_noise(even.position) * np.random.default_rng(0).normal(size=len(even))
    sampled, between, noisy_control = (
        compared_with_law(axis, law, each)[1]
        for each in (raw, even, replace(even, position=even.position + noise))
    )
    left = relative_error_percent(noisy_control - between, control)
    matters = relative_error_percent(sampled - between, control) >= MAX_LAW_RESIDUAL.value
    return left if matters and off < _MAX_OPEN_RATIO * left else None


def _even_times(record: Record) -> Array:
    """Return the even times nearest to the times of a record without gaps, (N,), s."""
    count, first = np.arange(len(record), dtype=float), record.time[0]
    line = np.polyfit(count, record.time - first, 1)
    return np.asarray(np.polyval(line, count) + first, dtype=float)


def _evenly(record: Record, *roles: str) -> Record:
    """Return a record without gaps with columns interpolated at even times, by splines."""
    times, columns = _even_times(record), record.channels()
    even = {role: at_times(times, record.time, columns[role], "spline") for role in roles}
    return record.with_channels({**columns, **even})
