"""How often the force in base parameters is the declared force, on random axes that mislead.

    python benchmarks/derivations.py [--axes 1000] [--seed 1] [--json -]

An axis has friction with a knee at a velocity of 1e-6 to 1e-1 m/s, springs with knots as close as
1e-6 m, narrow windows, bells and steps, windows of what lags, of two places and of a wave, under
random names and in random order; every other one has a real dependence. The forces are compared in
floating point, by functions of the motion that are written here once more, at points that follow
from the knots and widths drawn. Counted are axes with a wrong force at any point, axes that are
refused, real dependences that were found, and those that were left as a doubt. A wrong force that
the program finds itself counts as wrong.
"""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import sympy
from figures import give, parser_of

from axisid import Constant, Coordinate, ModelError, Parameter, derive, newton
from axisid.elements import Drive
from axisid.modeling.quantities.symbols import DIRECTION

_WRONG = 1e-7  # share of the terms by which forces may differ, from rounding at a narrow window
_INSIDE = (0.02, 0.3, 0.7, 1.0, 1.7, 3.0, 30.0)  # distances from a place, in its widths
_OWN_ERROR = "an error of the program"  # as the guard of the derivation says
_NAMES = ("q", "x", "z", "pos", "phi", "arm", "slide", "y2")


@dataclass(frozen=True)
class Function:
    """A function of position and velocity, both without unit.

    Attributes
    ----------
    symbolic : callable
        As SymPy expression of both.
    number : callable
        As float of both.
    places, speeds : tuple of (float, float)
        Where it bends or jumps, and how wide that is, along the position and along the velocity.
    """

    symbolic: Callable[[Any, Any], Any]
    number: Callable[[float, float], float]
    places: tuple[tuple[float, float], ...] = ()
    speeds: tuple[tuple[float, float], ...] = ()


def _sign(value: float) -> float:
    return float(np.sign(value))


def _knee(s: float) -> list[Function]:
    speeds = ((0.0, s),)
    return [
        Function(lambda _q, v: sympy.tanh(v / s), lambda _q, v: math.tanh(v / s), (), speeds),
        Function(
            lambda _q, v: sympy.Min(1, abs(v) / s) * sympy.sign(v),
            lambda _q, v: min(1.0, abs(v) / s) * _sign(v),
            (),
            speeds,
        ),
        Function(
            lambda _q, v: sympy.exp(-((v / s) ** 2)) * sympy.sign(v),
            lambda _q, v: math.exp(-((v / s) ** 2)) * _sign(v),
            (),
            speeds,
        ),
        Function(
            lambda _q, v: sympy.Max(0, abs(v) - s) * sympy.sign(v),
            lambda _q, v: max(0.0, abs(v) - s) * _sign(v),
            (),
            ((0.0, s), (s, s), (-s, s)),
        ),
    ]


def _local(c: float, w: float) -> list[Function]:
    around = ((c, w),)
    window = ((c, w), (c - w, w), (c + w, w))
    return [
        Function(
            lambda q, _v: sympy.tanh((q - c) / w), lambda q, _v: math.tanh((q - c) / w), around
        ),
        Function(
            lambda q, _v: sympy.Max(0, 1 - abs(q - c) / w),
            lambda q, _v: max(0.0, 1 - abs(q - c) / w),
            window,
        ),
        Function(
            lambda q, _v: sympy.exp(-(((q - c) / w) ** 2)),
            lambda q, _v: math.exp(-(((q - c) / w) ** 2)),
            around,
        ),
        Function(
            lambda q, _v: sympy.Max(0, q - c) - sympy.Max(0, q - c - w),
            lambda q, _v: max(0.0, q - c) - max(0.0, q - c - w),
            ((c, w), (c + w, w)),
        ),
        Function(
            lambda q, v: sympy.Max(0, 1 - ((q - c) / w) ** 2) * v,
            lambda q, v: max(0.0, 1 - ((q - c) / w) ** 2) * v,
            window,
        ),
    ]


def _of_both(c: float, w: float, s: float) -> list[Function]:
    """Windows along the position that the velocity moves or opens, or that are there twice."""
    window = ((c, w), (c - w, w), (c + w, w))
    twice = (*window, *((c + 3 * w + x, w) for x in (-w, 0.0, w)))
    wide, turn = 1 + abs(c), 1 / (1 + abs(c))
    top = math.pi / 2 * wide  # of the wave below
    return [
        Function(
            lambda q, v: sympy.Max(0, 1 - abs(q - c - s * v) / w),
            lambda q, v: max(0.0, 1 - abs(q - c - s * v) / w),
            window,
        ),
        Function(
            lambda q, v: sympy.Max(0, 1 - abs(q - c) / w) * sympy.tanh(v / s),
            lambda q, v: max(0.0, 1 - abs(q - c) / w) * math.tanh(v / s),
            window,
            ((0.0, s),),
        ),
        Function(
            lambda q, _v: abs((q - c) * (q - c - 3 * w)),
            lambda q, _v: abs((q - c) * (q - c - 3 * w)),
            twice,
        ),
        Function(
            lambda q, _v: sympy.Max(0, sympy.sin(q * turn) - 1 + 1e-3),
            lambda q, _v: max(0.0, math.sin(q * turn) - 1 + 1e-3),
            ((top, 0.04 * wide),),
        ),
    ]


