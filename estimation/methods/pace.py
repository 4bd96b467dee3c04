"""How far the instrumental-variable iteration goes at a time, and how near its end must be.

The next estimate follows from instruments that are simulated with the last one. Where the model
leaves much unexplained, a whole step may overshoot, and the iteration swings between two estimates
for ever: part of a step ends that, at the same estimate. Where each step is a steady part of the
last, what follows is known from two of them [Walker2011]_. And a loop that reverses thousands of
times jumps with the parameters, as reversals move from one sample to the next: then no estimate
follows from itself to the last digit.
"""

import numpy as np

from axisid.estimation.thresholds import CONVERGED
from axisid.support.arrays import Array

_ROUNDING = 1e-9  # of the value, which stands for the deviation in records without noise
_SWINGING = 0.5  # of the last step, backwards
_LEAST = 0.125
_NEAR = 0.5  # deviations, within which an estimate goes in proportion with the one before
_FALLING = 0.25  # of the last step, up to which what follows is told from the two
_FIRST = 3  # steps; those from the nominal values are of any size and direction


class Pace:
    """Steps of one iteration, in deviations."""

    def __init__(self) -> None:
        self.share, self._taken = 1.0, 0
        self._last: Array | None = None
        self._goal: Array | None = None

    def step(self, start: Array, goal: Array, deviation: Array) -> tuple[float, Array]:
        """Take note of a step between parameters (p,).

        `share` is then the part of it to go.

        Returns
        -------
        size : float
            In deviations, the largest of them.
        further : (p,) array
            Where the steps lead to, if they go on as they do: the goal, or beyond it.
        """
        unit = deviation + _ROUNDING / CONVERGED.value * np.abs(goal)
        moved = np.divide(goal - start, unit, out=np.zeros_like(goal), where=goal != start)
        self._taken += 1
        if self._last is not None and self._taken > _FIRST and self._swings(moved):
            self.share = max(self.share / 2, _LEAST)
        further = self._beyond(goal, moved)
        self._last, self._goal = moved, goal
        return float(np.abs(moved).max()), further

    def _beyond(self, goal: Array, moved: Array) -> Array:
        """The goal, or where it goes on to where steps fall steadily, from this and the last.

        By the secant through both, Anderson's method of depth one.
        """
        last, before = self._last, self._goal
        if last is None or before is None or self.share < 1:
            return goal
        size, other = (float(np.abs(each).max()) for each in (moved, last))
        ends = size * size <= CONVERGED.value * other  # the next step would be the last anyhow
        if ends or size > _NEAR or size > _FALLING * other:
            return goal
        change = moved - last
        return np.asarray(goal - float(moved @ change) / float(change @ change) * (goal - before))

    def _swings(self, moved: Array) -> bool:
        """Whether a step takes back the last one, and hardly shrinks."""
        last = self._last
        return (
            last is not None
            and float(moved @ last) < 0
            and float(np.linalg.norm(moved)) > _SWINGING * float(np.linalg.norm(last))
        )
