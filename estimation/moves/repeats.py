"""Where a reference repeats: the same move after the same one, or after a rest.

Moves are compared with one another, sample by sample, not the whole with itself: so repeats are
found that rests of any length part, and in the middle of others.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from axisid.support.arrays import Array

from .moves import Index, Moves, moves_of

# of the reference's travel, between two moves; logged digits differ by less, others by more
_MAX_REPEAT_DIFFERENCE = 1e-4

_SHIFTS = (0, 1, -1, 2, -2)  # samples by which last digits may move the ends of a move
_ENDS = 2  # samples at both ends of a move that are not compared
_REST = -1  # what is before a move that begins at rest
_NONE = -1


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
    moves, breaks = _joined(reference, spans)
    tolerance = _MAX_REPEAT_DIFFERENCE * travel
    kinds, shifts = _kinds(reference, moves, tolerance)
    keys = [*_keys(moves, kinds, breaks)]
    places: dict[tuple[int, int], list[int]] = {}
    for i, key in enumerate(keys):
        if key is not None:
            places.setdefault(key, []).append(i)
    repeated = [found for found in places.values() if len(found) > 1]
    return _described(reference, moves, shifts, repeated, tolerance) if repeated else None


def _joined(reference: Array, spans: tuple[tuple[int, int], ...]) -> tuple[Moves, set[int]]:
    """The moves of every span, and those that are the first of theirs."""
    pieces, breaks, count = [], set(), 0
    for a, b in spans:
        found = moves_of(np.diff(reference[a:b]))
        pieces.append((a, found))
        breaks.add(count)
        count += len(found)
    return Moves(
        starts=np.concatenate([a + m.starts for a, m in pieces]),
        stops=np.concatenate([a + m.stops for a, m in pieces]),
        peaks=np.concatenate([a + m.peaks for a, m in pieces]),
        speeds=np.concatenate([m.speeds for _, m in pieces]),
    ), breaks


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
            shift = _shift(reference, int(moves.starts[j]), int(moves.starts[i]), int(lengths[j]))
            if shift is not None and shift[1] <= tolerance:
                kinds[i], shifts[i] = j, shift[0]
                break
    return kinds, shifts


def _shift(reference: Array, one: int, other: int, length: int) -> tuple[int, float] | None:
    """By how many samples another move is best shifted to be one, and how far it is off then."""
    own = reference[one + _ENDS : one + length - _ENDS]
    found = []
    for shift in _SHIFTS:
        begin = other + shift + _ENDS
        beside = reference[begin : begin + len(own)]
        if len(beside) == len(own) > 0:
            found.append((float(np.abs(beside - own).max()), abs(shift), shift))
    return (min(found)[2], min(found)[0]) if found else None


def _keys(moves: Moves, kinds: Index, breaks: set[int]) -> Iterator[tuple[int, int] | None]:
    """What each move is and what is before it; None where that is not known."""
    for i, kind in enumerate(kinds):
        if i in breaks:
            yield None  # how the record came there is not in it
        elif moves.starts[i] > moves.stops[i - 1]:
            yield int(kind), _REST
        else:
            yield int(kind), int(kinds[i - 1])


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
