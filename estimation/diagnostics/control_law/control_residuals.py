"""The recorded control beside what the law makes: which samples count, a shift, other readings.

The rows of a record whose times are uneven may be what the law read, whose stamps alone jitter; or
the samples may be off even times, between which the law read. Which it is, the law itself tells:
the one that it fits. A record that was resampled has the rows of neither, since its control, which
a drive holds, and its noise are drawn between the samples.
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

# of a factor of a law that does not fit from a round one; beyond, it is off
MAX_FACTOR_ERROR = 0.05
# residual with a shift, by that without, up to which it is told
_MAX_EXPLAINED_RESIDUAL = 0.7
#: Names of what is regressed beside the products of gains.
CONSTANT = "constant"
DRIFT = "drift"
INJECTED = "injected"
#: The product that what no gain multiplies has for its factor.
NO_GAINS = "1"
#: Samples over which a shift of the control is looked for.
MOST_SHIFT = 5
# periods from even times, from which a law may have read something else; rounding is below
_MIN_UNEVEN = 1e-6
# what a law leaves, by what noise between samples with jitter makes, up to which it cannot be
# judged; 1.0 where that noise is all
_MAX_OPEN_RATIO = 2.0


def compared_with_law(
    axis: GeneratedAxis, law: ControlLaw, record: Record
) -> tuple[Array, Array, NDArray[np.bool_], NDArray[np.bool_]]:
    """The control, what the law and a test signal make of it, and which samples count, (N,) each.

    Of a law that reads an ideal velocity both are smooth. With the samples whose control is not the
    law's, at a limit or masked, before that is spread over their neighbours.
    """
    control, settle = np.asarray(record.control), settling(law)
    # A control beyond the limit by more is in a wrong unit, not one of a saturated drive.
    limited = np.isclose(np.abs(control), limit_in_log(axis), rtol=LIMIT_TOLERANCE.value, atol=0.0)
    for start, stop in record.masked:
        # A position that was cut off stays in the memory.
        limited[start : stop + LAW_SETTLING] = True
    limited[:settle] = True
    ticks, memory = noisy_ticks(axis, record)
    made = law_along(axis, ticks, memory) + as_logged(axis, ticks.added_at_samples(law.delay))
    limited |= at_limit(control, made, axis.drive.limit)
    if not law.takes_velocity:
        return control, made, ~limited, limited
    if np.all(np.isfinite(made)):
        smooth = comparison_filter(law, record)
        # What the limit cut off would be spread far over the neighbours.
        control, made = smooth(np.where(limited, made, control)), smooth(made)
    spread = limited.copy()
    spread[-settle:] = True
    from scipy.ndimage import maximum_filter1d

    # The low-pass spreads a limited sample over its neighbours.
    return control, made, ~maximum_filter1d(spread, settle), limited


@cached_while_alive
def noisy_ticks(axis: GeneratedAxis, record: Record) -> tuple[LawInputs, Array]:
    """What a law measured along a record, with all its noise, and what it remembers first, (m,).

    That is of the low-passed velocity, of which the first controls show it better.
    """
    whole = (0, len(record))
    ticks = law_ticks(axis, record, whole, noisy=True)
    quiet = law_ticks(axis, record, whole) if law_of(axis).takes_velocity else ticks
    return ticks, start_of_law(axis, record, whole, quiet)


def comparison_filter(law: ControlLaw, record: Record) -> Callable[[Array], Array]:
    """What both sides are filtered by: a low-pass, where the law reads an ideal velocity."""
    if not law.takes_velocity:
        return lambda signal: signal
    smooth = SampledFilter(Prefilter(cutoff=COMPARISON_CUTOFF.value / record.period), record.period)
    return lambda signal: smooth.motion(signal)[0]


def settling(law: ControlLaw) -> int:
    """Samples at the start that are not compared."""
    return round(1 / COMPARISON_CUTOFF.value) if law.takes_velocity else LAW_SETTLING


def law_error_percent(axis: GeneratedAxis, law: ControlLaw, record: Record) -> float:
    """What a law leaves of the recorded control, percent."""
    control, made, used, _ = compared_with_law(axis, law, record)
    return relative_error_percent((control - made)[used], control[used])


def at_limit(control: Array, made: Array, limit: float) -> NDArray[np.bool_]:
    """Where the law asks for more than the limit, and gets it but for a converter's noise, (N,)."""
    there = np.abs(control) >= (1 - MAX_LIMIT_EXCESS.value) * limit
    return np.asarray(there & (made * np.sign(control) > limit))


def coloured_fit(
    target: Array, columns: Array, names: Sequence[str], neighbours: RowTimes, period: float
) -> tuple[Solution, Array]:
    """Least squares of residuals that are an autoregression, and its covariance.

    Of few independent samples it is wider, so that what is `MIN_DISTANCE_FROM_NOISE` deviations off
    is as unlikely as that many of a normal one.

    Raises
    ------
    EstimationError
        The columns cannot be told apart.
    """
    fit = least_squares(target, factor(columns, names, neighbours=neighbours))
    # Colour goes on through samples that are left out.
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
    """Constant and drift of what is left, and their deviations, (2,) each."""
    time = neighbours.places - neighbours.places.mean()
    columns = np.column_stack([np.ones(len(left)), time / np.ptp(time)])
    fit, covariance = coloured_fit(left, columns, (CONSTANT, DRIFT), neighbours, period)
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


def other_readings(record: Record) -> Iterator[tuple[Reading, Record]]:
    """Return the other samples that a law may have read of a record whose times are uneven."""
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
    """How much of the control jitter leaves open, percent, where that may be all that is off.

    None where the law's control would move too little for it: by the jitter, or by noise that the
    law measured at other times than the log.

    Parameters
    ----------
    axis : GeneratedAxis
    law : ControlLaw
    record : Record
    off : float
        Percent of the control that the law leaves, of the reading that fits best.
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
    """The even times that fit those of a record without gaps best, (N,), s."""
    count, first = np.arange(len(record), dtype=float), record.time[0]
    line = np.polyfit(count, record.time - first, 1)
    return np.asarray(np.polyval(line, count) + first, dtype=float)


def _evenly(record: Record, *roles: str) -> Record:
    """A record without gaps with columns at the even times that fit its own best, by splines."""
    times, columns = _even_times(record), record.channels()
    even = {role: at_times(times, record.time, columns[role], "spline") for role in roles}
    return record.with_channels({**columns, **even})
