"""Columns of any times onto one even grid: splines for the motion, straight lines for the force."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from axisid.estimation.records.columns import motion_role
from axisid.estimation.tables import PeriodSource, Repair, Samples
from axisid.estimation.thresholds import MAX_UNEVEN_STEP
from axisid.support.arrays import Array
from axisid.support.errors import DataError, UsageError

from .clipping import Mask
from .clocks import check_increases, check_stated, long_steps
from .repairs import Span, adjoining, gaps_repair
from .shifts import Interpolation, at_times

_MIN_RESAMPLING_RATE = 0.9  # of the position's rate; below, its noise would fold

_MOST_ROWS = 1e8
_FEWEST = 4  # samples, for a spline
_SPLINED = ("position", "velocity", "reference")  # by cubic splines; the rest by straight lines

# sum of the stamps' unit phases, by that of as many random ones, from which a rate is the
# clock's: measured, the largest of a thousand such sums of random phases
_MIN_PHASE_SUM = 3.5
# of a mean time step, where nothing tells how many samples were lost
_LOST_PERIOD_UNCERTAINTY = 0.1

_FIRST, _MORE, _MOST = 1024, 4, 65_536  # samples that are looked at, at once, times, at most
_NEAR = 0.25  # of the guess: how far the rate may be from it
_FINE = 0.25  # of a turn over all samples: the step of the rates that are tried


@dataclass(frozen=True, slots=True, kw_only=True)
class AlignedColumns:
    """Columns of one time: on an even grid, or as they were sampled.

    Attributes
    ----------
    time : (N,) array
        s
    columns : mapping of str to (N,) array
        By role.
    masked : (N,) array of bool
        Where a neighbour was masked.
    segments : tuple of (int, int)
    period : float or None
        s; None takes the mean step.
    repairs : tuple of Repair
    clock : PeriodSource
        The position's.
    """

    time: Array
    columns: Mapping[str, Array]
    masked: Mask
    segments: tuple[Span, ...]
    period: float | None
    repairs: tuple[Repair, ...]
    clock: PeriodSource


def resample(
    source: str,
    samples: Mapping[str, Samples],
    masks: Mapping[str, Mask],
    rate: float | Literal["auto"],
    *,
    split: bool,
    stated: float | None = None,
    splined: Sequence[str] = _SPLINED,
    between: Mapping[str, Interpolation] | None = None,
    edges: Sequence[float] | Array = (),
    held: Sequence[str] = (),
) -> AlignedColumns:
    """Resample columns, each with its own clock.

    Parameters
    ----------
    source : str
        File name, for messages.
    samples : mapping of str to Samples
        By role, each with its clock.
    masks : mapping of str to (N,) array of bool
        Samples that are no measurements, by role.
    rate : float or "auto"
        Hz.
    split : bool
        Whether the log may be cut at gaps.
    stated : float, optional
        s; the position's sampling period as the user knows it, in place of its mean step.
    splined : sequence of str
        Roles that go on smoothly between their samples.
    between : mapping of str to {"spline", "linear", "held"}
        What other roles are between theirs.
    edges : sequence of float
        Times between windows, s, where the log is cut anyway.
    held : sequence of str
        Signals that keep their value until their next sample.

    Raises
    ------
    UsageError
        The rate is lower than the position's.
    DataError
        Time does not increase, has gaps that are not to be cut at, is not sampled as was stated, or
        the columns do not overlap.
    """
    clocks = {role: _clock(source, role, s) for role, s in samples.items()}
    moving = motion_role(samples)
    period, uncertainty = own_period(clocks[moving])
    if stated is not None:
        check_stated(source, period, stated, uncertainty)
        period, uncertainty = stated, 0.0
    own = 1 / period
    chosen = own if rate == "auto" else rate
    _check_rate(source, chosen, own, clocks)
    covered = _common([_pieces(clock, edges) for clock in clocks.values()])
    grids = [_grid(a, b, 1 / chosen) for a, b in covered]
    kept = [(piece, g) for piece, g in zip(covered, grids, strict=True) if len(g) >= _FEWEST]
    if not kept:
        raise DataError(
            f"{source}: the columns have no time in common; check their clocks.",
            code="resampling",
        )
    between_pieces = [(a[1], b[0]) for a, b in pairwise(covered)]
    gaps = [(a, b) for a, b in between_pieces if not any(a <= edge <= b for edge in edges)]
    if gaps and not split:
        raise DataError(
            f"{source}: time has {len(gaps)} gaps, the first after {gaps[0][0]:.9g} s; "
            'resampling would invent the motion there. Add gaps="split".',
            code="uneven-time",
        )
    ways: dict[str, Interpolation] = {
        **dict.fromkeys(held, "held"),
        **dict.fromkeys(splined, "spline"),
    }
    hows = {role: (between or {}).get(role, ways.get(role, "linear")) for role in samples}
    columns = {
        role: np.concatenate(
            [_onto(grid, piece, clocks[role], s, hows[role]) for piece, grid in kept]
        )
        for role, s in samples.items()
    }
    time = np.concatenate([grid for _, grid in kept])
    repairs = [_told(clocks, time, chosen, hows)]
    if split:
        lost = sum(after - before - 1 / own for before, after in gaps)
        out = sum(len(g) for g in grids) - len(time)
        repairs.append(gaps_repair(len(gaps), lost, len(kept), out))
    return AlignedColumns(
        time=time,
        columns=columns,
        masked=_masked_at(time, clocks, masks),
        segments=adjoining([len(grid) for _, grid in kept]),
        period=1 / chosen,
        repairs=tuple(repairs),
        clock=PeriodSource(
            step=1.0 if rate == "auto" else period * chosen,
            uncertainty=uncertainty,
            stated=stated is not None,
        ),
    )


def _masked_at(time: Array, clocks: Mapping[str, Array], masks: Mapping[str, Mask]) -> Mask:
    """Which times are beside a sample that is no measurement."""
    masked = np.zeros(len(time), dtype=bool)
    for role, mask in masks.items():
        masked |= np.interp(time, clocks[role], mask.astype(np.float64)) > 0
    return masked


def _check_rate(source: str, chosen: float, own: float, clocks: Mapping[str, Array]) -> None:
    """Refuse a rate, Hz, that folds the motion's noise, or makes too much of the log."""
    moving = motion_role(clocks)
    if chosen < _MIN_RESAMPLING_RATE * own:
        raise UsageError(
            f"{source}: the {moving} is sampled at {own:.6g} Hz; resampled at {chosen:g} Hz "
            f"its noise would fold. Resample at {own:.6g} Hz or more; decimate keeps fewer "
            "rows.",
            code="resampling",
        )
    duration = max(float(clock[-1] - clock[0]) for clock in clocks.values())
    if duration * chosen > _MOST_ROWS:
        raise UsageError(
            f"{source}: resampled at {chosen:g} Hz it would have {duration * chosen:.2g} rows; "
            f"give a lower rate (the {moving} is sampled at {own:.6g} Hz).",
            code="resampling",
        )


