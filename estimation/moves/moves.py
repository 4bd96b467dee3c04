"""Moves: stretches of motion about one largest speed, as long as it is not slow between.

Where a reference repeats, the same move comes after the same one, or after a rest. Moves are
compared with one another, sample by sample, not the whole with itself: so repeats are found that
rests of any length part, and in the middle of others.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from axisid.support.arrays import Array

_MIN_MOVE_SPEED = 0.02  # of the largest speed, that a move has to reach
_MIN_MOVE_PROMINENCE = 0.5  # of its largest speed, that a move has to fall by before the next
_MAX_LEVEL_SPREAD = 0.1  # relative difference of largest speeds of one level
_MIN_SPEED_OF_A_MOVE = 1e-3  # of the largest speed; slower is between two moves

Index = NDArray[np.intp]

_TURN = 3  # samples that a reversal may be slow for; a rest is longer
# of the reference's travel, between two moves; logged digits differ by less, others by more
_MAX_REPEAT_DIFFERENCE = 1e-4
_SHIFTS = (0, -1, 1, -2, 2)  # samples by which last digits may move the ends of a move
_ENDS = 2  # samples at both ends of a move that are not compared
_REST = -1  # what is before a move that begins at rest
_NONE = -1


@dataclass(frozen=True, slots=True, kw_only=True)
class Moves:
    """Moves in the order of time.

    Attributes
    ----------
    starts, stops : (m,) array of int
        First sample of each, and the one after its last. One begins where the other ends, but for
        rests.
    speeds : (m,) array
        Where each is fastest, with the sign of the direction.
    """

    starts: Index
    stops: Index
    speeds: Array

    def __len__(self) -> int:
        return len(self.starts)

    @property
    def levels(self) -> Index:
        """Number of the speed level of each move, from the slowest, (m,)."""
        return levels_of(np.abs(self.speeds))


def moves_of(velocity: Array) -> Moves:
    """The moves of a velocity, (N,): of a reference, or filtered."""
    from scipy.signal import find_peaks

    speed = np.concatenate([[0.0], np.abs(velocity), [0.0]])
    top = float(speed.max())
    found, shape = find_peaks(speed, height=_MIN_MOVE_SPEED * top, prominence=0.0)
    own = shape["prominences"] > _MIN_MOVE_PROMINENCE * shape["peak_heights"]
    speed = speed[1:-1]
    peaks = _apart(speed, found[own] - 1) if top > 0 else np.empty(0, dtype=np.intp)
    slow = _MIN_SPEED_OF_A_MOVE * top
    gaps = [_gap(speed, a, b, slow) for a, b in pairwise(peaks)]
    moving = np.flatnonzero(speed > slow)
    first, last = (moving[0], moving[-1] + 1) if len(moving) else (0, 0)
    return Moves(
        starts=np.array([first, *(b for _, b in gaps)], dtype=np.intp)[: len(peaks)],
        stops=np.array([*(a for a, _ in gaps), last], dtype=np.intp)[: len(peaks)],
        speeds=np.asarray(velocity[peaks], dtype=float),
    )


def _apart(speed: Array, peaks: Index) -> Index:
    """Peaks between which the speed falls; of those that are as high as one another the first."""
    kept: list[int] = []
    for peak in map(int, peaks):
        if kept:
            lowest, height = speed[kept[-1] : peak].min(), min(speed[kept[-1]], speed[peak])
            if lowest > (1 - _MIN_MOVE_PROMINENCE) * height:
                continue
        kept.append(peak)
    return np.array(kept, dtype=np.intp)


def _gap(speed: Array, before: int, after: int, slow: float) -> tuple[int, int]:
    """Where a move ends and where the next begins, between their peaks."""
    between = speed[before:after]
    lowest = float(between.min())
    low = before + np.flatnonzero(between <= lowest + slow)  # one speed, but for its last digits
    if lowest <= slow and len(low) > _TURN:
        return int(low[0]), int(low[-1]) + 1
    middle = int(low[len(low) // 2])
    return middle, middle


def levels_of(sizes: Array) -> Index:
    """Number of the level of each size, from the smallest; sizes of one level are alike."""
    labels, level, lowest = np.zeros(len(sizes), dtype=np.intp), -1, -np.inf
    for i in np.argsort(sizes, kind="stable"):
        if level < 0 or sizes[i] > lowest * (1 + _MAX_LEVEL_SPREAD):
            level, lowest = level + 1, float(sizes[i])
        labels[i] = level
    return labels


@dataclass(frozen=True, slots=True, kw_only=True)
class Repeats:
    """Which samples of a record are the same phase of the same move.

    Attributes
    ----------
    move : (N,) array of int
        Number of the repeated move that a sample is in; -1 in none.
    offset : (N,) array of int
        Samples since that move began.
    period : int or None
        Samples after which all of it repeats; None where moves repeat in another order.
    times : int
        How often the move that repeats most often does.
    """

    move: Index
    offset: Index
    period: int | None
    times: int


def repeats_of(reference: Array, spans: tuple[tuple[int, int], ...]) -> Repeats | None:
    """What repeats in a reference, (N,), with gaps between its spans; None where nothing does."""
    travel = float(np.ptp(reference))
    if not (np.isfinite(travel) and travel > 0):
        return None
    tolerance = _MAX_REPEAT_DIFFERENCE * travel
    pieces = [(a, moves_of(np.diff(reference[a:b]))) for a, b in spans]
    moves = Moves(
        starts=np.concatenate([a + m.starts for a, m in pieces]),
        stops=np.concatenate([a + m.stops for a, m in pieces]),
        speeds=np.concatenate([m.speeds for _, m in pieces]),
    )
    kinds, shifts = _kinds(reference, moves, tolerance)
    before = np.where(moves.starts[1:] > moves.stops[:-1], _REST, kinds[:-1])
    # How the record came to the first move of a span is not in it.
    first = np.cumsum([0, *(len(m) for _, m in pieces)])
    places: dict[tuple[int, int], list[int]] = {}
    for i in map(int, np.setdiff1d(np.arange(len(moves)), first)):
        places.setdefault((int(kinds[i]), int(before[i - 1])), []).append(i)
    repeated = [found for found in places.values() if len(found) > 1]
    return _described(reference, moves, shifts, repeated, tolerance) if repeated else None


def _kinds(reference: Array, moves: Moves, tolerance: float) -> tuple[Index, Index]:
    """Which moves are the same, by the number of the first such, and their shifts against it."""
    kinds, shifts = np.arange(len(moves)), np.zeros(len(moves), dtype=np.intp)
    lengths = moves.stops - moves.starts
    near = tolerance + max(map(abs, _SHIFTS)) * np.abs(np.diff(reference)).max()
    for i in range(len(moves)):
        alike = (kinds[:i] == np.arange(i)) & (np.abs(lengths[:i] - lengths[i]) <= max(_SHIFTS))
        alike &= np.abs(reference[moves.starts[:i]] - reference[moves.starts[i]]) <= near
        alike &= np.sign(moves.speeds[:i]) == np.sign(moves.speeds[i])
        for j in np.flatnonzero(alike):
            own = reference[moves.starts[j] + _ENDS : moves.stops[j] - _ENDS]
            shift, away = _shift(reference, own, int(moves.starts[i]) + _ENDS)
            if away <= tolerance:
                kinds[i], shifts[i] = j, shift
                break
    return kinds, shifts


def _shift(reference: Array, own: Array, start: int) -> tuple[int, float]:
    """By how many samples another move is best shifted to be one, and how far it is off then."""
    size, away = len(own), [np.inf] * len(_SHIFTS)
    for place, begin in enumerate(start + shift for shift in _SHIFTS):
        if 0 <= begin <= len(reference) - size < len(reference):
            away[place] = float(np.abs(reference[begin : begin + size] - own).max())
    best = int(np.argmin(away))  # the smaller shift of two as good
    return _SHIFTS[best], away[best]


def _described(
    reference: Array,
    moves: Moves,
    shifts: Index,
    repeated: list[list[int]],
    tolerance: float,
) -> Repeats:
    size = len(reference)
    move = np.full(size, _NONE, dtype=np.intp)
    offset = np.zeros(size, dtype=np.intp)
    begins = np.maximum(moves.starts + shifts, 0)
    for number, places in enumerate(repeated):
        length = min(int(moves.stops[i] - moves.starts[i]) for i in places)
        for i in places:
            stop = min(int(begins[i]) + length, size)
            move[begins[i] : stop] = number
            offset[begins[i] : stop] = np.arange(stop - begins[i])
    used = np.flatnonzero(move != _NONE)
    stretch = reference[used[0] : used[-1] + 1]
    lags = {int(lag) for places in repeated for lag in np.diff(begins[places])}
    return Repeats(
        move=move,
        offset=offset,
        period=_period(stretch, lags, tolerance),
        times=max(map(len, repeated)),
    )


def _period(reference: Array, lags: set[int], tolerance: float) -> int | None:
    """The shortest of these lags after which a stretch of the reference is the same all along."""
    for lag in sorted(lag for lag in lags if 0 < lag < len(reference)):
        if float(np.abs(reference[lag:] - reference[:-lag]).max()) <= tolerance:
            return lag
    return None
