"""The times of columns: one time column, each column's own, or an even count; and their steps.

Gaps, clocks that go back, a period that drifts, one that was stated.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.tables import Samples, Table
from axisid.estimation.thresholds import MAX_EVEN_STEP, MAX_MEAN_STEP_DEVIATION
from axisid.support.arrays import Array
from axisid.support.errors import DataError, UsageError, is_real, quoted

from .shifts import SELDOM_ROLES, advised_interpolation

_MAX_STEP_SPREAD = 0.02  # periods between the time steps, up to which nothing is said of jitter
_MAX_ODD_STEP_SHARE = 0.01  # of the time steps are odd: faults of single samples; more are jitter
# periods in place of a clock that was set back: more than any gap needs, to cut there
_RESTARTED_CLOCK_STEP = 4.0

#: Steps over which jitter averages out: even a quarter of a period to half a percent.
_WINDOW = 100
_EVENLY = 'resample="auto"'
_SPLIT = 'gaps="split"'
#: What to do about uneven steps, and about steps back.
_ON_UNEVEN = (
    f"Cut the log where samples are missing or the clock jumps ({_SPLIT}); resample it evenly "
    f"where its times jitter ({_EVENLY})."
)
_ON_BACKWARD = (
    f"Cut the log where its clock was set back or another log was joined on ({_SPLIT}); sort rows "
    "that are out of order, and remove repeated ones; export stamps that are too coarse with more "
    "digits, or give sample_period in run.toml to count by."
)

#: What else may be done about empty cells, by role.
_MORE_ON_EMPTY = {
    role: f", or draw it between its values ({advised_interpolation(role)})"
    for role in SELDOM_ROLES
}

_MAX_STATED_PERIOD_DEVIATION = 0.005  # relative difference of a given period from the time column's


def long_steps(time: Array, most: float) -> NDArray[np.intp]:
    """Steps of a time, (N,), that are longer than so many median ones."""
    steps = np.diff(time)
    return np.flatnonzero(steps > most * np.median(steps)) if len(steps) else np.zeros(0, np.intp)


def _odd_steps(steps: Array, typical: float) -> NDArray[np.bool_]:
    return (steps > MAX_EVEN_STEP.value * typical) | (steps * MAX_EVEN_STEP.value < typical)


def _is_rare(count: int, steps: int) -> bool:
    """Whether so many steps of all may be faults of single samples, and no jitter."""
    return count <= max(_MAX_ODD_STEP_SHARE * steps, 1)


def _is_coarse(time: Array) -> bool:
    """Whether times stand still too often to be a fault of single rows: too few digits."""
    steps = np.diff(time)
    return bool(np.all(steps >= 0)) and not _is_rare(int(np.sum(steps == 0)), len(steps))


def count_by_period(time: Array, period: float) -> tuple[Array, str]:
    """Coarse times replaced by a count of the period, s, and what is said of it.

    They must be those times but for their digits; what is not coarse stays as it is.
    """
    if not (np.all(np.isfinite(time)) and _is_coarse(time)):
        return time, ""
    counted = time[0] + period * np.arange(len(time), dtype=np.float64)
    tick = float(np.diff(time).max())
    if np.any(np.abs(time - counted) > tick + period):
        return time, ""
    return counted, (
        f"time stamps that step by 0 to {1e3 * tick:.6g} ms replaced by a count of the sampling "
        "period that was given"
    )


def count_past_restarts(time: Array, *, uneven: bool) -> tuple[Array, int, str]:
    """Times that go on where the clock was set back, how often that was, and what is said of it.

    There a gap is made of a few periods, so that the log is cut; how much time passed is not known.
    Steps back that are no faults of single places are left, for whoever needs time to increase.

    Parameters
    ----------
    time : (N,) array
        s; what is not finite is passed over.
    uneven : bool
        Whether short steps may be jitter; else a rare one is a clock that was set back a little.
    """
    timed = np.flatnonzero(np.isfinite(time))
    finite = time[timed]
    steps = np.diff(finite)
    typical = float(np.median(steps)) if len(steps) else 0.0
    back = steps <= 0 if uneven else steps * MAX_EVEN_STEP.value < typical
    places = np.flatnonzero(back)
    if not places.size or not typical > 0 or not _is_rare(len(places), len(steps)):
        return time, 0, ""
    shifts = np.zeros(len(time))
    shifts[timed[places + 1]] = _RESTARTED_CLOCK_STEP * typical - steps[places]
    k = places[0]
    text = (
        f"the clock is set back, {len(places)} in all, first before data row {timed[k + 1] + 1}, "
        f"from {finite[k]:.9g} s to {finite[k + 1]:.9g} s: cut there, and counted on"
    )
    return time + np.cumsum(shifts), len(places), text


def open_end(pieces: Sequence[Array]) -> float:
    """What jitter leaves open of the mean step of segments, the times of each (n,), relative."""
    steps = np.concatenate([np.diff(piece) for piece in pieces])
    total = float(np.sum(steps)) if len(steps) else 0.0
    return len(pieces) * float(np.ptp(steps)) / total if total > 0 else 0.0


def step_notes(pieces: Sequence[Array]) -> tuple[str, ...]:
    """What is said of time steps that are taken as even but are not quite; empty if they are.

    Jitter moves the ends of a window by a part of the spread of the steps.

    Parameters
    ----------
    pieces : sequence of (n,) array
        Times of each segment, s.
    """
    steps = np.concatenate([np.diff(piece) for piece in pieces])
    if not steps.size:
        return ()
    least, most, mean = float(steps.min()), float(steps.max()), float(steps.mean())
    if most - least <= _MAX_STEP_SPREAD * abs(mean):
        return ()
    span = f"{1e3 * least:.6g} to {1e3 * most:.6g} ms"
    return (f"time steps of {span} taken as even, {1e3 * mean:.6g} ms each",)


def _window_steps(pieces: Sequence[Array]) -> tuple[float, float]:
    """Least and largest mean step of windows of 100 samples, s, of the times of each segment."""
    means = np.concatenate([np.diff(piece[::_WINDOW]) / _WINDOW for piece in pieces])
    return float(means.min(initial=np.inf)), float(means.max(initial=0.0))


def check_increases(source: str, what: str, time: Array) -> None:
    """Refuse times that do not increase."""
    back = np.flatnonzero(~(np.diff(time) > 0))
    if back.size:
        row = back[0] + 1
        raise DataError(
            f"{source}: {what} does not increase in data row {row + 1}: after "
            f"{time[row - 1]:.9g} s comes {time[row]:.9g} s. {_ON_BACKWARD}",
            code="time",
        )


def check_time(
    source: str, time: Array, spans: Sequence[tuple[int, int]], period: float | None
) -> None:
    """Refuse a time that does not increase evenly within the segments, or by another period, s."""
    check_increases(source, "time", time)
    steps = np.diff(time)
    inside = np.ones(len(steps), dtype=bool)
    inside[[start - 1 for start, _ in spans[1:]]] = False
    typical, mean = float(np.median(steps[inside])), float(np.mean(steps[inside]))
    gaps = np.flatnonzero(_odd_steps(steps, typical) & inside)
    if gaps.size:
        raise DataError(
            f"{source}: the time step before data row {gaps[0] + 2} is {steps[gaps[0]]:.6g} "
            f"s, {typical:.6g} s elsewhere ({gaps.size} of {len(steps)} steps differ). "
            f"{_ON_UNEVEN}",
            code="uneven-time",
        )
    if not abs(mean / typical - 1) < MAX_MEAN_STEP_DEVIATION.value:
        raise DataError(
            f"{source}: the time steps are uneven: {typical:.6g} s in the middle, {mean:.6g} "
            f"s in the mean. Resample the log evenly ({_EVENLY}).",
            code="uneven-time",
        )
    if period is not None:
        check_stated(source, typical, period)
    slow, fast = _window_steps([time[start:stop] for start, stop in spans])
    apart = MAX_MEAN_STEP_DEVIATION.value
    if fast > mean * (1 + apart) or slow < mean * (1 - apart):
        raise DataError(
            f"{source}: the sampling period drifts from {1e3 * slow:.6g} to {1e3 * fast:.6g} ms "
            f"(means over {_WINDOW} samples), which cannot be taken as even. Resample the log "
            f"evenly ({_EVENLY}).",
            code="uneven-time",
        )


def check_stated(source: str, found: float, stated: float, uncertainty: float = 0.0) -> None:
    """Refuse a sampling period that was given, s, and is not the one of the time column."""
    if not abs(stated / found - 1) < _MAX_STATED_PERIOD_DEVIATION + uncertainty:
        raise DataError(
            f"{source}: the sampling period is given as {stated:g} s, but the time "
            f"column steps by {found:g} s. Correct one of them (time is in seconds).",
            code="time",
        )


def check_sample_period(period: object) -> None:
    """Refuse what is no sampling period."""
    if not (is_real(period) and 0 < period < math.inf):
        raise UsageError(
            f"the sampling period is {quoted(period)}; give a positive number of seconds.",
            code="time",
        )


def clocked(
    table: Table, samples: Mapping[str, Samples], sample_period: float | None
) -> dict[str, Samples]:
    """Every column but time with its times: the time column's, its own, or a count."""
    columns = {role: s for role, s in samples.items() if role != "time"}
    if "time" in samples:
        time = samples["time"].values
        lengths = {role: len(s.values) for role, s in samples.items()}
        if len(set(lengths.values())) > 1:
            raise _unequal(table, lengths)
        return {role: replace(s, clock=time) for role, s in columns.items()}
    if all(s.clock is not None for s in columns.values()):
        return columns
    if sample_period is None:
        raise DataError(
            f"{table.source}: there is no time column among {table.listed()}; name it with "
            "columns time=NAME, or give sample_period in run.toml. "
            f"{table.missing}".rstrip(),
            code="time",
        )
    return {
        role: replace(s, clock=sample_period * np.arange(len(s.values), dtype=np.float64))
        for role, s in columns.items()
    }


