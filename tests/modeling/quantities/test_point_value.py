"""Zeros are told from what is small, and dependence from what cancels, by values at points."""

import pytest
import sympy
from sympy import Abs, Heaviside, Max, Min, Piecewise, sign

from axisid.modeling.quantities.dependences import depends, vanishes
from axisid.modeling.quantities.point_value import value_at

p, q, r = sympy.symbols("p q r", real=True)


@pytest.mark.parametrize(
    "expression",
    [
        (p + 1) ** 2 - p**2 - 2 * p - 1,
        (p + 0.1) ** 2 - p**2 - 0.2 * p - 0.01,
        sympy.cosh(p) ** 2 - sympy.sinh(p) ** 2 - 1,
        Max(0, (q + 1) ** 2 - 3) - Max(0, q**2 + 2 * q - 2),
        Heaviside(q - p) + Heaviside(p - q) - 1,
        Piecewise((p, q < 0), (r, True)) - Piecewise((p, q < 0), (r, True)) * (r + 1 - r),
        sympy.sqrt(q**2 + 2 * q + 1) - Abs(q + 1),
        (q - p) ** 12 - sympy.expand((q - p) ** 12),
    ],
    ids=str,
)
def test_what_is_zero_everywhere_vanishes(expression: sympy.Expr) -> None:
    assert vanishes(expression)


@pytest.mark.parametrize(
    "expression",
    [
        (p + 1) ** 2 - p**2 - 2 * p - 1 + 1e-9 * p,
        1e-200 * p,
        Max(0, q - 1000),
        Min(0, q + 1000),
        Abs(q - 1000) + q - 1000,
        sign(q - 1000) + 1,
        Piecewise((0, q < 1000), (p, True)),
        sympy.exp(sympy.exp(sympy.exp(sympy.exp(sympy.exp(20 * q))))),
        sympy.log(sympy.Integer(0) * p, evaluate=False),
    ],
    ids=str,
)
def test_what_is_zero_in_places_or_unknown_does_not(expression: sympy.Expr) -> None:
    assert not vanishes(expression)


@pytest.mark.parametrize(
    ("expression", "on"),
    [
        ((p**2 + p * q) / p - p, {q}),
        (sign(p) * q, {p, q}),
        (Piecewise((1, p < 0), (2, True)) * q, {p, q}),
        (Max(0, q - 1000), {q}),
        (q + Abs(p) - Abs(p), {q}),
        ((q - p) ** 2 - q**2 + 2 * p * q, {p}),
        (sympy.exp(p) * sympy.exp(-p) * q, {q}),
    ],
    ids=lambda value: str(sorted(value, key=str) if isinstance(value, set) else value),
)
def test_dependence_is_told_from_what_cancels(
    expression: sympy.Expr, on: set[sympy.Symbol]
) -> None:
    assert {s for s in (p, q, r) if depends(expression, {s})} == on


def test_values_are_those_of_a_side() -> None:
    force = Piecewise((Max(q, p), q < 0), (Abs(q - p) * sign(r), q < 2), (Heaviside(q), True))
    for place, wanted in ((-1, 3), (1, -2), (2, 1)):
        assert value_at(force, {q: place, p: 3, r: -1}) == wanted
    with pytest.raises((ValueError, ArithmeticError)):
        value_at(1 / q, {q: 0})
    with pytest.raises(ValueError, match="not real"):
        value_at(sympy.log(q), {q: -1})
    with pytest.raises(ValueError, match="no value"):
        value_at(q * p, {q: 1})