def _clock(source: str, role: str, samples: Samples) -> Array:
    clock = samples.clock
    if clock is None or len(clock) < _FEWEST:
        raise DataError(
            f"{source}: the {role} has too few rows, or no times, to be resampled.",
            code="too-short",
        )
    check_increases(source, f"the time of the {role}", clock)
    return clock


def _pieces(clock: Array, edges: Sequence[float] | Array) -> list[tuple[float, float]]:
    """First and last time of each piece of a clock without gaps, cut where windows end."""
    ends = np.searchsorted(clock, edges, side="right") - 1
    ends = ends[(ends >= 0) & (ends < len(clock) - 1)]
    gaps = np.union1d(long_steps(clock, MAX_UNEVEN_STEP.value), ends).astype(int)
    return [
        (float(clock[a]), float(clock[b]))
        for a, b in zip([0, *(gaps + 1)], [*gaps, len(clock) - 1], strict=True)
    ]


def _common(lists: Sequence[list[tuple[float, float]]]) -> list[tuple[float, float]]:
    starts, stops = (np.sort([piece[end] for each in lists for piece in each]) for end in (0, 1))
    ended = np.searchsorted(stops, starts, "right")
    begin = np.flatnonzero(np.arange(1, len(starts) + 1) - ended == len(lists))
    return [*zip(starts[begin].tolist(), stops[ended[begin]].tolist(), strict=True)]


