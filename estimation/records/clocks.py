"""Times of columns, and checks of their steps.

Columns have the times of one time column, times of their own, or a count of the sampling period.
Checked are gaps, clocks that are set back, jitter, a drifting period, and a given period.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.raw_tables import Repair, Table
from axisid.estimation.records.columns import RoleColumns
from axisid.estimation.thresholds import MAX_EVEN_STEP, MAX_MEAN_STEP_DEVIATION
from axisid.support.arrays import Array
from axisid.support.checks import is_real, refuse
from axisid.support.errors import DataError, UsageError
from axisid.support.settings import setting
from axisid.support.wording import quoted

from .shifts_and_interpolation import SELDOM_ROLES, advised_interpolation


def _resampling() -> str:
    """Return the setting that resamples a log evenly, as the user types it."""
    return setting("resample", "auto")


def _splitting() -> str:
    """Return the setting that cuts a log at its gaps, as the user types it."""
    return setting("gaps", "split")


def long_steps(time: Array, most: float) -> NDArray[np.intp]:
    """Return the indices of time steps that are longer than `most` median steps, (k,).

    Step i is that from time i to time i + 1.
    """
    steps = np.diff(time)
    return np.flatnonzero(steps > most * np.median(steps)) if len(steps) else np.zeros(0, np.intp)


def _is_rare(count: int, steps: int) -> bool:
    """Return True if irregular time steps are so few that they are faults of single samples.

    Many irregular steps are jitter. `count` is the number of irregular steps, `steps` the number of
    all steps.
    """
    return count <= max(0.01 * steps, 1)


def clocked(table: Table, columns: RoleColumns, sample_period: float | None) -> RoleColumns:
    """Return all columns except the time column, each with its times, s.

    The times are those of the time column, or else those that the log has for each column, or else
    a count of the given sampling period, s.

    Raises
    ------
    DataError
        The columns differ in length, or there are neither times nor a sampling period.
    """
    samples = {role: s for role, s in columns.samples.items() if role != "time"}
    if "time" in columns.samples:
        lengths = {role: len(s.values) for role, s in columns.samples.items()}
        if len(set(lengths.values())) > 1:
            raise _unequal(table.source, table, lengths)
        samples = {r: replace(s, clock=columns.samples["time"].values) for r, s in samples.items()}
    elif any(s.clock is None for s in samples.values()):
        if sample_period is None:
            raise DataError(
                f"{table.source}: there is no time column among {table.listed()}. Name the time "
                f"column with {setting('columns', {'time': 'NAME'})}, or set sample_period in "
                "run.toml. "
                f"{table.missing}".rstrip(),
                code="time",
            )
        samples = {
            role: replace(s, clock=sample_period * np.arange(float(len(s.values))))
            for role, s in samples.items()
        }
    return replace(columns, samples=samples)


def share_clock(columns: RoleColumns) -> bool:
    """Return True if all columns have the same times."""
    shared = columns.motion.times
    clocks = [s.times for s in columns.samples.values()]
    return all(clock is shared or np.array_equal(clock, shared, equal_nan=True) for clock in clocks)


def retimed(
    columns: RoleColumns, period: float | None, *, split: bool, uneven: bool
) -> RoleColumns:
    """Return columns with repaired common times.

    Times with too few digits are replaced by a count of the given period. Times after a point at
    which the clock was set back continue. Columns with different times are not changed, as their
    clocks may have been reset at different times.

    Parameters
    ----------
    columns : RoleColumns
    period : float or None
        Sampling period, s, which replaces times with too few digits.
    split : bool
        True if the log may be cut where its clock was set back.
    uneven : bool
        True if the columns are resampled later: short steps are then jitter. Otherwise a rare short
        step is a clock that was set back a little.
    """
    if not share_clock(columns):
        return columns
    clock, repairs = columns.motion.times, list[Repair]()
    if period is not None:
        clock, repairs = _counted(clock, period)
    if split:
        clock, further = _past_restarts(clock, uneven=uneven)
        repairs += further
    return columns.repaired(
        {role: replace(s, clock=clock) for role, s in columns.samples.items()}, *repairs
    )


def _counted(time: Array, period: float) -> tuple[Array, list[Repair]]:
    """Return a count of the period, s, instead of times with too few digits, and the repair.

    The times must repeat often and agree with the count up to their digits; otherwise they are
    returned unchanged, without a repair.
    """
    steps = np.diff(time)
    tick = float(steps.max(initial=0.0))
    counted = time[:1] + period * np.arange(len(time), dtype=np.float64)
    is_count = np.all(steps >= 0) and np.all(np.abs(time - counted) <= tick + period)
    if not is_count or _is_rare(int(np.sum(steps == 0)), len(steps)):
        return time, []
    text = (
        f"time stamps with steps of 0 to {1e3 * tick:.6g} ms are replaced by a count of the given "
        "sampling period"
    )
    return counted, [Repair(kind="clock", count=len(time), text=text)]


def _past_restarts(time: Array, *, uneven: bool) -> tuple[Array, list[Repair]]:
    """Return times, s, that continue where the clock was set back, and the repair if it was.

    A gap of a few periods is made there, so that the log is cut; its duration is unknown. Frequent
    steps back are not changed, and are refused later. Times that are not finite are ignored. If not
    `uneven`, a much shorter step than the median also counts as a clock that was set back.
    """
    timed = np.flatnonzero(np.isfinite(time))
    finite = time[timed]
    steps = np.diff(finite)
    typical = float(np.median(steps)) if len(steps) else 0.0
    back = steps <= 0 if uneven else steps * MAX_EVEN_STEP.value < typical
    places = np.flatnonzero(back)
    if not places.size or not typical > 0 or not _is_rare(len(places), len(steps)):
        return time, []
    shifts = np.zeros(len(time))
    shifts[timed[places + 1]] = 4 * typical - steps[places]  # longer than the shortest gap
    first = places[0]
    times = "once," if len(places) == 1 else f"{len(places)} times, first"
    text = (
        f"the clock is set back {times} before data row {timed[first + 1] + 1}, from "
        f"{finite[first]:.9g} s to {finite[first + 1]:.9g} s: the log is cut there, and the time "
        "continues"
    )
    return time + np.cumsum(shifts), [Repair(kind="clock", count=len(places), text=text)]


def filled(table: Table, columns: RoleColumns, *, uneven: bool) -> RoleColumns:
    """Return columns without the rows that have no finite value or time.

    Such rows are left out only if the columns are resampled later (`uneven`). Otherwise they are
    refused, and so are columns with different times.

    Raises
    ------
    DataError
        A column has no row with a number and a time, or must be resampled.
    """
    if not uneven:
        _check_even(table, columns)
    kept = {
        role: s.taken(np.isfinite(s.values) & np.isfinite(s.times)) if uneven else s
        for role, s in columns.samples.items()
    }
    lost = {role: len(columns.samples[role].values) - len(s.values) for role, s in kept.items()}
    refuse(
        DataError,
        *(
            (
                not len(s.values),
                f"{columns.source}: the {role} has no row with a number and a time. Name another "
                f"column with {setting('columns', {role: 'NAME'})}, or check the times",
            )
            for role, s in kept.items()
        ),
        code="time",
    )
    if not any(lost.values()):
        return columns
    listed = ", ".join(f"{role} {count}" for role, count in lost.items() if count)
    return columns.repaired(
        kept,
        Repair(
            kind="empty",
            count=sum(lost.values()),
            text=f"rows without a number or a time are left out before resampling: {listed}",
        ),
    )


def _check_even(table: Table, columns: RoleColumns) -> None:
    """Refuse columns with cells that have no finite number, and columns with different times.

    A column that is sampled at a lower rate than the others may have empty cells; the message then
    also advises to interpolate.

    Raises
    ------
    DataError
        A cell has no finite number, or the columns have different times.
    """
    for role, samples in columns.samples.items():
        for what, cells in ((f"time of the {role}", samples.times), (role, samples.values)):
            empty = np.flatnonzero(~np.isfinite(cells))
            if empty.size:
                interpolate = ""
                if role in SELDOM_ROLES:
                    interpolate = (
                        f" Or interpolate between the values of the {role} "
                        f"({advised_interpolation(role)})."
                    )
                raise DataError(
                    f"{columns.source}: the {what} is {cells[empty[0]]} in data row "
                    f"{empty[0] + 1} ({empty.size} of {len(cells)} cells have no number). Remove "
                    f"the rows without a number. Or resample the other rows ({_resampling()}), and "
                    f"cut the log where many rows are missing ({_splitting()}).{interpolate} If "
                    "the rows are at the end of a text file, leave them out with "
                    'tail = "drop" in run.toml.',
                    code="empty-cells",
                )
    first, *others = columns.samples
    shared = columns.samples[first].times
    for role in others:
        clock = columns.samples[role].times
        if len(clock) != len(shared):
            raise _unequal(
                columns.source,
                table,
                {first: len(shared), role: len(clock)},
                f"If the columns are sampled at different rates, resample them ({_resampling()}).",
            )
        if clock is not shared and not np.array_equal(clock, shared, equal_nan=True):
            raise DataError(
                f"{columns.source}: the {first} and the {role} are sampled at different times. "
                f"Resample the columns ({_resampling()}).",
                code="time",
            )


def _unequal(
    source: str,
    table: Table,
    lengths: Mapping[str, int],
    advice: str = "Give one value per time in each column.",
) -> DataError:
    """Return the error that columns differ in length, with warnings from reading the file.

    Parameters
    ----------
    source : str
        Name of the log.
    table : Table
    lengths : mapping of str to int
        Number of rows by role.
    advice : str
        Instruction that ends the message, a sentence.
    """
    listed = ", ".join(f"{role} {length}" for role, length in lengths.items())
    why = f" ({'; '.join(table.warnings)})" if table.warnings else ""
    return DataError(
        f"{source}: the columns differ in length: {listed}{why}. {advice}", code="time"
    )


def period_uncertainty(pieces: Sequence[Array]) -> float:
    """Return the relative uncertainty of the mean time step, due to jitter.

    Jitter moves the ends of each segment by the range of the time steps at most: the uncertainty is
    the number of segments times this range, divided by the sum of all steps.

    Parameters
    ----------
    pieces : sequence of (n,) array
        Times of each segment, s.
    """
    steps = np.concatenate([np.diff(piece) for piece in pieces])
    total = float(np.sum(steps)) if len(steps) else 0.0
    return len(pieces) * float(np.ptp(steps)) / total if total > 0 else 0.0


def step_notes(pieces: Sequence[Array]) -> tuple[str, ...]:
    """Return notes on uneven time steps that are treated as even; empty if the steps are even.

    Parameters
    ----------
    pieces : sequence of (n,) array
        Times of each segment, s.
    """
    steps = np.concatenate([np.diff(piece) for piece in pieces])
    if not steps.size or np.ptp(steps) <= 0.02 * abs(steps.mean()):
        return ()
    return (
        f"time steps of {1e3 * steps.min():.6g} to {1e3 * steps.max():.6g} ms are read as even "
        f"steps of {1e3 * steps.mean():.6g} ms",
    )


def check_increases(source: str, what: str, time: Array) -> None:
    """Refuse times that do not increase.

    Parameters
    ----------
    source : str
        Name of the log.
    what : str
        Description of the times, for the message.
    time : (N,) array
        Times, s.

    Raises
    ------
    DataError
        The times do not increase.
    """
    back = np.flatnonzero(~(np.diff(time) > 0))
    if back.size:
        row = back[0] + 1
        raise DataError(
            f"{source}: {what} does not increase in data row {row + 1}: after "
            f"{time[row - 1]:.9g} s comes {time[row]:.9g} s. If the clock was set back or another "
            f"log was appended, cut the log there ({_splitting()}). If rows are out of order or "
            "repeated, sort the rows and remove repetitions. If the time stamps are too coarse, "
            "export the log with more digits, or set sample_period in run.toml.",
            code="time",
        )


def check_time(
    source: str, time: Array, spans: Sequence[tuple[int, int]], period: float | None
) -> None:
    """Refuse times with uneven steps within the segments, or with another period than given.

    Parameters
    ----------
    source : str
        Name of the log.
    time : (N,) array
        Times, s.
    spans : sequence of (int, int)
        First sample and the one after the last of each segment.
    period : float or None
        Given sampling period, s; None if none is given.

    Raises
    ------
    DataError
        The steps are uneven, the period drifts, or it differs from the given period.
    """
    check_increases(source, "time", time)
    steps, tolerance = np.diff(time), MAX_MEAN_STEP_DEVIATION.value
    inside = np.ones(len(steps), dtype=bool)
    inside[[start - 1 for start, _ in spans[1:]]] = False
    typical, mean = float(np.median(steps[inside])), float(np.mean(steps[inside]))
    # Single steps: gaps, jumps of the clock, jitter.
    odd = (steps > MAX_EVEN_STEP.value * typical) | (steps * MAX_EVEN_STEP.value < typical)
    gaps = np.flatnonzero(odd & inside)
    if gaps.size:
        even_remedy = "" if _is_rare(gaps.size, len(steps)) else f" {_arrival_remedy(mean)}"
        raise DataError(
            f"{source}: the time step before data row {gaps[0] + 2} is {steps[gaps[0]]:.6g} s, but "
            f"{typical:.6g} s elsewhere ({gaps.size} of {len(steps)} steps differ). If samples are "
            f"missing or the clock jumps, cut the log there ({_splitting()}). If the times jitter, "
            f"resample the log evenly ({_resampling()}).{even_remedy}",
            code="uneven-time",
        )
    if period is not None and abs(mean / typical - 1) < tolerance:
        check_stated(source, typical, period)
    # Drift: means over 100 steps, in which jitter of a quarter of a period is half a percent.
    means = [np.diff(time[start:stop:100]) / 100 for start, stop in spans]
    slow, *_, fast = np.sort(np.concatenate([*means, [typical, mean]]))
    if not (slow > mean * (1 - tolerance) and fast < mean * (1 + tolerance)):
        raise DataError(
            f"{source}: the sampling period drifts from {1e3 * slow:.6g} to {1e3 * fast:.6g} ms "
            "(the extremes of the median, the mean, and the means over 100 samples). Resample the "
            f"log evenly ({_resampling()}). {_arrival_remedy(mean)}",
            code="uneven-time",
        )


def _arrival_remedy(step: float) -> str:
    """Return the remedy for even samples whose times are arrival times of the rows.

    `step` is the mean time step, s.
    """
    return (
        "If the drive sampled evenly and the times are only arrival times of the rows, delete the "
        f"time column and set sample_period in run.toml (the mean step is {step:.6g} s)."
    )


def check_stated(source: str, measured: float, stated: float, uncertainty: float = 0.0) -> None:
    """Refuse a given sampling period that differs from the period of the times.

    Parameters
    ----------
    source : str
        Name of the log.
    measured : float
        Period of the times, s.
    stated : float
        Given sampling period, s.
    uncertainty : float
        Relative uncertainty of the period of the times.

    Raises
    ------
    DataError
        The periods differ by more than 0.5 % and the uncertainty.
    """
    if not abs(stated / measured - 1) < 0.005 + uncertainty:
        raise DataError(
            f"{source}: sample_period is {stated:g} s, but the time column steps by {measured:g} "
            "s. Correct sample_period or the time column (times are in seconds).",
            code="time",
        )


def check_sample_period(period: object) -> None:
    """Refuse a sampling period that is not a positive number."""
    if not (is_real(period) and 0 < period < math.inf):
        raise UsageError(
            f"the sampling period is {quoted(period)}. Give a positive number of seconds.",
            code="time",
        )
