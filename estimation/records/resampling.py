"""Resampling of columns to one even grid: splines for the motion, straight lines for the force."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Literal

import numpy as np

from axisid.estimation.raw_tables import PeriodSource, Repair, Samples
from axisid.estimation.records.columns import RoleColumns, motion_role
from axisid.estimation.thresholds import MAX_UNEVEN_STEP
from axisid.support.arrays import Array
from axisid.support.checks import refuse
from axisid.support.errors import DataError, UsageError
from axisid.support.settings import setting

from .clocks import check_increases, check_stated, long_steps
from .segments import adjoining, gaps_repair
from .shifts_and_interpolation import Interpolation, at_times

_FEWEST = 4  # smallest number of samples for a spline


def resample(
    columns: RoleColumns,
    rate: float | Literal["auto"],
    *,
    split: bool,
    stated: float | None = None,
    between: Mapping[str, Interpolation] | None = None,
    edges: Sequence[float] | Array = (),
) -> RoleColumns:
    """Return all columns interpolated to the samples of one even grid of times.

    The grid covers the times at which every column has samples. Gaps and the times between windows
    divide it into segments.

    Parameters
    ----------
    columns : RoleColumns
        Columns by role, each with its own times.
    rate : float or "auto"
        Rate of the grid, Hz; ``auto`` for that of the position.
    split : bool
        True if the log may be cut at gaps.
    stated : float, optional
        Sampling period of the position that the user gave, s, instead of its mean step.
    between : mapping of str to {"spline", "linear", "held"}
        Interpolation of columns by role. By default splines for position, velocity, reference and a
        test signal that was added to the reference, and straight lines for other columns.
    edges : sequence of float
        Times between windows, s, at which the log is always cut.

    Raises
    ------
    UsageError
        The rate is lower than that of the position, or gives too many rows.
    DataError
        A column has too few rows, the time does not increase, has gaps and `split` is False, or has
        another period than stated; or the columns do not overlap.
    """
    source, samples = columns.source, columns.samples
    for role, s in samples.items():
        if len(s.values) < _FEWEST:
            raise DataError(
                f"{source}: the {role} has {len(s.values)} rows with a number and a time, too few "
                f"to resample the log. Give a longer log or window, with {_FEWEST} rows or more.",
                code="too-short",
            )
        check_increases(source, f"the time of the {role}", s.times)
    clocks = {role: s.times for role, s in samples.items()}
    # The rate of the grid, from the period of the position, or of the velocity without a position.
    moving = motion_role(samples)
    period, uncertainty = own_period(clocks[moving])
    if stated is not None:
        check_stated(source, period, stated, uncertainty)
        period, uncertainty = stated, 0.0
    chosen = 1 / period if rate == "auto" else rate
    recorded, rows = 1 / period, chosen * max(float(c[-1] - c[0]) for c in clocks.values())
    refuse(
        UsageError,
        (
            chosen < 0.9 * recorded,
            f"the {moving} is sampled at {recorded:.6g} Hz. Resampling at {chosen:g} Hz would "
            f"alias the noise. Resample at {recorded:.6g} Hz or more. To keep fewer rows, increase "
            "the decimation",
        ),
        (
            rows > 1e8,
            f"the log would have {rows:.2g} rows at {chosen:g} Hz, but 1e8 rows are the maximum. "
            f"Give a lower rate (the {moving} is sampled at {recorded:.6g} Hz)",
        ),
        before=f"{source}: ",
        code="resampling",
    )
    # One grid for each piece of time that all columns cover.
    covered = _common_intervals([_pieces(clock, edges) for clock in clocks.values()])
    step = 1 / chosen
    counts = [np.floor((b - a) / step * (1 + 1e-12) + 1e-6) + 1 for a, b in covered]
    grids = [a + step * np.arange(n) for (a, _), n in zip(covered, counts, strict=True)]
    kept = [(piece, g) for piece, g in zip(covered, grids, strict=True) if len(g) >= _FEWEST]
    if not kept:
        raise DataError(
            f"{source}: the times of the columns do not overlap. Check the clocks of the columns.",
            code="resampling",
        )
    gaps = [
        (before, after)
        for (_, before), (after, _) in pairwise(covered)
        if not any(before <= edge <= after for edge in edges)
    ]
    if gaps and not split:
        raise DataError(
            f"{source}: the time has {len(gaps)} {'gap' if len(gaps) == 1 else 'gaps'}, the first "
            f"after {gaps[0][0]:.9g} s. The motion within a gap is unknown. Cut the log there: "
            f"{setting('gaps', 'split')}.",
            code="uneven-time",
        )
    # Interpolation of each column on the grids.
    splined = {"position", "velocity", "reference"}
    splined |= {"injected"} if columns.injected_at == "reference" else set()
    interpolations: dict[str, Interpolation] = {
        role: (between or {}).get(role, "spline" if role in splined else "linear")
        for role in samples
    }
    time = np.concatenate([grid for _, grid in kept])
    values = {
        role: np.concatenate(
            [_on_grid(grid, piece, clocks[role], s, interpolations[role]) for piece, grid in kept]
        )
        for role, s in samples.items()
    }
    # A sample is masked if it lies next to a masked sample.
    masks = {
        r: np.interp(time, clocks[r], np.asarray(m, float)) > 0 for r, m in columns.masks.items()
    }
    # Repairs that report the resampling, and the gaps.
    repairs = [*columns.repairs, _resample_repair(clocks, time, chosen, interpolations)]
    if split:
        lost = sum(after - before - period for before, after in gaps)
        repairs.append(
            gaps_repair(len(gaps), lost, len(kept), sum(len(g) for g in grids) - len(time))
        )
    return replace(
        columns,
        samples={role: Samples(values=v, clock=time) for role, v in values.items()},
        masks=masks,
        segments=adjoining([len(grid) for _, grid in kept]),
        period=step,
        repairs=tuple(repairs),
        clock=PeriodSource(
            step=1.0 if rate == "auto" else period * chosen,
            uncertainty=uncertainty,
            stated=stated is not None,
        ),
    )


def _pieces(clock: Array, edges: Sequence[float] | Array) -> list[tuple[float, float]]:
    """Return the first and last time, s, of each piece of a column without gaps.

    The column is also cut at the times between windows (`edges`, s).
    """
    cuts = np.searchsorted(clock, edges, side="right")
    pieces = np.split(clock, np.union1d(long_steps(clock, MAX_UNEVEN_STEP.value) + 1, cuts))
    return [(float(piece[0]), float(piece[-1])) for piece in pieces if len(piece)]


def _common_intervals(lists: Sequence[list[tuple[float, float]]]) -> list[tuple[float, float]]:
    """Return the first and last time, s, of each interval that all columns cover.

    `lists` has the pieces of each column. A common interval begins at a start at which as many
    pieces have begun and not ended as there are columns. It ends at the next end of a piece.
    """
    starts, stops = (np.sort([piece[end] for each in lists for piece in each]) for end in (0, 1))
    ended = np.searchsorted(stops, starts, "right")
    begin = np.flatnonzero(np.arange(1, len(starts) + 1) - ended == len(lists))
    return [*zip(starts[begin].tolist(), stops[ended[begin]].tolist(), strict=True)]


def _on_grid(
    grid: Array, piece: tuple[float, float], clock: Array, samples: Samples, how: Interpolation
) -> Array:
    """Return a column interpolated at the times of a grid, (n,).

    The samples within a piece and the neighbouring sample on each side are used.

    Parameters
    ----------
    grid : (n,) array
        Times of the grid, s.
    piece : (float, float)
        First and last time of the piece, s.
    clock : (N,) array
        Times of the column, s.
    samples : Samples
        Samples of the column.
    how : {"spline", "linear", "held"}
        Interpolation; linear if there are too few samples for a spline.
    """
    first = max(int(np.searchsorted(clock, piece[0], "right")) - 1, 0)
    last = int(np.searchsorted(clock, piece[1], "left")) + 1
    time, values = clock[first:last], samples.values[first:last]
    return at_times(grid, time, values, how if len(time) >= _FEWEST else "linear")


def _resample_repair(
    clocks: Mapping[str, Array],
    time: Array,
    rate: float,
    interpolations: Mapping[str, Interpolation],
) -> Repair:
    """Return the repair that reports the resampling of columns.

    Parameters
    ----------
    clocks : mapping of str to (N,) array
        Times before resampling by role, s.
    time : (n,) array
        Times after resampling, s.
    rate : float
        Rate after resampling, Hz.
    interpolations : mapping of str to {"spline", "linear", "held"}
        Interpolation by role.
    """
    phrases = {"spline": "by cubic splines", "linear": "by straight lines", "held": "held"}
    used = []  # "position, velocity by cubic splines"
    for way, phrase in phrases.items():
        roles = ", ".join(role for role, chosen in interpolations.items() if chosen == way)
        if roles:
            used.append(f"{roles} {phrase}")
    recorded = ", ".join(
        f"{role} {len(clock)} rows at {1 / float(np.median(np.diff(clock))):.6g} Hz"
        for role, clock in clocks.items()
    )
    return Repair(
        kind="resample",
        count=len(time),
        text=f"the columns are resampled at {rate:.6g} Hz to {len(time)} rows, {', '.join(used)}, "
        f"without a low-pass (recorded: {recorded})",
    )


def own_period(clock: Array) -> tuple[float, float]:
    """Return the sampling period of an uneven clock, s, and its relative uncertainty.

    It is the period at which the times of the longest piece have the same phase, for any number of
    lost samples. If jitter hides this period, the mean step is returned.
    """
    steps = np.diff(clock)
    typical = float(np.median(steps))
    gaps = long_steps(clock, MAX_UNEVEN_STEP.value)
    piece = max(np.split(clock, gaps + 1), key=len)
    period = _in_phase(piece, typical)
    if period is not None:
        off = np.diff(piece) / period
        return period, float(np.ptp(off - np.round(off))) * period / float(piece[-1] - piece[0])
    # The number of lost samples is unknown.
    return float(np.mean(np.delete(steps, gaps))), 0.1


def _in_phase(time: Array, guess: float) -> float | None:
    """Return the period near a guess, s, at which all times have about the same phase.

    None if there is no such period. A first part of the times is searched on a grid of rates
    (1/period). The rate is then refined with more and more of the times, and finally by the slope
    of the phase.
    """
    time, count = time - time[0], min(1024, len(time))
    rate, reach = 1 / guess, 0.25 / guess
    while True:
        some = time[:count]
        step = 0.25 / float(some[-1])  # changes the phase of the last time by a quarter of a turn
        rates = rate + step * np.arange(-np.ceil(reach / step), np.ceil(reach / step) + 1)
        sums = np.abs([np.exp(2j * np.pi * r * some).sum() for r in rates])
        # Measured, 3.5 is the largest of a thousand such sums of random phases.
        if sums.max() < 3.5 * np.sqrt(count):
            return None
        rate, reach = float(rates[np.argmax(sums)]), 2 * step
        if count == len(time) or count >= 65_536:
            break
        count = min(4 * count, len(time))
    # The slope of the phase, turns/s, is the error of the rate.
    turns = rate * some
    turns -= float(np.angle(np.exp(2j * np.pi * turns).sum())) / (2 * np.pi)
    from_mean = some - some.mean()
    return 1 / (rate - float(from_mean @ (turns - np.round(turns)) / (from_mean @ from_mean)))
