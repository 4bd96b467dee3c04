"""Kinks and jumps over the position: which are found, and that the sides put together the whole."""

from functools import partial

import numpy as np
import pytest
import sympy
from sympy import Abs, Heaviside, Max, Piecewise, cos, exp, pi, sign, sin, sqrt, tanh

from axisid import Constant, Coordinate, Parameter, derive
from axisid.codegen.lowering.switching import Switching, switching
from axisid.elements import coulomb, end_stop, viscous
from axisid.modeling.quantities import with_numbers
from tests.axes.bodies import rotor

x = Coordinate("x", unit="rad")
X, V = x.symbol, x.velocity
m, c = Parameter("m", "kg m^2", nominal=2.0), Parameter("c", "N m", nominal=3.0)
b = Parameter("b", "N m/(rad/s)", nominal=5.0)
S = Constant(1.0, "s").symbol
C, D = c.symbol, b.symbol


loaded = partial(rotor, coordinate=x, inertia=m, parameters=(c, b))


def found(*resistance: sympy.Expr) -> Switching:
    return switching(derive(loaded(*resistance)))


STOPS = end_stop(x, lower=-1.0, upper=2.0, stiffness=8e4)
BUFFERS = end_stop(x, lower=-1.0, upper=2.0, stiffness=8e4, dissipation=0.5)
#: Resistances, each with the switching functions that it must have, up to their signs.
SWITCHED: dict[str, tuple[sympy.Expr, list[str]]] = {
    "end stops": (STOPS, ["x + 1", "x - 2"]),
    "end stops that dissipate": (
        BUFFERS,
        ["x + 1", "x - 2", "dx/2 - 1", "dx/2 + 1"],
    ),
    "Abs": (C * Abs(X), ["x"]),
    "sign": (C * sign(X - 3), ["x - 3"]),
    "Heaviside": (C * Heaviside(X - 3), ["x - 3"]),
    "Max": (C * Max(0, X - 1), ["x - 1"]),
    "Max of either sign": (C * Max(0, X - 1) + D * V * Max(0, 1 - X), ["x - 1"]),
    "Piecewise": (C * Piecewise((X, X < 1), (2 * X, X < 2), (3, True)), ["x - 1", "x - 2"]),
    "friction in pieces of the position": (
        D * V * Piecewise((1, X < 0), (2, True)),
        ["x"],
    ),
    "friction that jumps with the position": (C * sign(X * V), ["x"]),
    "a plane of the motion": (D * Max(0, V - X / S), ["dx - x"]),
    "a root of a distance": (D * V * Abs(X - 1) ** 0.5, ["x - 1"]),
    "Abs of a wave": (C * Abs(sin(9 * X)), ["sin(9*x)"]),
    "Abs in Abs": (C * Abs(Abs(X) - 1), ["x", "side1*x - 1"]),
}
SMOOTH: dict[str, sympy.Expr] = {
    "Coulomb friction": coulomb(c, x) + viscous(b, x),
    "quadratic drag": D * S * V * Abs(V),
    "friction in pieces of the direction": Piecewise((D * V, V < 0), (2 * D * V, True)),
    "a wave": C * sin(2 * pi * X / 0.003),
    "a bell": C * exp(-(((X - 1) / 0.01) ** 2)),
}


def with_sides(switched: Switching, motion: dict[sympy.Symbol, float]) -> sympy.Expr:
    """The acceleration at a motion, each side the sign of its switching function."""
    point = dict(motion)
    for side, function in zip(switched.sides, switched.functions, strict=True):
        point[side] = sign(function.subs(point))
    return switched.acceleration.subs(point)


def up_to_sign(function: sympy.Expr) -> set[sympy.Expr]:
    exact = sympy.nsimplify(function)
    return {sympy.expand(exact), sympy.expand(-exact)}


@pytest.mark.parametrize("name", SWITCHED)
def test_what_decides_by_the_position_is_a_switching_function(name: str) -> None:
    force, wanted = SWITCHED[name]
    functions = found(force).functions
    names = {"x": X, "dx": V, "side1": sympy.Symbol("side1", real=True)}
    expected = [up_to_sign(sympy.sympify(text, names)) for text in wanted]
    assert len(functions) == len(expected), functions
    for function in functions:
        assert up_to_sign(function) in expected, function


@pytest.mark.parametrize("name", SWITCHED)
def test_sides_put_together_the_acceleration(name: str) -> None:
    force, _ = SWITCHED[name]
    axis = loaded(force)
    whole, switched = derive(axis).acceleration, switching(derive(axis))
    values = {"m": 2.0, "c": 3.0, "b": 5.0, "tau": 0.7}
    rng = np.random.default_rng(1)
    for position, velocity in rng.uniform(-4.0, 4.0, (20, 2)):
        named = values | {"x": position, "dx": velocity, "direction": np.sign(velocity)}
        symbols = whole.free_symbols | switched.acceleration.free_symbols
        motion = {symbol: named[symbol.name] for symbol in symbols if symbol.name in named}
        motion |= {X: position, V: velocity}
        direct = with_numbers(whole).subs(motion)
        assert float(with_sides(switched, motion)) == pytest.approx(float(direct), rel=1e-12)


@pytest.mark.parametrize("name", SMOOTH)
def test_what_is_smooth_over_the_position_has_no_sides(name: str) -> None:
    switched = found(SMOOTH[name])
    assert switched.sides == switched.functions == ()


@pytest.mark.parametrize(
    ("force", "place", "wanted"),
    [
        (C * sin(2 * pi * X / 0.003), 0.1, [2 * np.pi / 0.003]),
        (C * cos(7 * X) * sin(X), 0.1, [1.0, 7.0]),
        (C * exp(-(((X - 1) / 0.01) ** 2)), 1.0, [100.0]),
        (C * tanh(X / 0.01), 0.0, [100.0]),
        (C * sqrt(X**2 + 1e-4), 0.0, [0.0, 2**0.5 / 0.01]),
        (C / (X**2 + 4), 0.0, [0.0, 2**0.5 / 2]),
        (C * (X**3 + X), 0.3, []),
        (C * Max(0, X - 1), 0.3, []),
        (D * V * sin(9 * X), 0.3, [9.0]),
        (D * V, 0.3, []),
        (C * Abs(sin(9 * X)), 0.1, [9.0]),
        (C * sin(9 * X) + STOPS, 0.1, [9.0]),
    ],
)
def test_wave_numbers_tell_over_how_short_a_way_the_force_varies(
    force: sympy.Expr, place: float, wanted: list[float]
) -> None:
    numbers = [float(number.subs(X, place)) for number in found(force).wave_numbers]
    assert sorted(numbers) == pytest.approx(sorted(wanted))
