"""Expressions as engineers write them, and their kinks."""

import math
from typing import Any

import pytest
import sympy
from hypothesis import given

from axisid import Constant, Coordinate, Parameter, load_axis
from axisid.elements import G
from axisid.modeling.declaration.axis import equation_of_motion
from axisid.modeling.quantities import Formula
from axisid.modeling.quantities.reading_order import written
from axisid.modeling.quantities.symbols import DIRECTION, FORCE, MEASURED_POSITION, REFERENCE
from tests.strategies.expressions import expressions

Q = Coordinate("q")
M, FV, MX, K3 = (Parameter(name, "kg").symbol for name in ("M", "fv", "mx", "k3"))
FUNCTIONS: dict[str, Any] = {
    name: getattr(math, name)
    for name in "exp log sin cos tan asin acos atan sinh cosh tanh sqrt atan2 pi".split()
}
FUNCTIONS |= {"Abs": abs, "Min": min, "Max": max, "E": math.e}
FUNCTIONS |= {
    "sign": lambda x: (x > 0) - (x < 0),
    "Heaviside": lambda x: (1 + (x > 0) - (x < 0)) / 2,
}


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (
            FV * Q.velocity + M * Q.acceleration + sympy.sign(Q.velocity) * 3 + 4,
            "M*ddq + fv*dq + 3*sign(dq) + 4",
        ),
        (MX * G * sympy.sin(Q.symbol) - M, "mx*G*sin(q) - M"),
        (K3 * Q.symbol**3 + Q.velocity * sympy.Abs(Q.velocity), "dq*Abs(dq) + k3*q**3"),
        ((FORCE - M * DIRECTION - 3) / M, "(tau - M*direction - 3)/M"),
        (-MEASURED_POSITION + REFERENCE, "reference - measured_position"),
        (-M * Q.acceleration, "-M*ddq"),
        (1 - sympy.sign(Q.velocity), "1 - sign(dq)"),
        (sympy.cos(2 * sympy.pi * Q.symbol), "cos(2*pi*q)"),
        (sympy.Float(1263.30936333944) * M + sympy.Float(5.0), "1263.309363*M + 5"),
    ],
)
def test_terms_and_factors_stand_as_engineers_write_them(value: sympy.Expr, text: str) -> None:
    assert written(value, Q) == text


def test_constants_of_one_name_do_not_cancel() -> None:
    one, other = Constant(0.5, "m", "r").symbol, Constant(0.25, "m", "r").symbol
    assert written(one - other, Q) == "r - r"


def test_a_profile_of_the_drive_stands_beside_the_force() -> None:
    axis = load_axis("linear_motor")
    text = equation_of_motion(axis).text(axis.coordinate)
    assert text.startswith("tau*(0.03*cos(pi*q/pitch) + 1) = M*ddq + Fv*dq + Fc*sign(dq) + ")


def test_a_formula_without_a_value_is_its_column() -> None:
    row = Formula(name=M, unit="kg", column=Q.acceleration + G)
    assert row.text(Q) == "M [kg]: ddq + G"


@pytest.mark.slow
@given(expressions((Q.symbol, Q.velocity, M)))
def test_what_is_written_has_the_value_of_the_expression(value: sympy.Expr) -> None:
    point = {"q": 0.37, "dq": -0.81, "M": 1.43}
    by_symbol = {sympy.Symbol(name, real=True): x for name, x in point.items()}
    try:
        expected = complex(sympy.N(value.xreplace(by_symbol)))
    except (TypeError, OverflowError):
        return
    if expected.imag or not math.isfinite(expected.real) or value.has(sympy.Piecewise):
        return
    text = written(value, Q)
    found = eval(text, {"__builtins__": {}}, {**FUNCTIONS, **point})  # noqa: S307
    assert found == pytest.approx(expected.real, rel=1e-6, abs=1e-9)


a, b, q, x = sympy.symbols("a b q x", real=True)
