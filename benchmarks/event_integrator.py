"""An integrator of a mass with friction, stops and jumps that shares nothing with the program.

The midpoint rule of Gragg, extrapolated to tenth order (Bulirsch and Stoer), with steps of its own
choice; reversals and places where the force has a kink or jumps are found by Brent's method.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from scipy.optimize import brentq

State = tuple[float, float]  # position and velocity
Slope = Callable[[float, float, float], float]  # acceleration of time, position and velocity
Force = Callable[[float, float, float], float]  # the drive's, of the same
#: Acceleration of position, velocity, force, friction direction and sides.
Acceleration = Callable[[float, float, float, float, Sequence[float]], float]

_COUNTS = (2, 4, 6, 8, 10)
_EXACT = 1e-13  # by how much the last extrapolation may change a step's end
_SHORTEST = 1e-6  # of a span
_CAUGHT = 1e-7  # m/s: slower than this an axis rests in a place that draws it back from both sides


@dataclass
class EventIntegrator:
    """One axis.

    Attributes
    ----------
    acceleration : callable
    q, v : float
        Position and velocity.
    places : tuple of float
        Where the force has a kink or jumps.
    sides : list of float
        On which side of each the axis is; 0 where it rests in one.
    """

    acceleration: Acceleration
    q: float
    places: Sequence[float] = ()
    v: float = 0.0
    sides: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.sides = [math.copysign(float(self.q != x), self.q - x) for x in self.places]

    def direction_at_rest(self, tau: float) -> float:
        """In which the axis leaves; 0 if it sticks."""
        ahead, behind = ([side or s for side in self.sides] for s in (1.0, -1.0))
        if self.acceleration(self.q, 0.0, tau, 1.0, ahead) > 0:
            return 1.0
        return -1.0 if self.acceleration(self.q, 0.0, tau, -1.0, behind) < 0 else 0.0

    def advance(self, force: Force, span: float, *, held: bool) -> None:
        """Move on under a force; `held` says that it is the same all the time."""
        at = 0.0
        while at < span:
            s = math.copysign(1.0, self.v)
            if self.v == 0:
                s = self.direction_at_rest(force(at, self.q, 0.0))
            if s == 0:
                at = span if held else self._leaving(force, at, span)
                continue
            self.sides = [side or s for side in self.sides]
            left = span - at
            taken = self._to_event(force, s, at, left)
            at = span if taken == left else at + taken

    def _leaving(self, force: Force, at: float, span: float) -> float:
        """Time at which an axis at rest no longer sticks."""

        def sticks(t: float) -> bool:
            return self.direction_at_rest(force(t, self.q, 0.0)) == 0

        if sticks(span):
            return span
        low, high = at, span
        while low < (middle := (low + high) / 2) < high:
            low, high = (middle, high) if sticks(middle) else (low, middle)
        return high

    def _to_event(self, force: Force, s: float, at: float, left: float) -> float:
        """Move until a reversal, a place or the end; the time that it takes."""
        sides, start, span = tuple(self.sides), (self.q, self.v), left

        def slope(t: float, q: float, v: float) -> float:
            return self.acceleration(q, v, force(at + t, q, v), s, sides)

        (q, v), error = _extrapolated(slope, start, span)
        while error > _EXACT and span > _SHORTEST * left:
            span /= 2
            (q, v), error = _extrapolated(slope, start, span)
        if v * s < 0:
            span = _root(slope, start, span, lambda _, v: v * s)
            q, v = _extrapolated(slope, start, span)[0][0], 0.0
        for i, (x, side) in enumerate(zip(self.places, sides, strict=True)):
            if (q - x) * side < 0:
                span = _root(slope, start, span, lambda q, _, x=x, side=side: (q - x) * side)
                self.q, self.v = _extrapolated(slope, start, span)[0]
                self._pass(i, force(at + span, self.q, self.v))
                return span
        self.q, self.v = q, v
        return span

    def _pass(self, index: int, tau: float) -> None:
        """Onto the other side of a place, or at rest in it where both sides draw it back."""
        before = self.sides[index]
        self.sides[index] = 0.0
        if abs(self.v) < _CAUGHT and self.direction_at_rest(tau) == 0:
            self.q, self.v = self.places[index], 0.0
        else:
            self.sides[index] = -before


def _extrapolated(slope: Slope, start: State, span: float) -> tuple[State, float]:
    """Where a step ends, and how much the last extrapolation changed that."""
    rows: list[list[State]] = []
    for i, count in enumerate(_COUNTS):
        row = [_midpoints(slope, start, span, count)]
        for j in range(i):
            weight = 1 / ((count / _COUNTS[i - j - 1]) ** 2 - 1)
            (q, v), (q0, v0) = row[j], rows[i - 1][j]
            row.append((q + weight * (q - q0), v + weight * (v - v0)))
        rows.append(row)
    (q, v), (other, slower) = rows[-1][-1], rows[-1][-2]
    return (q, v), max(abs(q - other), abs(v - slower) * span)


def _midpoints(slope: Slope, start: State, span: float, count: int) -> State:
    """Gragg's midpoint rule in so many steps."""
    h, (q0, v0) = span / count, start
    q1, v1 = q0 + h * v0, v0 + h * slope(0.0, q0, v0)
    for i in range(1, count):
        a = slope(i * h, q1, v1)
        q0, v0, q1, v1 = q1, v1, q0 + 2 * h * v1, v0 + 2 * h * a
    a = slope(span, q1, v1)
    return (q1 + q0 + h * v1) / 2, (v1 + v0 + h * a) / 2


def _root(slope: Slope, start: State, span: float, value: Callable[[float, float], float]) -> float:
    """First time at which a value is no longer positive; by `span` it is not."""

    def of(t: float) -> float:
        return value(*_extrapolated(slope, start, t)[0])

    low = span * 1e-9  # at the very start it may be zero
    return low if of(low) <= 0 else float(brentq(of, low, span, xtol=1e-18, rtol=1e-15))
