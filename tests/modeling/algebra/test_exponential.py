"""A number that SymPy took out of an exponent goes back where floating point cannot hold it."""

import math

import pytest
import sympy

from axisid.modeling.algebra import joined_exponential
from axisid.modeling.algebra.point_value import depends, vanishes

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


@pytest.mark.parametrize(
    "product",
    [
        2.5 * sympy.exp(x),
        sympy.exp((x - 1.0) * 1.5),
        1e-200 * x * y,
        1e300 * sympy.cos(x),
        p * sympy.exp(x - 3000),
    ],
    ids=str,
)
def test_other_numbers_stay(product: sympy.Expr) -> None:
    assert joined_exponential(product) is None


@pytest.mark.parametrize("far", [3000, 3000.0], ids=["whole", "decimal"])
def test_what_is_far_from_the_points_looked_at_is_seen(far: float) -> None:
    bend = sympy.log(1 + sympy.exp((x - far) * 1.5))
    assert not vanishes(bend)
    assert depends(bend, {x})
    power = (1 + sympy.exp((x - far) * 1.5)) ** p
    assert depends(power, {x})
    assert depends(power, {p})
    assert not depends(p + bend, {y})
