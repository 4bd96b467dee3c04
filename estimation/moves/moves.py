"""Moves: stretches of motion about one largest speed, as long as it is not slow between."""

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


@dataclass(frozen=True, slots=True, kw_only=True)
class Moves:
    """Moves in the order of time.

    Attributes
    ----------
    starts, stops : (m,) array of int
        First sample of each, and the one after its last. One begins where the other ends, but for
        rests.
    peaks : (m,) array of int
        Where each is fastest.
    speeds : (m,) array
        There, with the sign of the direction.
    """

    starts: Index
    stops: Index
    peaks: Index
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
        peaks=peaks,
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