def _step(c: float) -> Function:
    return Function(
        lambda q, _v: (1 + sympy.sign(q - c)) / 2,
        lambda q, _v: (1 + _sign(q - c)) / 2,
        ((c, 1e-3),),
    )


def _hinge(c: float, side: float, w: float) -> Function:
    return Function(
        lambda q, _v: sympy.Max(0, side * (q - c)),
        lambda q, _v: max(0.0, side * (q - c)),
        ((c, w),),
    )


_SMOOTH = [
    Function(lambda _q, v: v, lambda _q, v: v),
    Function(lambda _q, v: sympy.sign(v), lambda _q, v: _sign(v)),
    Function(lambda _q, _v: sympy.S.One, lambda _q, _v: 1.0),
    Function(lambda q, _v: q, lambda q, _v: q),
    Function(lambda q, _v: q**2, lambda q, _v: q * q),
    Function(lambda q, _v: sympy.sin(q), lambda q, _v: math.sin(q)),
    Function(lambda q, _v: sympy.sin(3 * q), lambda q, _v: math.sin(3 * q)),
    Function(lambda _q, v: v * abs(v), lambda _q, v: v * abs(v)),
]


def _dependent(
    rng: np.random.Generator, drawn: Sequence[Function], c: float, w: float
) -> list[Function]:
    """Functions of which the last is a sum of the others, and of some that were drawn."""
    kind = int(rng.integers(5))
    if kind == 0 or len(drawn) < 2:
        one, factor = drawn[int(rng.integers(len(drawn)))], float(rng.choice([2.0, -0.5, 3.0]))
        return [
            Function(
                lambda q, v: factor * one.symbolic(q, v), lambda q, v: factor * one.number(q, v)
            )
        ]
    if kind == 1:
        one, two = (drawn[i] for i in rng.choice(len(drawn), 2, replace=False))
        return [
            Function(
                lambda q, v: one.symbolic(q, v) - 2 * two.symbolic(q, v),
                lambda q, v: one.number(q, v) - 2 * two.number(q, v),
            )
        ]
    hinges = [_hinge(c, 1.0, w), _hinge(c, -1.0, w)]
    if kind == 2:
        return [
            *hinges,
            Function(lambda q, _v: abs(q - c), lambda q, _v: abs(q - c), ((c, w),)),
        ]
    if kind == 3:
        return [*hinges, Function(lambda q, _v: q - c, lambda q, _v: q - c)]
    return [
        Function(lambda q, _v: sympy.cos(5 * q), lambda q, _v: math.cos(5 * q)),
        Function(lambda q, _v: sympy.sin(5 * q / 2) ** 2, lambda q, _v: math.sin(2.5 * q) ** 2),
        Function(lambda q, _v: sympy.cos(5 * q / 2) ** 2, lambda q, _v: math.cos(2.5 * q) ** 2),
    ]


def functions_of(rng: np.random.Generator) -> tuple[list[Function], int]:
    """Draw the functions of an axis, and how many of them are sums of others."""

    def size() -> float:
        return float(f"{10 ** rng.uniform(-6, -1):.3g}")

    def place() -> float:
        return float(f"{rng.uniform(-1, 1) * 10 ** rng.uniform(-1, 1):.6g}")

    drawn = [_SMOOTH[i] for i in rng.choice(len(_SMOOTH), int(rng.integers(1, 5)), replace=False)]
    knees = rng.choice(4, int(rng.integers(0, 3)), replace=False)
    drawn += [_knee(size())[i] for i in knees]
    centre = place()
    for i in rng.choice(5, int(rng.integers(0, 3)), replace=False):
        middle = centre if rng.random() < 0.5 else place()
        drawn += [_local(middle, size())[i]]
    if rng.random() < 0.3:
        drawn += [_of_both(centre, size(), size())[int(rng.integers(4))]]
    if rng.random() < 0.3:
        near, gap = place(), size()
        drawn += [_hinge(near, 1.0, gap), _hinge(near + gap, 1.0, gap)]
    if rng.random() < 0.3:
        near = place()
        drawn += [_step(near), _step(near + size())]
    dependent = 0
    if rng.random() < 0.5:
        drawn += _dependent(rng, drawn, place(), size())
        dependent = 1
    return drawn, dependent


