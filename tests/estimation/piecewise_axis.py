"""The closed form of a mass on a force that is piecewise linear over the position.

``M ddq = tau - Fv dq - Fc sign(dq) - (k q + c)`` with a stiffness k and a constant c of their own
between any two edges; the force may have a kink or jump at an edge. An oracle that shares nothing
with the program: between events the motion is a sum of exponentials or a damped oscillation, the
next reversal is a logarithm or an arc tangent, and an edge is a root of the closed form.
"""

import cmath
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

_CAUGHT = 1e-13  # m: how far beyond an edge a motion that is drawn back counts as at rest in it


@dataclass(frozen=True)
class PiecewiseAxis:
    """`pieces` are (k, c) from left to right, one more than `edges`."""

    M: float
    Fv: float
    Fc: float
    edges: Sequence[float]
    pieces: Sequence[tuple[float, float]]

    def push(self, piece: int, q: float, tau: float) -> float:
        """Force at rest, but for friction."""
        k, c = self.pieces[piece]
        return tau - k * q - c

    def piece_at(self, q: float, ahead: float) -> int:
        """The piece of a position; that ahead where it is an edge."""
        piece = sum(q > edge for edge in self.edges)
        return piece + (ahead > 0) * (q in self.edges)

    def advance(self, q: float, dq: float, tau: float, span: float) -> tuple[float, float]:
        """Position and velocity after `span` seconds of the force `tau`."""
        while span > 0:
            forward = self.push(self.piece_at(q, 1.0), q, tau) - self.Fc
            backward = self.push(self.piece_at(q, -1.0), q, tau) + self.Fc
            nearly = q in self.edges and dq**2 * self.M / 2 < _CAUGHT * min(-forward, backward)
            if (dq == 0 or nearly) and forward <= 0 <= backward:
                return q, 0.0
            s = math.copysign(1.0, dq) if dq else 1.0 if forward > 0 else -1.0
            q, dq, taken = self._to_event(q, dq, s, tau, span)
            span -= taken
        return q, dq

    def _to_event(
        self, q: float, dq: float, s: float, tau: float, span: float
    ) -> tuple[float, float, float]:
        """Move to the next reversal or edge, or to the end of the span."""
        piece = self.piece_at(q, s)
        k, _ = self.pieces[piece]
        push = self.push(piece, q, tau) - s * self.Fc
        way, speed, stop = _free_motion(self.M, self.Fv, k, push, dq)
        t = min(span, stop)
        edge = piece if s > 0 else piece - 1
        if 0 <= edge < len(self.edges):
            room = self.edges[edge] - q
            if (way(t) - room) * s > 0:
                t = brentq(lambda t: (way(t) - room) * s, 0.0, t, xtol=1e-18, rtol=1e-15)
                return self.edges[edge], speed(t), t
        return q + way(t), 0.0 if t == stop else speed(t), t


Motion = Callable[[float], float]


def _free_motion(
    M: float, b: float, k: float, push: float, v: float
) -> tuple[Motion, Motion, float]:
    """Way and speed over time of ``M ddx = push - b dx - k x``, and its first reversal."""
    if k == 0:
        return _without_stiffness(M, b, push, v)
    rest, root = push / k, cmath.sqrt(b * b - 4 * M * k)
    first, second = (-b + root) / (2 * M), (-b - root) / (2 * M)
    one = (v + second * rest) / (first - second)
    two = -rest - one

    def way(t: float) -> float:
        # expm1 keeps small ways exact
        return ((one * _expm1(first * t)) + two * _expm1(second * t)).real

    def speed(t: float) -> float:
        return (one * first * cmath.exp(first * t) + two * second * cmath.exp(second * t)).real

    return way, speed, _reversal(one * first, two * second, first, second, at_rest=v == 0)


def _expm1(z: complex) -> complex:
    """exp(z) - 1 without cancellation."""
    half = math.sin(z.imag / 2)
    grown = math.expm1(z.real)
    return complex(grown * math.cos(z.imag) - 2 * half * half, math.exp(z.real) * math.sin(z.imag))


def _reversal(a: complex, b: complex, r: complex, s: complex, *, at_rest: bool) -> float:
    """First positive zero of ``a exp(r t) + b exp(s t)``."""
    if r.imag == 0:
        share = (-b / a).real if a else 0.0
        t = math.log(share) / (r - s).real if share > 0 else 0.0
        return t if t > 0 and not at_rest else math.inf
    # 2 |a| exp(re t) cos(im t + angle), at a zero of the cosine
    angle = cmath.phase(a)
    turns = 0 if at_rest else math.ceil((angle - math.pi / 2) / math.pi + 1e-15)
    t = (math.pi / 2 + math.pi * turns - angle) / r.imag
    while t <= (1e-9 / r.imag if at_rest else 0.0):
        t += math.pi / r.imag
    return t


def _without_stiffness(M: float, b: float, push: float, v: float) -> tuple[Motion, Motion, float]:
    if b == 0:
        a = push / M
        stop = -v / a if v * a < 0 else math.inf
        return (lambda t: v * t + a * t * t / 2), (lambda t: v + a * t), stop
    steady, rate = push / b, b / M
    stop = math.log((v - steady) / -steady) / rate if v * steady < 0 else math.inf
    return (
        lambda t: steady * t - (v - steady) * math.expm1(-rate * t) / rate,
        lambda t: v + (v - steady) * math.expm1(-rate * t),
        stop,
    )


def closed_loop(
    axis: PiecewiseAxis,
    law: Callable[[float, float, float], float],
    reference: np.ndarray,
    period: float,
) -> np.ndarray:
    """Positions under a sampled law of reference, position and velocity, from rest."""
    q, dq, positions = float(reference[0]), 0.0, []
    for r in reference:
        positions.append(q)
        q, dq = axis.advance(q, dq, law(r, q, dq), period)
    return np.array(positions)
