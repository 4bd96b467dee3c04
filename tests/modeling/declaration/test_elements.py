"""Every element against its closed form, its direction, and what it refuses."""

import math
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
import sympy
from hypothesis import given, strategies as st

from axisid import (
    Constant,
    Coordinate,
    Parameter,
    derive,
)
from axisid.elements import (
    G,
    asymmetric_coulomb,
    asymmetric_viscous,
    cogging,
    coulomb,
    cubic_spring,
    end_stop,
    gravity,
    gravity_moment,
    load_dependent,
    motor_inertia,
    offset,
    periodic_coulomb,
    quadratic,
    spring,
    stribeck,
    viscous,
)
from axisid.modeling.declaration.axis import Axis
from axisid.modeling.quantities.constants import with_numbers
from tests.axes.bodies import body, q
from tests.refusals import refused

theta = Coordinate("theta", unit="rad")
a, b = Parameter("a", "N"), Parameter("b", "N")
A, B = 3.0, 0.7  # their values

finite = st.floats(-2.0, 2.0)
Closed = Callable[[float, float], float]


def p(unit: str, name: str = "a") -> Parameter:
    return Parameter(name, unit)


def sgn(x: float) -> float:
    return float(np.sign(x))


ELEMENTS: dict[str, tuple[sympy.Expr, Closed]] = {
    "viscous": (viscous(p("N/(m/s)"), q), lambda _, v: A * v),
    "asymmetric viscous": (
        asymmetric_viscous(p("N/(m/s)"), p("N/(m/s)", "b"), q),
        lambda _, v: A * v if v > 0 else B * v,
    ),
    "Coulomb": (coulomb(a, q), lambda _, v: A * sgn(v)),
    "asymmetric Coulomb": (
        asymmetric_coulomb(a, b, q),
        lambda _, v: A if v > 0 else -B if v < 0 else (A - B) / 2,
    ),
    "quadratic": (quadratic(p("N/(m/s)^2"), q), lambda _, v: A * v * abs(v)),
    "Stribeck, exponential": (
        stribeck(a, q, velocity=0.4, exponent=1),
        lambda _, v: A * math.exp(-abs(v) / 0.4) * sgn(v),
    ),
    "Stribeck, Gaussian": (
        stribeck(a, q, velocity=0.4),
        lambda _, v: A * math.exp(-((v / 0.4) ** 2)) * sgn(v),
    ),
    "Stribeck of another exponent": (
        stribeck(a, q, velocity=0.4, exponent=0.6),
        lambda _, v: A * math.exp(-((abs(v) / 0.4) ** 0.6)) * sgn(v),
    ),
    "load-dependent": (
        load_dependent(p("1"), Constant(50.0, "N/m") * q - Constant(20.0, "N"), q),
        lambda x, v: A * abs(50 * x - 20) * sgn(v),
    ),
    "periodic Coulomb": (
        periodic_coulomb(a, b, q, period=0.3, harmonic=2),
        lambda x, v: (
            (A * math.cos(4 * math.pi * x / 0.3) + B * math.sin(4 * math.pi * x / 0.3)) * sgn(v)
        ),
    ),
    "cogging": (
        cogging(a, b, q, period=Constant(0.3, "m", "pitch")),
        lambda x, _: A * math.cos(2 * math.pi * x / 0.3) + B * math.sin(2 * math.pi * x / 0.3),
    ),
    "offset": (offset(a), lambda *_: A),
    "gravity": (gravity(p("kg")), lambda *_: 9.80665 * A),
    "spring": (spring(p("N/m"), q, rest=0.2), lambda x, _: A * (x - 0.2)),
    "spring at rest in 0": (spring(p("N/m"), q), lambda x, _: A * x),
    "cubic spring": (cubic_spring(p("N/m^3"), q, rest=0.2), lambda x, _: A * (x - 0.2) ** 3),
    "end stop": (
        end_stop(q, lower=-0.5, upper=0.4, stiffness=900.0, dissipation=0.6),
        lambda x, v: (
            900 * max(0, x - 0.4) * max(0, 1 + 0.6 * v)
            - 900 * max(0, -0.5 - x) * max(0, 1 - 0.6 * v)
        ),
    ),
}
ROTARY: dict[str, tuple[sympy.Expr, Closed]] = {
    "gravity moment": (
        gravity_moment(p("N m"), p("N m", "b"), theta),
        lambda x, _: A * math.sin(x) + B * math.cos(x),
    ),
    "gravity moment of a first moment": (
        gravity_moment(G * p("kg m"), 0, theta),
        lambda x, _: 9.80665 * A * math.sin(x),
    ),
    "cogging of a motor": (
        cogging(0, p("N m"), theta, period=2 * math.pi / 44),
        lambda x, _: A * math.sin(44 * x),
    ),
}