def points_of(rng: np.random.Generator, functions: Sequence[Function]) -> list[tuple[float, float]]:
    """Positions and velocities around all places, between them, and over decades."""
    along: list[list[float]] = []
    for known in (
        [p for f in functions for p in f.places],
        [p for f in functions for p in f.speeds],
    ):
        ends = sorted({c for c, _ in known})
        values = [c + s * k * w for c, w in known for k in _INSIDE for s in (1, -1)]
        values += [(a + b) / 2 for a, b in pairwise(ends)]
        values += [s * 10**k for k in rng.uniform(-9, 2, 8) for s in (1, -1)]
        along.append(values)
    places, speeds = along
    both = [(q, float(rng.choice(speeds))) for q in places]
    return both + [(float(rng.choice(places)), v) for v in speeds]


@dataclass(frozen=True)
class Outcome:
    """What became of one axis."""

    wrong: float  # largest difference of the forces, as a share of the terms
    refused: str
    dependent: int
    found: int
    doubts: int
    seconds: float


def tried(seed: int) -> Outcome:
    """Draw an axis and derive it."""
    rng = np.random.default_rng(seed)
    functions, dependent = functions_of(rng)
    q = Coordinate(str(rng.choice(_NAMES)))
    names = [f"{letter}{i}" for i, letter in enumerate(rng.choice(list("abcdkrsw"), 20))]
    forces = [Parameter(name, "N", nominal=1.0) for name in names[: len(functions)]]
    mass = Parameter("M", "kg", nominal=1.0)
    place, speed = q.symbol / Constant(1.0, "m"), q.velocity / Constant(1.0, "m/s")
    order = [int(i) for i in rng.permutation(len(functions))]
    axis = newton(
        "drawn",
        coordinate=q,
        parameters=[mass, *(forces[i] for i in order)],
        inertia=mass,
        resistance=[forces[i] * functions[i].symbolic(place, speed) for i in range(len(forces))],
        drive=Drive(gain=1.0),
    )
    begun = time.process_time()
    try:
        model = derive(axis)
    except ModelError as error:
        wrong = math.inf if _OWN_ERROR in str(error) else 0.0
        return Outcome(wrong, str(error), dependent, 0, 0, time.process_time() - begun)
    seconds = time.process_time() - begun
    motion = (q.symbol, q.velocity, q.acceleration, DIRECTION)
    row = sympy.lambdify(motion, model.idm.columns, "math")
    theta = {p.name: float(rng.uniform(0.5, 2.0) * rng.choice([-1, 1])) for p in (mass, *forces)}
    beta = model.base.at([theta[p.name] for p in model.base.declared.parameters])
    wrong = 0.0
    for position, velocity in points_of(rng, functions):
        acceleration = float(rng.normal())
        terms = [theta["M"] * acceleration]
        terms += [
            theta[p.name] * f.number(position, velocity)
            for p, f in zip(forces, functions, strict=True)
        ]
        columns = row(position, velocity, acceleration, _sign(velocity))
        force = math.fsum(b * x for b, x in zip(beta, columns, strict=True))
        wrong = max(wrong, abs(force - math.fsum(terms)) / math.fsum(map(abs, terms)))
    merged, doubts = len(forces) + 1 - len(beta), len(model.base.undecided)
    return Outcome(wrong, "", dependent, merged, doubts, seconds)


def main() -> None:
    """Print what was counted, or write it as a JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--axes", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    seeds = [1_000_000 * given.seed + i for i in range(given.axes)]
    outcomes = {seed: tried(seed) for seed in seeds}
    wrong = {seed: each.wrong for seed, each in outcomes.items() if each.wrong > _WRONG}
    refused = {seed: each.refused for seed, each in outcomes.items() if each.refused}
    found = {
        "axes": len(seeds),
        "wrong forces": len(wrong),
        "largest error of a wrong force": max(wrong.values(), default=0.0),
        "refused": len(refused),
        "dependences": sum(each.dependent for each in outcomes.values()),
        "dependences found": sum(min(o.found, o.dependent) for o in outcomes.values()),
        "dependences left as a doubt": sum(
            o.found < o.dependent and o.doubts > 0 for o in outcomes.values()
        ),
        "axes with a doubt": sum(o.doubts > 0 for o in outcomes.values()),
        "seeds of wrong forces": list(wrong)[:10],
        "seeds of dependences not found": [
            seed for seed, o in outcomes.items() if o.found < o.dependent and not o.refused
        ][:10],
        "CPU seconds": round(sum(each.seconds for each in outcomes.values()), 1),
    }
    lines = (f"{name:<32} {value}" for name, value in found.items())
    give(found, given.json, [*lines, *(f"{seed}: {said}" for seed, said in refused.items())])


if __name__ == "__main__":
    main()
