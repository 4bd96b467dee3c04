"""Functions of the motion are told apart by their values, wherever each has something to show."""

import pytest
import sympy
from sympy import (
    Abs,
    And,
    Eq,
    Heaviside,
    Max,
    Min,
    Not,
    Or,
    Piecewise,
    Rational,
    acos,
    atan,
    cos,
    cosh,
    exp,
    log,
    sign,
    sin,
    sinh,
    sqrt,
    tanh,
)

from axisid.modeling.derivation.motions import independent
from axisid.modeling.quantities.symbols import DIRECTION as D
from tests.bounded import within
from tests.refusals import refuses

q, dq, a, b, c = sympy.symbols("q dq a b c", real=True)
HALF = Rational(1, 2)
ONE = sympy.S.One


def rank(*functions: sympy.Expr) -> int:
    return len(independent(list(map(sympy.sympify, functions)), dq, {}, positive={a, b, c}))


ALIKE = {
    "squares of waves": (sympy.sin(q) ** 2 + sympy.cos(q) ** 2, 1),
    "a product of waves": (sympy.sin(2 * q), 2 * sympy.sin(q) * sympy.cos(q)),
    "a power of a wave": (sympy.cos(q) ** 3, (3 * sympy.cos(q) + sympy.cos(3 * q)) / 4),
    "sines of two angles": (
        2 * sympy.sin(a * q) * sympy.sin(b),
        sympy.cos(a * q - b) - sympy.cos(a * q + b),
    ),
    "a phase": (
        sympy.sin(q + HALF),
        sympy.sin(q) * sympy.cos(HALF) + sympy.cos(q) * sympy.sin(HALF),
    ),
    "a turned phase": (
        sympy.cos(HALF - q),
        sympy.cos(q) * sympy.cos(HALF) + sympy.sin(q) * sympy.sin(HALF),
    ),
    "a modulus by its sign": (Abs(dq), D * dq),
    "a square of a modulus": (Abs(q - 1) ** 2, q**2 - 2 * q + 1),
    "a modulus times its sign": (Abs(q - 1) * sign(1 - q), 1 - q),
    "a root of a modulus": (sympy.sqrt(Abs(dq)) * dq, Abs(dq) ** Rational(3, 2) * D),
    "a power of a product": (Abs(q * dq) ** HALF, sympy.sqrt(Abs(q)) * sympy.sqrt(Abs(dq))),
    "signs multiply": (sign(3 * q * dq), sign(q) * D),
    "a square of a direction": (D**2, 1),
    "a step by the direction": (Heaviside(dq), (1 + D) / 2),
    "a sum in an exponent": (sympy.exp(q + 1), sympy.E * sympy.exp(q)),
    "a narrow bell": (sympy.exp(-(((q - 2) / 1e-3) ** 2)), sympy.exp(-(((2 - q) / 1e-3) ** 2))),
    "a power of a known base": (3 ** (q + 2 * a), 9**a * 3**q),
    "a power of a sum": ((1 + q) ** (a + 1), (1 + q) ** a * (1 + q)),
    "a broken power": ((q + 1) ** Rational(3, 2), sympy.sqrt(q + 1) * (q + 1)),
    "a factor under a root": (sympy.sqrt(4 * q + 8), 2 * sympy.sqrt(q + 2)),
    "a factor of a divisor": (1 / (2 * q + 2), 1 / (q + 1) / 2),
    "a root of a square": (sympy.sqrt(q**2 * (1 + a**2)), Abs(q) * sympy.sqrt(1 + a**2)),
    "a factor in a logarithm": (
        sympy.log(2 * (1 + q**2)),
        sympy.log(2, evaluate=False) + sympy.log(1 + q**2),
    ),
    "an argument": (Max(0, (q + 1) ** 2 - 3), Max(0, q**2 + 2 * q - 2)),
    "the order of arguments": (Min(a * (q + 1), b), Min(b, a * q + a)),
    "odd functions": (
        sympy.tanh(a - q) + sympy.atan(1 - b),
        -sympy.tanh(q - a) - sympy.atan(b - 1),
    ),
    "even functions": (sympy.cosh(a - q), sympy.cosh(q - a)),
    "a choice by a step": (Piecewise((a, q < 0), (b, True)), b + (a - b) * Heaviside(-q)),
    "a choice by the velocity": (
        Piecewise((a, dq < 0), (b, True)),
        (a + b) / 2 + (b - a) * D / 2,
    ),
    "two conditions": (
        Piecewise((1, And(q > 0, q < 3)), (0, True)),
        Heaviside(q) * Heaviside(3 - q),
    ),
    "one of two conditions": (
        Piecewise((a, Or(q < 0, q > 3)), (b, True)),
        Piecewise((b, And(q >= 0, q <= 3)), (a, True)),
    ),
    "the other way round": (
        Piecewise((a, Not(q < 1, evaluate=False)), (b, True)),
        Piecewise((b, q < 1), (a, True)),
    ),
    "equal or not": (
        Piecewise((a, Eq(sign(q), sign(b))), (c, True)),
        Piecewise((c, sympy.Ne(sign(q), sign(b))), (a, True)),
    ),
    "many pieces": (
        a * Piecewise(*[(i * q, q < i) for i in range(30)], (q**2, True)),
        Piecewise(*[(i * a * q, 2 * q < 2 * i) for i in range(30)], (a * q**2, True)),
    ),
    "one part of many pieces twice": (
        Piecewise(*[(i, q < i) for i in range(9)], (0, True)) ** 2,
        Piecewise(*[(i**2, q < i) for i in range(9)], (0, True)),
    ),
    "what cancels": (
        (a + b + c) ** 5 * (a - b) ** 2,
        sympy.expand((a + b + c) ** 5 * (a - b) ** 2),
    ),
}


