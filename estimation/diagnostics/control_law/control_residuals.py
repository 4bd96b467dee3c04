"""Residual of a recorded control relative to its law: samples that count, shifts, other readings.

A reading is a version of the record's samples that the law may have read.

A record with uneven times has two possible readings. Either the law read the recorded rows, and
only their time stamps jitter; or the rows were sampled at uneven times, and the law read other
values at even times between them. The reading that fits the law is taken. A resampled record
contains neither of the two, because resampling interpolates the noise, and also the control, which
the drive holds constant.
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

# relative distance of a factor from a usual one, up to which both are equal if the law does not fit
MAX_FACTOR_ERROR = 0.05
# residual with a shift, relative to that without, up to which the shift is reported
_MAX_EXPLAINED_RESIDUAL = 0.7
#: Names of the regressors next to the products of gains.
CONSTANT = "constant"
DRIFT = "drift"
INJECTED = "injected"
#: Name of the part of the law that no gain multiplies, as a product of no gains.
NO_GAINS = "1"
#: Samples within which a shift of the control is searched.
MOST_SHIFT = 5
# distance from even times, in periods, from which a law may have read other values; it is larger
# than rounding
_MIN_UNEVEN = 1e-6
# residual of a law, relative to the effect of noise between samples with jitter, up to which the
# law cannot be judged; the ratio is 1.0 where that noise is the only difference
_MAX_OPEN_RATIO = 2.0


def compared_with_law(
    axis: GeneratedAxis, law: ControlLaw, record: Record
) -> tuple[Array, Array, NDArray[np.bool_], NDArray[np.bool_]]:
    """Return the recorded control, the control of the law, and two masks of samples, (N,) each.

    The control of the law is its output along the record, plus a test signal where there is one.
    For a law that reads an ideal velocity, both controls are low-passed.

    Parameters
    ----------
    axis : GeneratedAxis
        Axis with this law.
    law : ControlLaw
    record : Record
        Record without gaps, with a reference and a control.

    Returns
    -------
    control, made : (N,) array
        Recorded control, and control of the law.
    used : (N,) array of bool
        True for the samples that count in a comparison.
    limited : (N,) array of bool
        True for the samples whose recorded control is not that of the law: at the start, at a
        limit, or masked. A low-pass spreads them over neighbours, which do not count either.
    """
    control, settle = np.asarray(record.control), settling(law)
    # Samples at the limit by the recorded control, masked samples, and the start.
    # A control further beyond the limit is in a wrong unit, and not that of a saturated drive.
    limited = np.isclose(np.abs(control), limit_in_log(axis), rtol=LIMIT_TOLERANCE.value, atol=0.0)
    for start, stop in record.masked:
        # A masked position stays in the internal state of the law for some samples.
        limited[start : stop + LAW_SETTLING] = True
    limited[:settle] = True
    # The control of the law, and samples at the limit by this control.
    ticks, memory = noisy_ticks(axis, record)
    made = law_along(axis, ticks, memory) + as_logged(axis, ticks.added_at_samples(law.delay))
    limited |= at_limit(control, made, axis.drive.limit)
    if not law.takes_velocity:
        return control, made, ~limited, limited
    # The same low-pass for both controls.
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
    """Return the inputs of the axis's law along a record, and the law's initial state, (m,).

    The state is the memory of law and delay at the first sample. An ideal velocity is not logged.
    If the law reads one, the velocity in the inputs is the derivative of the recorded positions
    with their noise, because the comparison low-passes the controls itself. The initial state is
    estimated with the derivative of the low-passed positions instead, with which the first controls
    determine it better.
    """
    whole = (0, len(record))
    ticks = law_ticks(axis, record, whole, noisy=True)
    quiet = law_ticks(axis, record, whole) if law_of(axis).takes_velocity else ticks
    return ticks, start_of_law(axis, record, whole, quiet)


def comparison_filter(law: ControlLaw, record: Record) -> Callable[[Array], Array]:
    """Return the filter of the recorded control and of the control of the law, (N,) to (N,).

    The filter is a low-pass for a law that reads an ideal velocity. Otherwise it changes nothing.
    """
    if not law.takes_velocity:
        return lambda signal: signal
    smooth = SampledFilter(Prefilter(cutoff=COMPARISON_CUTOFF.value / record.period), record.period)
    return lambda signal: smooth.motion(signal)[0]


def settling(law: ControlLaw) -> int:
    """Return the number of samples at the start of a record that are not compared with a law."""
    return round(1 / COMPARISON_CUTOFF.value) if law.takes_velocity else LAW_SETTLING


def law_error_percent(axis: GeneratedAxis, law: ControlLaw, record: Record) -> float:
    """Return the residual of a law in the samples that count, percent of the control (rms)."""
    control, made, used, _ = compared_with_law(axis, law, record)
    return relative_error_percent((control - made)[used], control[used])


def at_limit(control: Array, made: Array, limit: float) -> NDArray[np.bool_]:
    """Return a mask of the samples at the drive's limit, (N,).

    At the limit, the recorded control, `control`, is near the limit within the noise of a
    converter, and the control of the law, `made`, is beyond the limit in the same direction.
    """
    is_near = np.abs(control) >= (1 - MAX_LIMIT_EXCESS.value) * limit
    return np.asarray(is_near & (made * np.sign(control) > limit))


def coloured_fit(
    target: Array, columns: Array, names: Sequence[str], neighbours: RowTimes, period: float
) -> tuple[Solution, Array]:
    """Return a least-squares fit and its covariance, (k, k), for autoregressive residuals.

    Parameters
    ----------
    target : (n,) array
        Values to explain.
    columns : (n, k) array
        Regressor.
    names : sequence of str
        Names of the columns.
    neighbours : RowTimes
        Times of the rows in samples.
    period : float
        Sample period, s.

    Raises
    ------
    EstimationError
        The columns are linearly dependent.
    """
    fit = least_squares(target, factor(columns, names, neighbours=neighbours))
    return fit, coloured_covariance(fit, period)


def coloured_covariance(fit: Solution, period: float) -> Array:
    """Return the covariance of a least-squares fit for autoregressive residuals, (k, k).

    It is enlarged for few independent samples, so that a distance of `MIN_DISTANCE_FROM_NOISE`
    standard errors has the p-value that it has for a normal distribution.

    Parameters
    ----------
    fit : Solution
        Fit of n rows.
    period : float
        Sample period, s.
    """
    rows, parameters = fit.influence.shape
    # Residuals and influence in all samples, with zeros in those that are not rows: the
    # autocorrelation continues through these samples.
    places = fit.neighbours.places
    at = places - places[0]
    every = np.zeros((int(at[-1]) + 1, 2 + parameters))
    every[at] = np.column_stack([np.ones(rows), fit.residuals, fit.influence])
    model = autoregression_of([every[:, 1]], period, [every[:, 0] > 0])
    spans = [slice(0, len(every))]
    applied = autoregressive_covariance(every[:, 2:], model, spans, rows, float(parameters))
    # Factor by which Student's distribution is wider than the normal one at this distance.
    far = MIN_DISTANCE_FROM_NOISE.value
    wider = stdtrit(applied.freedom, ndtr(far)) / far
    return applied.matrix * np.outer(wider, wider)


def offset_and_drift(residuals: Array, neighbours: RowTimes) -> Solution:
    """Return the least-squares fit of a constant and a drift to residuals, (n,).

    The drift is the change over the record.

    Parameters
    ----------
    residuals : (n,) array
    neighbours : RowTimes
        Times of the rows in samples.
    """
    time = neighbours.places - neighbours.places.mean()
    columns = np.column_stack([np.ones(len(residuals)), time / np.ptp(time)])
    return least_squares(residuals, factor(columns, (CONSTANT, DRIFT), neighbours=neighbours))


def best_shift(predicted: Array, control: Array, used: NDArray[np.bool_]) -> int:
    """Return the samples by which the recorded control comes later than that of the law.

    The result is 0 unless a shift explains the control clearly better than no shift.

    Parameters
    ----------
    predicted, control : (N,) array
        Control of the law, and recorded control.
    used : (N,) array of bool
        True for the samples that count.
    """
    rows = np.flatnonzero(used)
    rows = rows[(rows >= MOST_SHIFT) & (rows < len(control) - MOST_SHIFT)]
    errors = {
        shift: float(np.linalg.norm(control[rows] - predicted[rows - shift]))
        for shift in range(-MOST_SHIFT, MOST_SHIFT + 1)
    }
    best = min(errors, key=lambda shift: errors[shift])
    return best if errors[best] < _MAX_EXPLAINED_RESIDUAL * errors[0] else 0


def other_readings(record: Record) -> Iterator[tuple[Reading, Record]]:
    """Yield other readings of a record: their name, and a record of the samples that the law read.

    First come the rows before resampling, if the record was resampled. Then come records with
    columns that are interpolated at even times: the position; position and reference; and both with
    the test signal. Nothing is yielded for a record with even times that was not resampled.
    """
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

    Jitter is the irregularity of the sample times. The law may have read positions at even times,
    with other noise than the log. The uncertainty is the change of the law's control by such noise,
    in percent of the recorded control (rms). None where this uncertainty cannot explain the
    residual: the control of the law hardly depends on the jitter, or the residual is clearly larger
    than the effect of the noise.

    Parameters
    ----------
    axis : GeneratedAxis
    law : ControlLaw
    record : Record
    off : float
        Residual of the law with the reading that fits best, percent of the control.
    """
    # Control of the law along the rows, along even times, and with other noise at even times.
    raw = (record.sampled or record).longest()
    even, control = _evenly(raw, "position"), np.asarray(raw.control)
    noise = position_noise(even.position) * np.random.default_rng(0).normal(size=len(even))
    sampled, between, noisy_control = (
        compared_with_law(axis, law, each)[1]
        for each in (raw, even, replace(even, position=even.position + noise))
    )
    uncertainty = relative_error_percent(noisy_control - between, control)
    by_jitter = relative_error_percent(sampled - between, control)
    if by_jitter >= MAX_LAW_RESIDUAL.value and off < _MAX_OPEN_RATIO * uncertainty:
        return uncertainty
    return None


def _even_times(record: Record) -> Array:
    """Return the evenly spaced times nearest to those of a record without gaps, (N,), s."""
    count, first = np.arange(len(record), dtype=float), record.time[0]
    line = np.polyfit(count, record.time - first, 1)
    return np.asarray(np.polyval(line, count) + first, dtype=float)


def _evenly(record: Record, *roles: str) -> Record:
    """Return a record without gaps with the columns `roles` interpolated at evenly spaced times."""
    times, columns = _even_times(record), record.channels()
    even = {role: at_times(times, record.time, columns[role], "spline") for role in roles}
    return record.with_channels({**columns, **even})