def filled(table: Table, columns: Mapping[str, Samples], *, uneven: bool) -> dict[str, Samples]:
    """Columns without the samples that lack a value, where these may be left out."""
    if uneven:
        columns = {
            role: s.taken(np.isfinite(s.values) & np.isfinite(s.times))
            for role, s in columns.items()
        }
    else:
        _check_filled(table, columns)
        _check_one_clock(table, columns)
    for role, s in columns.items():
        if not len(s.values):
            raise DataError(
                f"{table.source}: the {role} has no row with a number and a time.",
                code="time",
            )
    return dict(columns)


def _check_filled(table: Table, columns: Mapping[str, Samples]) -> None:
    """Refuse cells without a finite number, a log's way to write a lower rate."""
    for role, samples in columns.items():
        for what, cells in (("time of the {}", samples.times), ("{}", samples.values)):
            empty = np.flatnonzero(~np.isfinite(cells))
            if empty.size:
                raise DataError(
                    f"{table.source}: the {what.format(role)} is {cells[empty[0]]} in data row "
                    f"{empty[0] + 1} ({empty.size} of {len(cells)} cells hold no number). Remove "
                    f"such rows, or resample what is there ({_EVENLY}), and cut where many follow "
                    f"one another ({_SPLIT}){_MORE_ON_EMPTY.get(role, '')}; at the end of a text "
                    'they may be left out (tail = "drop" in run.toml).',
                    code="empty-cells",
                )


def _check_one_clock(table: Table, columns: Mapping[str, Samples]) -> None:
    first, shared = next((role, s.times) for role, s in columns.items())
    for role, samples in columns.items():
        clock = samples.times
        if len(clock) != len(shared):
            raise _unequal(
                table,
                {first: len(shared), role: len(clock)},
                f"Where they are sampled at different rates, resample them ({_EVENLY}).",
            )
        if clock is not shared and not np.array_equal(clock, shared, equal_nan=True):
            raise DataError(
                f"{table.source}: {first} and {role} are sampled at different times; resample "
                f"them ({_EVENLY}).",
                code="time",
            )


def _unequal(table: Table, lengths: Mapping[str, int], advice: str = "") -> DataError:
    """The error of columns that differ in length, with what is wrong with the file."""
    listed = ", ".join(f"{role} {length}" for role, length in lengths.items())
    why = f" ({'; '.join(table.warnings)})" if table.warnings else ""
    found = f"{table.source}: the columns differ in length: {listed}{why}. {advice}"
    return DataError(found.rstrip(), code="time")