def _grid(start: float, stop: float, period: float) -> Array:
    count = int(np.floor((stop - start) / period * (1 + 1e-12) + 1e-6)) + 1
    return start + period * np.arange(count, dtype=np.float64)


def _onto(
    grid: Array, piece: tuple[float, float], clock: Array, samples: Samples, how: Interpolation
) -> Array:
    """A column at the times of a grid, from its samples in and just around a piece."""
    first = max(int(np.searchsorted(clock, piece[0], "right")) - 1, 0)
    last = int(np.searchsorted(clock, piece[1], "left")) + 1
    time, values = clock[first:last], samples.values[first:last]
    return at_times(grid, time, values, how if len(time) >= _FEWEST else "linear")


def _told(
    clocks: Mapping[str, Array], time: Array, rate: float, hows: Mapping[str, Interpolation]
) -> Repair:
    ways = (("spline", "by cubic splines"), ("linear", "by straight lines"), ("held", "held"))
    by_way = [(", ".join(role for role, how in hows.items() if how == w), told) for w, told in ways]
    how = ", ".join(f"{roles} {told}" for roles, told in by_way if roles)
    rates = {role: 1 / float(np.median(np.diff(clock))) for role, clock in clocks.items()}
    taken = ", ".join(f"{r} {len(clocks[r])} rows at {hz:.6g} Hz" for r, hz in rates.items())
    text = f"resampled at {rate:.6g} Hz to {len(time)} rows, {how}, without a low-pass ({taken})"
    return Repair(kind="resample", count=len(time), text=text)


def own_period(clock: Array) -> tuple[float, float]:
    """Sampling period of an uneven clock, s, and what is open of it, relative.

    It is the one at which the times of the longest piece have one phase, whatever was lost of it.
    Where jitter leaves none, it is the mean step.
    """
    steps = np.diff(clock)
    typical = float(np.median(steps))
    longest_step = MAX_UNEVEN_STEP.value * typical
    edges = np.concatenate([[0], np.flatnonzero(steps > longest_step) + 1, [len(clock)]])
    longest = int(np.argmax(np.diff(edges)))
    piece = clock[edges[longest] : edges[longest + 1]]
    period = _in_phase(piece, typical)
    if period is not None:
        off = np.diff(piece) / period
        return period, float(np.ptp(off - np.round(off))) * period / float(piece[-1] - piece[0])
    return float(np.mean(steps[steps <= longest_step])), _LOST_PERIOD_UNCERTAINTY


def _in_phase(time: Array, guess: float) -> float | None:
    """Period near a guess at which times have about one phase, s; None where there is none."""
    time, count = time - time[0], min(_FIRST, len(time))
    rate, reach = 1 / guess, _NEAR / guess
    while True:
        some = time[:count]
        step = _FINE / float(some[-1])
        rates = rate + step * np.arange(-np.ceil(reach / step), np.ceil(reach / step) + 1)
        sums = np.abs([np.exp(2j * np.pi * r * some).sum() for r in rates])
        if sums.max() < _MIN_PHASE_SUM * np.sqrt(count):
            return None
        rate, reach = float(rates[np.argmax(sums)]), 2 * step
        if count == len(time) or count >= _MOST:
            return 1 / (rate + _slope(some, rate))
        count = min(_MORE * count, len(time))


def _slope(time: Array, rate: float) -> float:
    """How the phase of times at a rate grows, turns/s: by how much the rate is too low."""
    turns = rate * time
    middle = float(np.angle(np.exp(2j * np.pi * turns).sum())) / (2 * np.pi)
    phase = turns - middle - np.round(turns - middle)
    from_mean = time - time.mean()
    return -float(from_mean @ phase / (from_mean @ from_mean))
