"""What the bounds of size admit is derived and written down in seconds."""

from collections.abc import Callable

import pytest
import sympy
from sympy import Abs, Heaviside, Max, Min, Piecewise, cos, cosh, exp, log, sign, sin, tanh

from axisid import (
    Axis,
    Constant,
    ModelError,
    Parameter,
    derive,
)
from axisid.presentation.documents.axis_page import axis_page
from tests.axes.bodies import energetic, rotor, turn
from tests.bounded import within

_CALLS = 40_000_000  # of functions

x, v = turn.symbol, turn.velocity * Constant(1.0, "s").symbol
PURE = [Parameter(f"p{i}", "1", nominal=1.0 + i) for i in range(60)]
FORCES = [Parameter(f"c{i}", "N m", nominal=1.0 + i) for i in range(60)]
P, C = ([p.symbol for p in group] for group in (PURE, FORCES))
UNIT = Constant(1.0, "N m").symbol


def axis(*resistance: sympy.Expr) -> Axis:
    return rotor(*resistance, parameters=(*PURE, *FORCES), name="t")


def stored(energy: sympy.Expr) -> Axis:
    return energetic(parameters=(*PURE, *FORCES), potential=energy, name="t")


def nested(levels: int, step: Callable[[sympy.Expr, int], sympy.Expr]) -> sympy.Expr:
    inner = x
    for i in range(levels):
        inner = step(inner, i)
    return inner


def energy_of_hinges(levels: int) -> Axis:
    """By levels, its slope has some five times as many terms."""
    grown = nested(levels, lambda e, i: Max(0, e - sympy.Rational(i, 7)) * (1 + e))
    return stored(C[0] * grown**2 / 2)


ADMITTED: dict[str, Callable[[], Axis]] = {
    "powers of sums of parameters": lambda: axis(
        C[0] * (P[0] + P[1] + P[2]) ** 8 * x, C[1] * (P[3] + P[4]) ** 12 * v
    ),
    "products of powers of sums": lambda: axis(C[0] * ((P[0] + P[1]) * (P[2] + P[3])) ** 20 * x),
    "powers of sums of all": lambda: axis(C[0] * (x + v * P[0] + P[1]) ** 12, C[1] * x),
    "a logarithm of a broken power": lambda: axis(C[0] * log(cosh(Abs(x) ** 0.333333333333333))),
    "broken powers of broken powers": lambda: axis(
        C[0] * cosh(Abs(x) ** 0.123456789012345) ** 0.333333333333333 * tanh(v / P[0])
    ),
    "powers of waves": lambda: axis(C[0] * sin(x) ** 20 * cos(x) ** 20, C[1] * sin(x)),
    "many waves": lambda: axis(*(C[i] * sin((i + 1) * x) * cos(x) * sin(2 * x) for i in range(40))),
    "many bends": lambda: axis(*(C[i] * tanh(v / P[i]) for i in range(30))),
    "many hinges": lambda: axis(*(C[i] * Max(0, x - P[i]) for i in range(30))),
    "many products": lambda: axis(
        *(UNIT * (P[i] + P[i + 1]) * (P[i + 2] - P[i + 3]) * sin((i + 1) * x) for i in range(30))
    ),
    "many pieces": lambda: axis(
        UNIT * Piecewise(*[(x * P[i], x < i) for i in range(40)], (x * P[40], True))
    ),
    "Max in Max": lambda: axis(
        C[0] * nested(6, lambda e, i: Max(P[i], e * (i + 1) / 2 - sympy.Rational(3 * i, 10)))
    ),
    "Max beside Max": lambda: axis(C[0] * nested(6, lambda e, i: Max(0, e - P[i]) + e / 3)),
    "Max of three": lambda: axis(C[0] * nested(5, lambda e, i: Max(e, P[i] - e, i))),
    "Min of Max": lambda: axis(C[0] * nested(5, lambda e, i: Min(Max(0, e), P[i] - e))),
    "Abs in Abs": lambda: axis(C[0] * nested(12, lambda e, i: Abs(e - P[i]))),
    "an energy of Max of three": lambda: stored(
        C[0] * nested(5, lambda e, i: Max(e, P[i] - e, i)) ** 2 / 2
    ),
    "choices in choices": lambda: axis(
        C[0] * nested(5, lambda e, i: Piecewise((e, x < i), (P[i] - e, True)))
    ),
    "products of steps": lambda: axis(
        C[0] * sympy.prod(Heaviside(x - i) * P[i] for i in range(9)),
        C[1] * sympy.prod(sign(x - i) for i in range(9)),
    ),
    "roots in roots": lambda: axis(C[0] * nested(9, lambda e, i: sympy.sqrt(1 + e**2 * P[i] ** 2))),
    "powers in powers": lambda: axis(
        C[0] * nested(6, lambda e, i: (1 + P[i] ** 2 + cos(x) ** 2) ** (e / 5))
    ),
    "products of many choices": lambda: axis(
        C[0] * sympy.prod(Piecewise((x, x < j), (v, True)) for j in range(9)),
        C[1] * sympy.prod(Piecewise((x, x < j), (v + j, True)) for j in range(9)),
    ),
    "the force of an energy of Max in Max": lambda: energy_of_hinges(6),
    "bells of many widths": lambda: axis(
        *(C[i] * exp(-((Abs(v) / P[i]) ** P[i + 10])) * sign(v) for i in range(10))
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", ADMITTED)
def test_what_is_admitted_is_derived_and_shown_in_time(name: str) -> None:
    declared = ADMITTED[name]()
    with within(_CALLS):
        try:
            page = axis_page(derive(declared))
        except ModelError as refusal:
            assert "jumps with" in str(refusal)  # an energy with a bend in a parameter
        else:
            assert "Inverse regressor" in page
