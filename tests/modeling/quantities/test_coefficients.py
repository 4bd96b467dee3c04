"""Coefficients of parameters, and numbers of exponents."""

import math

import pytest
import sympy
from hypothesis import given, settings, strategies as st

from axisid.modeling.quantities import joined_exponential
from axisid.modeling.quantities.coefficients import Coefficients
from axisid.modeling.quantities.dependences import depends, vanishes

a, b, q = sympy.symbols("a b q", real=True)


def test_the_functions_of_the_motion_stay_as_they_were_written() -> None:
    force = a * (q - 2) ** 12 + (a + b) ** 2 * sympy.exp(q + 1) + (q - 3) ** 5
    found = Coefficients(force, (a, b)).terms
    assert found[1, 0] == (q - 2) ** 12
    assert found[1, 1] == 2 * sympy.exp(q + 1)
    assert found[0, 2] == sympy.exp(q + 1)
    assert found[0, 0] == (q - 3) ** 5
    assert len(found) == 5


TERMS = st.recursive(
    st.sampled_from([a, b, q, sympy.cos(q), sympy.Integer(3)]),
    lambda inner: st.one_of(
        st.tuples(inner, inner).map(sum),
        st.tuples(inner, inner).map(lambda t: t[0] * t[1]),
        st.tuples(inner, st.integers(2, 3)).map(lambda t: t[0] ** t[1]),
    ),
    max_leaves=6,
)


@settings(max_examples=50)
@given(TERMS)
def test_coefficients_are_those_of_the_polynomial(expression: sympy.Expr) -> None:
    found = Coefficients(expression, (a, b)).terms
    for powers, weight in sympy.Poly(sympy.expand(expression), a, b).terms():
        assert sympy.expand(found.get(tuple(powers), 0) - weight) == 0


x, y, p = sympy.symbols("x y p", real=True)


@pytest.mark.parametrize(
    ("product", "rest", "zero"),
    [
        (sympy.exp((x - 10000.0) * 1.5), 1, 10000.0),
        (sympy.exp((10000.0 - x) * 1.5), 1, 10000.0),
        (-3.5 * y * sympy.exp((x - 3000.0) / 0.5), -y, 3000.0 - 0.5 * math.log(3.5)),
        (sympy.exp((x - 3000.0) / 0.5).diff(x), 1, 3000.0 - 0.5 * math.log(2)),
        (sympy.exp(x - 1000.0) ** 2 / y, 1 / y, 1000.0),
    ],
    ids=str,
)
def test_the_number_goes_back_with_all_its_digits(
    product: sympy.Expr, rest: sympy.Expr, zero: float
) -> None:
    joined = joined_exponential(product)
    factors, exponent = joined
    assert factors == rest
    (found,) = sympy.solve(exponent, x)
    assert float(found) == pytest.approx(zero, rel=1e-15)


@pytest.mark.parametrize("far", [3000, 3000.0], ids=["whole", "decimal"])
def test_what_is_far_from_the_points_looked_at_is_seen(far: float) -> None:
    bend = sympy.log(1 + sympy.exp((x - far) * 1.5))
    assert not vanishes(bend)
    assert depends(bend, {x})
    power = (1 + sympy.exp((x - far) * 1.5)) ** p
    assert depends(power, {x})
    assert depends(power, {p})
    assert not depends(p + bend, {y})