@cache
def evaluator(element: sympy.Expr, coordinate: Coordinate) -> Callable[..., float]:
    arguments = [coordinate.symbol, coordinate.velocity, a.symbol, b.symbol]
    return sympy.lambdify(arguments, with_numbers(element), "math")  # type: ignore[no-any-return]


def value(element: sympy.Expr, coordinate: Coordinate, x: float, v: float) -> float:
    return float(evaluator(element, coordinate)(x, v, A, B))


@pytest.mark.parametrize("name", [*ELEMENTS, *ROTARY])
@given(x=finite, v=finite)
def test_element_is_its_closed_form(name: str, x: float, v: float) -> None:
    coordinate = q if name in ELEMENTS else theta
    element, closed = {**ELEMENTS, **ROTARY}[name]
    assert value(element, coordinate, x, v) == pytest.approx(closed(x, v), rel=1e-12, abs=1e-12)


def test_motor_inertia_is_the_energy_of_the_rotor() -> None:
    rotor = Parameter("rotor", "kg m^2")
    turns = 2 * math.pi / 0.005
    reflected = with_numbers(motor_inertia(rotor, q, ratio=turns))
    assert float(reflected.subs(rotor.symbol, 3e-4)) == pytest.approx(3e-4 * turns**2, rel=1e-14)


def composed(*resistance: sympy.Expr, parameters: tuple[Parameter, ...]) -> Axis:
    return body(*resistance, parameters=parameters, name="composed")


test_senseless_elements_are_refused = refused(
    (code, "", make)
    for make, code in [
        (lambda: stribeck(a, q, velocity=0.0), "axis"),
        (lambda: stribeck(a, q, velocity=0.1, exponent=-1), "axis"),
        (lambda: cogging(a, b, q, period=-0.1), "axis"),
        (lambda: cogging(a, b, q, period=0.1, harmonic=0), "axis"),
        (lambda: cogging(a, b, q, period=math.nan), "axis"),
        (lambda: motor_inertia(a, q, ratio=0.0), "axis"),
        (lambda: end_stop(q, lower=0, upper=1, stiffness=-1.0), "axis"),
        (lambda: end_stop(q, lower=1, upper=0, stiffness=1.0), "axis"),
        (lambda: Constant(math.inf, "m"), "axis"),
        (lambda: Constant(1.0, "mm"), "units"),
        (lambda: Constant(1.0, "m", "double"), "axis"),
        (
            lambda: composed(p("N m") / (q * 0 + Constant(0.0, "m")), parameters=(p("N m"),)),
            "equation",
        ),
    ]
)


def test_constants_are_equal_by_name_value_and_unit() -> None:
    pitch = Constant(0.3, "m", "pitch")
    assert pitch.symbol == Constant(0.3, "m", "pitch").symbol
    for other in (Constant(0.4, "m", "pitch"), Constant(0.3, "s", "pitch"), Constant(0.3, "m")):
        assert pitch.symbol != other.symbol


def test_constant_is_a_number_in_the_generated_code() -> None:
    axis = composed(spring(p("N/m"), q, rest=Constant(0.2, "m", "rest")), parameters=(p("N/m"),))
    assert "rest" not in str(derive(axis).idm.columns)
    assert derive(axis).idm.columns[1] == q.symbol - 0.2
