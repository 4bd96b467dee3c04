"""Windows, gaps and segments of a log."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import accumulate, pairwise
from operator import index
from typing import Any

import numpy as np

from axisid.estimation.raw_tables import PeriodSource, Repair, Samples
from axisid.estimation.records.columns import RoleColumns
from axisid.estimation.thresholds import MAX_EVEN_STEP, MIN_RECORD_SAMPLES
from axisid.support.arrays import Array, mask_of
from axisid.support.checks import refuse
from axisid.support.errors import DataError, UsageError
from axisid.support.wording import quoted

from .clocks import long_steps, period_uncertainty

#: First sample and the one after the last.
Span = tuple[int, int]
#: First and last time of a window, s, in the time of the log.
Window = tuple[float, float]

_GIVE_TIMES = (
    'Give FROM..TO in seconds, such as "2..5", "2.." or "..5", or a pair, such as (2.0, None)'
)


def checked_windows(windows: Iterable[object]) -> tuple[Window, ...]:
    """Return the first and last time of each window, s, in order of time; infinite for open ends.

    Parameters
    ----------
    windows : iterable of (float or None, float or None) or str, or str
        Windows as the user gave them; a single text is one window.

    Raises
    ------
    UsageError
        A window is not a pair of numbers, ends before it begins, or overlaps another window.
    """
    listed = [windows] if isinstance(windows, str) else windows
    if isinstance(listed, bytes) or not isinstance(listed, Iterable):
        raise UsageError(f"the windows are {quoted(windows)}. {_GIVE_TIMES}.", code="window")
    ordered = sorted(_checked_window(each) for each in listed)
    refuse(
        UsageError,
        *(
            (
                other[0] < one[1],
                f"the windows {windows_text([one])} and {windows_text([other])} overlap. Combine "
                "them into one window",
            )
            for one, other in pairwise(ordered)
        ),
        code="window",
    )
    return tuple(ordered)


def _checked_window(window: Any) -> Window:
    """Return the first and last time of one window, s; infinite for open ends.

    Raises
    ------
    UsageError
        The window is not a pair of numbers, or ends before it begins.
    """
    ends = window.split("..") if isinstance(window, str) else window
    try:
        start, stop = (
            infinite if end is None or not str(end).strip() else float(end)
            for end, infinite in zip(ends, (-math.inf, math.inf), strict=True)
        )
    except (TypeError, ValueError) as error:
        raise UsageError(
            f"the window {quoted(window)} is not a pair of times. {_GIVE_TIMES}.", code="window"
        ) from error
    if not start < stop:
        raise UsageError(
            f"the window {quoted(window)} does not end after it begins. Give two times of the log "
            "in seconds, the earlier time first.",
            code="window",
        )
    return start, stop


def windows_text(windows: Sequence[Window]) -> str:
    """Return windows as a text: ``from 2 to 5 s and from 10 s on``."""
    texts = {
        (False, False): "from {0:.9g} to {1:.9g} s",
        (False, True): "from {0:.9g} s on",
        (True, False): "up to {1:.9g} s",
        (True, True): "over the whole log",
    }
    return " and ".join(
        texts[math.isinf(start), math.isinf(stop)].format(start, stop) for start, stop in windows
    )


def samples_within(
    source: str, time: Array, windows: Sequence[Window], fewest: int = 1
) -> tuple[Span, ...]:
    """Return the first sample and the one after the last of each window.

    A time on the edge of two windows belongs to the earlier window. Samples without a time belong
    to the window of the samples around them.

    Parameters
    ----------
    source : str
        Name of the log, for messages.
    time : (N,) array
        Times of the samples, s; NaN for a sample without a time.
    windows : sequence of Window
        First and last time of each window, s.
    fewest : int
        Smallest number of samples of a window.

    Raises
    ------
    DataError
        A window is outside the log, or has too few samples.
    """
    finite = time[np.isfinite(time)]
    close = 1e-6 * float(np.median(np.abs(np.diff(finite)))) if finite.size > 1 else 0.0
    spans: list[Span] = []
    for start, stop in windows:
        inside = np.flatnonzero((time >= start - close) & (time <= stop + close))
        begin = max(int(inside[0]), spans[-1][1] if spans else 0) if inside.size else 0
        end = int(inside[-1]) + 1 if inside.size else 0
        if end - begin < fewest:
            covered = "The log has no finite times"
            if finite.size:
                covered = f"The times of the log are {finite.min():.9g} to {finite.max():.9g} s"
            raise DataError(
                f"{source}: the window {windows_text([(start, stop)])} has "
                f"{max(end - begin, 0) or 'no'} samples. {covered}. Give times within the log, or "
                "a longer window.",
                code="window",
            )
        spans.append((begin, end))
    return tuple(spans)


def within(
    columns: RoleColumns, windows: Sequence[Window]
) -> tuple[RoleColumns, tuple[Window, ...]]:
    """Return the columns cut to the windows, and the windows limited to the times of the log.

    Returns
    -------
    RoleColumns
        Columns with the samples of the windows, each column by its own times.
    tuple of Window
        Windows limited to the times of the position or velocity, s.
    """
    clock = columns.motion.times
    motion_spans = samples_within(columns.source, clock, windows)
    spans = {
        role: samples_within(f"{columns.source}, {role}", s.times, windows)
        for role, s in columns.samples.items()
    }
    kept = {r: s.taken(mask_of(spans[r], len(s.values))) for r, s in columns.samples.items()}
    reached = reaching(windows, float(np.nanmin(clock)), float(np.nanmax(clock)))
    return replace(
        columns.repaired(kept, window_repair(windows, motion_spans, len(clock))),
        source=f"{columns.source} {windows_text(reached)}",
    ), reached


def reaching(windows: Sequence[Window], first: float, last: float) -> tuple[Window, ...]:
    """Return windows limited to the first and last time of a log, s."""
    return tuple((max(start, first), min(stop, last)) for start, stop in windows)


def window_repair(windows: Sequence[Window], spans: Sequence[Span], samples: int) -> Repair:
    """Return the repair that reports windows, with the number of left-out samples.

    Parameters
    ----------
    windows : sequence of Window
        First and last time of each window, s.
    spans : sequence of (int, int)
        First sample and the one after the last of each window.
    samples : int
        Number of samples of the log.
    """
    left_out = samples - sum(stop - start for start, stop in spans)
    used = f"only the window {windows_text(windows)} is used"
    if len(spans) > 1:
        used = (
            f"only the windows {windows_text(windows)} are used, and each is filtered and "
            "simulated separately"
        )
    return Repair(
        kind="window",
        count=left_out,
        text=f"{used}: {left_out} of {samples} samples are left out",
    )


def edges(windows: Sequence[Window]) -> Array:
    """Return the times between consecutive windows, at which a log is cut, s."""
    return np.array([(before[1] + after[0]) / 2 for before, after in pairwise(windows)])


def as_sampled(
    columns: RoleColumns, period: float | None, windows: Sequence[Window], *, split: bool
) -> RoleColumns:
    """Return columns divided into segments, without resampling.

    Parameters
    ----------
    columns : RoleColumns
        Columns by role, with common times.
    period : float or None
        Given sampling period, s; None for the mean step.
    windows : sequence of Window
        First and last time of each window, s. The columns are cut between windows, also where there
        is no gap.
    split : bool
        True if the columns are also cut at gaps; pieces that are too short for a record are then
        left out.
    """
    # Cut between the windows and at the gaps.
    time = np.asarray(columns.motion.times, dtype=np.float64)
    cuts = np.searchsorted(time, edges(windows), side="right")
    gaps = np.setdiff1d(long_steps(time, MAX_EVEN_STEP.value), cuts - 1) if split else cuts[:0]
    pieces = [*pairwise([0, *np.union1d(gaps + 1, cuts).tolist(), len(time)])]
    pieces = [(a, b) for a, b in pieces if not split or b - a >= MIN_RECORD_SAMPLES.value]
    kept = mask_of(pieces, len(time))
    if split:
        steps = np.diff(time)
        lost = float(np.sum(steps[gaps] - np.median(steps))) if len(gaps) else 0.0
        columns = columns.repaired(
            {}, gaps_repair(len(gaps), lost, len(pieces), int(np.sum(~kept)))
        )
    # Keep the samples of the pieces, each of which is a segment.
    segments, time = adjoining([b - a for a, b in pieces]), time[kept]
    jitter = period_uncertainty([time[start:stop] for start, stop in segments or ((0, len(time)),)])
    return replace(
        columns,
        samples={r: Samples(values=s.values[kept], clock=time) for r, s in columns.samples.items()},
        masks={role: mask[kept] for role, mask in columns.masks.items()},
        segments=segments,
        period=period,
        clock=PeriodSource(
            uncertainty=jitter if period is None else 0.0, stated=period is not None
        ),
    )


def adjoining(lengths: Sequence[int]) -> tuple[Span, ...]:
    """Return consecutive segments of the given lengths; empty for a single length."""
    return tuple(pairwise(accumulate(lengths, initial=0))) if len(lengths) > 1 else ()


def gaps_repair(gaps: int, lost: float, segments: int, dropped: int) -> Repair:
    """Return the repair that reports a log cut at gaps.

    Parameters
    ----------
    gaps : int
        Number of gaps.
    lost : float
        Missing time, s.
    segments : int
        Number of segments.
    dropped : int
        Number of rows that are left out because their pieces are too short.
    """
    text = "no gaps found"
    if gaps:
        text = (
            f"the log is cut at {gaps} {'gap' if gaps == 1 else 'gaps'} ({lost:.4g} s are missing) "
            f"into {segments} segments, and each is filtered and simulated separately"
        )
        if dropped:
            text += (
                f"; {dropped} rows in pieces of fewer than {MIN_RECORD_SAMPLES.value} rows are "
                "left out"
            )
    return Repair(kind="gaps", count=gaps, text=text)


def checked_spans(source: str, name: str, spans: object) -> tuple[Span, ...]:
    """Return spans as pairs of whole numbers: the first row and the one after the last.

    Parameters
    ----------
    source, name : str
        Names of the record and of the spans, for messages.
    spans : object
        Spans as the user gave them.

    Raises
    ------
    UsageError
        The spans are not pairs of whole numbers.
    """
    try:
        return tuple((index(start), index(stop)) for start, stop in spans)  # type: ignore[attr-defined]
    except (TypeError, ValueError) as error:
        raise UsageError(
            f"{source}: the {name} are {quoted(spans)}. Give pairs of row numbers: the first row, "
            "and the row after the last."
        ) from error


def check_spans(
    source: str, time: Array, segments: tuple[Span, ...], masked: tuple[Span, ...]
) -> None:
    """Refuse segments that are too short or not consecutive, and masked rows that do not exist.

    Parameters
    ----------
    source : str
        Name of the record, for messages.
    time : (N,) array
        Times of the record, s.
    segments, masked : tuple of (int, int)
        First row and the one after the last of each segment, and of each masked piece.

    Raises
    ------
    DataError
        A segment has fewer rows than a record needs, the segments do not cover all rows one after
        another, or masked rows do not exist.
    """
    fewest, samples = MIN_RECORD_SAMPLES.value, len(time)
    # Each segment must begin where the one before it ends, and the last must end with the record.
    ends = [0, *(end for span in segments for end in span), samples]
    are_consecutive = not segments or ends[::2] == ends[1::2]
    for start, stop in segments:
        if are_consecutive and start < stop < start + fewest:
            raise DataError(
                f"{source}: the segment from {time[start]:.6g} to {time[stop - 1]:.6g} s has "
                f"{stop - start} rows, but needs {fewest} or more. Give a longer window, or omit "
                "this window.",
                code="too-short",
            )
    have_rows = all(stop > start for start, stop in segments)
    are_inside = all(0 <= start < stop <= samples for start, stop in masked)
    if not (are_consecutive and have_rows and are_inside):
        raise DataError(
            f"{source}: the segments {segments} and masked rows {masked} do not fit a record of "
            f"{samples} rows. Give segments that cover all rows in order, without overlap, with "
            f"{fewest} rows or more each.",
            code="record",
        )
