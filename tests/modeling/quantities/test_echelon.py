"""What algebra makes the same function is the same at points, and other functions are not."""

import pytest
import sympy
from hypothesis import given, settings, strategies as st
from sympy import Abs, And, Eq, Heaviside, Max, Min, Not, Or, Piecewise, Rational, sign

from axisid.modeling.quantities import reduced_functions
from axisid.modeling.quantities.symbols import DIRECTION as D

q, dq, a, b, c = sympy.symbols("q dq a b c", real=True)
HALF = Rational(1, 2)


def alike(one: sympy.Expr, other: sympy.Expr) -> bool:
    """Whether a motion tells nothing of what multiplies the difference of two functions."""
    return not reduced_functions([sympy.sympify(one) - other], dq)[0]


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
def test_the_same_function_is_the_same_at_points(name: str) -> None:
    assert alike(*ALIKE[name])


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
    (q**0.333333333333333, sympy.cbrt(q)),
    (sympy.sin(a * q), sympy.sin(b * q)),
    (sympy.atan2(q, dq), sympy.atan2(dq, q)),
]


@pytest.mark.parametrize(("one", "other"), UNLIKE, ids=str)
def test_different_functions_differ_at_points(one: sympy.Expr, other: sympy.Expr) -> None:
    assert not alike(one, other)


POLYNOMIALS = st.recursive(
    st.sampled_from([q, dq, a, b, sympy.Integer(2), Rational(-1, 3), sympy.sin(q), Abs(dq)]),
    lambda inner: st.one_of(
        st.tuples(inner, inner).map(lambda t: t[0] + t[1]),
        st.tuples(inner, inner).map(lambda t: t[0] * t[1]),
        st.tuples(inner, st.integers(2, 4)).map(lambda t: t[0] ** t[1]),
    ),
    max_leaves=7,
)


@settings(max_examples=60)
@given(POLYNOMIALS)
def test_multiplying_out_by_sympy_changes_no_value(expression: sympy.Expr) -> None:
    assert alike(expression, sympy.expand(expression))