@pytest.mark.parametrize("name", ALIKE)
def test_the_same_function_is_one(name: str) -> None:
    assert rank(*ALIKE[name]) == 1


UNLIKE = [
    (Abs(q), q),
    (sympy.sqrt(q**2 + 1), sympy.sqrt(q**2)),
    (sympy.exp(q), sympy.exp(2 * q)),
    (Max(0, q), Max(0, 2 * q - 1)),
    (Piecewise((a, q < 0), (b, True)), Piecewise((a, q < 1), (b, True))),
    (
        Piecewise(*[(i, q < i) for i in range(9)], (0, True)),
        Piecewise(*[(i, q < 2 * i) for i in range(9)], (0, True)),
    ),
    (q**0.333, sympy.cbrt(q)),
    (sympy.sin(a * q), sympy.sin(b * q)),
    (sympy.atan2(q, dq), sympy.atan2(dq, q)),
]


@pytest.mark.parametrize(("one", "other"), UNLIKE, ids=str)
def test_different_functions_are_two(one: sympy.Expr, other: sympy.Expr) -> None:
    assert rank(one, other) == 2


def piece(condition: sympy.Basic) -> sympy.Expr:
    return Piecewise((1, condition), (0, True))


BELL = exp(-(((q - 2) / 1e-3) ** 2))
POWERS = [q**i for i in range(9)]
RANKS = {
    "a narrow piece": ((dq, piece(And(q > 0.35, q < 0.36)), ONE), 3),
    "an edge far away": ((piece(q < 5000), ONE), 2),
    "a steep step": ((tanh(dq / 1e-4), D), 2),
    "a steep step elsewhere": ((tanh((q - 0.35) / 1e-4), ONE), 2),
    "a narrow bell and what it leaves": ((BELL, 1 - BELL, ONE), 2),
    "two narrow bells": ((BELL, exp(-(((q - 3) / 1e-3) ** 2)), 1 - BELL), 3),
    "a hinge in a hinge": ((Max(0, Max(0, q - 1) - 0.5), Max(0, q - 1.5)), 1),
    "a domain that is small": ((sqrt(0.09 - q**2), q), 2),
    "a domain that is far away": ((acos((q - 500) / 0.01), q), 2),
    "two steps beside each other": ((atan(1e6 * (q - 7)), atan(1e6 * (q - 7.00001))), 2),
    "numbers beyond floating point": ((exp(1.5 * q - 15000), exp(1.5 * q)), 1),
    "a hinge that is nearly sharp": ((log(1 + exp(3000 * q)), Max(0, q)), 2),
    "a power by all but one of its terms": (((q - 900) ** 8, *POWERS[:-1]), 9),
    "a power by its terms": (((q - 900) ** 8, *POWERS), 9),
    "many pieces": ((*(piece(And(q > i, q < i + 1)) for i in range(20)), ONE), 21),
    "exponentials": ((exp(9 * q), exp(18 * q), exp(-9 * q), ONE, cosh(9 * q)), 4),
    "a modulus and a hinge": ((q, q**2, q * Max(0, q - 1), q * Abs(q - 1)), 3),
    "a sum and what grows far beyond it": (
        (cos(q) ** 2, cos(q) ** 2 / 3 - sinh(q) * cosh(q), sinh(q) * cosh(q), Abs(q - 1)),
        3,
    ),
    "what grows and what falls": (
        (3 * exp(-2 * dq**2) * sinh(q), dq * Abs(dq) + q**3 * sinh(q), exp(-3 * dq**2) * D),
        3,
    ),
    "a phase": ((sin(1000 * q), cos(1000 * q), sin(1000 * q + 0.5)), 2),
}


@pytest.mark.parametrize("name", RANKS)
def test_as_many_are_independent_as_there_are_motions_to_show_it(name: str) -> None:
    functions, wanted = RANKS[name]
    assert rank(*functions) == wanted


@pytest.mark.parametrize(("share", "wanted"), [("1e-8", 2), ("1e-16", 1)])
def test_what_rounding_may_have_left_is_nothing(share: str, wanted: int) -> None:
    assert rank(sin(q), sin(q) * (1 + sympy.Float(share) * cos(q))) == wanted


def test_what_neither_rounding_left_nor_a_record_shows_is_refused() -> None:
    with refuses("nearly-dependent"):
        rank(sin(q), sin(q) + sympy.Rational("1e-30") * sin(q) * cos(q))


@pytest.mark.parametrize(
    "function", [sympy.I * q, acos(2 + q**2), log(-(dq**2)), sqrt(-1 - dq**2)], ids=str
)
def test_what_is_real_at_no_motion_is_said(function: sympy.Expr) -> None:
    with refuses("no-real-number"):
        rank(function)


def test_what_would_take_for_ever_is_refused() -> None:
    with within(1_000_000), refuses("too-many-terms"):
        rank(*(sin(i * q) for i in range(1, 400)))
