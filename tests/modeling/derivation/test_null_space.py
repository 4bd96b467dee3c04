"""What no motion tells apart where parameters enter nonlinearly, said before any motion is run."""

import numpy as np
import pytest
import sympy
from hypothesis import given, settings, strategies as st

from axisid import Constant, Parameter, build, derive
from axisid.elements import coulomb, stribeck, viscous
from axisid.modeling.derivation.description import (
    derived_sections,
    describe_direction,
    describe_loss,
)
from axisid.modeling.derivation.null_space import generic_points
from axisid.modeling.quantities.symbols import DIRECTION
from tests.axes.bodies import M, body, q

dq, sign, speed = q.velocity, sympy.sign(q.velocity), sympy.Abs(q.velocity)
a = Parameter("a", "N/(m/s)")
b, d = Parameter("b", "1"), Parameter("d", "1", nominal=1.5)
c, p, s, w = (Parameter(name, "N") for name in "cpsw")
u, v = Parameter("u", "m/s", nominal=0.02), Parameter("v", "m/s", nominal=0.1, lower=1e-3)
METRE = Constant(1.0, "m")
ANGLE = q / METRE


HIDDEN = {
    "a factor that is a power": (
        (a * sympy.exp(b.symbol) * dq,),
        (a, b),
        ["a +a, b -1"],
    ),
    "a quotient beside a coefficient": (
        (a * dq, s * dq / v),
        (a, s, v),
        ["a +1, s -v", "a +s, v +v**2"],
    ),
    "a root of squares beside a level": (
        ((c + sympy.sqrt(p**2 + w**2)) * sign,),
        (c, p, w),
        ["c +p, p -sqrt(p**2 + w**2)", "c +w, w -sqrt(p**2 + w**2)"],
    ),
    "two Stribeck velocities that add up": (
        (c * sign, s * sympy.exp(-((speed / (u + v)) ** 2)) * sign),
        (c, s, u, v),
        ["u -1, v +1"],
    ),
    "a scale under a root": ((s * sympy.sqrt(speed / v) * sign,), (s, v), ["s +s, v +2*v"]),
    "a scale under a logarithm": (
        (c * sign, s * sympy.log(speed / v) * sign),
        (c, s, v),
        ["c +s, v +v"],
    ),
    "one law by Abs and by direction": (
        (a * dq, p * speed / v * sign),
        (a, p, v),
        ["a +1, p -v", "a +p, v +v**2"],
    ),
}


@pytest.mark.parametrize("name", HIDDEN)
def test_what_trades_is_said_with_its_combination(name: str) -> None:
    resistance, parameters, said = HIDDEN[name]
    model = derive(body(*resistance, parameters=parameters))
    assert [describe_direction(h) for h in model.unidentifiable] == said


@pytest.mark.parametrize(
    ("resistance", "parameters"),
    [
        ((s * (speed / v) ** d.symbol * sign,), (s, v, d)),
        (
            (p * sympy.sin(ANGLE + b), s * sympy.sin(ANGLE), w * sympy.cos(ANGLE)),
            (p, b, s, w),
        ),
    ],
)
def test_what_trades_in_no_simple_form_is_found_too(
    resistance: tuple[sympy.Expr, ...], parameters: tuple[Parameter, ...]
) -> None:
    model = derive(body(*resistance, parameters=parameters))
    assert model.unidentifiable
    assert all(is_unseen(h, model.force) for h in model.unidentifiable)


@pytest.mark.parametrize(
    ("resistance", "parameters"),
    [
        ((viscous(a, q), coulomb(c, q), stribeck(s, q, velocity=v)), (a, c, s, v)),
        (
            (viscous(a, q), coulomb(c, q), stribeck(s, q, velocity=v, exponent=d)),
            (a, c, s, v, d),
        ),
        ((c * sympy.tanh(dq / v),), (c, v)),
        ((c * sympy.tanh(dq / v) + s * sympy.tanh(dq / u),), (c, v, s, u)),
        ((s * sympy.log(1 + speed / v) * sign, c * sign), (s, c, v)),
        ((p * sympy.sin(ANGLE + b), w * sign), (p, b, w)),
        ((p * sympy.sin(ANGLE * b), w * sympy.sin(ANGLE)), (p, b, w)),
    ],
)
def test_what_a_motion_can_tell_apart_is_not_hidden(
    resistance: tuple[sympy.Expr, ...], parameters: tuple[Parameter, ...]
) -> None:
    assert derive(body(*resistance, parameters=parameters)).unidentifiable == ()


def test_what_is_alike_at_one_point_only_is_not_hidden() -> None:
    parameters = (M, c, s, d)
    for point in generic_points(parameters):
        accident = sympy.exp((d.symbol - point[d.symbol]) * speed / Constant(1.0, "m/s"))
        assert derive(body(c.symbol, s * accident, parameters=(c, s, d))).unidentifiable == ()


def test_a_parameter_outside_the_domain_of_a_function_is_no_error() -> None:
    beyond = Parameter("b", "1", nominal=3.0)
    assert (
        derive(body(c * sympy.asin(beyond.symbol) * sign, parameters=(c, beyond))).unidentifiable
        == ()
    )


def test_it_stands_in_the_equations_and_in_the_generated_axis() -> None:
    unidentifiable = body(a * sympy.exp(b.symbol) * dq, parameters=(a, b))
    sentence = "no motion shows a change of a +a, b -1"
    assert derived_sections(derive(unidentifiable))[-1].lines == (sentence,)
    assert build(unidentifiable, native=False).unidentifiable == (sentence,)
    summed = body(c * sympy.tanh(dq / (u + v)), parameters=(c, u, v))
    assert [describe_loss(h) for h in derive(summed).unidentifiable] == [
        "no motion shows a change of u -1, v +1; only u + v can be identified"
    ]


def is_unseen(direction: dict[sympy.Symbol, sympy.Expr], force: sympy.Expr) -> bool:
    """Whether a force does not change along a direction, at random points and motions."""
    change = sum((force.diff(x) * weight for x, weight in direction.items()), sympy.S.Zero)
    size = sum((sympy.Abs(force.diff(x) * w) for x, w in direction.items()), sympy.S.Zero)
    rng = np.random.default_rng(1)
    for way in (1, -1, 1):
        values = {x: rng.uniform(0.3, 2.0) for x in sorted(force.free_symbols, key=str)}
        values |= {dq: way * rng.uniform(0.3, 2.0), DIRECTION: way}
        if abs(change.subs(values)) > 1e-9 * size.subs(values):
            return False
    return True


r = Parameter("r", "1", nominal=0.7)
SPLIT = {
    "times exp": lambda x: x * sympy.exp(r.symbol),
    "over": lambda x: x / (1 + r.symbol**2),
    "root": lambda x: sympy.sqrt(x**2 * (1 + r.symbol**2)),
    "power": lambda x: x * sympy.Float(1.5) ** r.symbol,
}


@pytest.mark.slow
@settings(max_examples=30)
@given(st.sampled_from([a, c, s, v]), st.sampled_from(sorted(SPLIT)), st.booleans())
def test_parameter_declared_as_two_hides_one_direction_along_which_the_force_stays(
    split: Parameter, way: str, further: bool
) -> None:
    exponent = d.symbol if further else sympy.Integer(2)
    law = a * dq + c * sign + s * sympy.exp(-((speed / v) ** exponent)) * sign
    parameters = (a, c, s, v, d) if further else (a, c, s, v)
    assert derive(body(law, parameters=parameters)).unidentifiable == ()
    twice = law.subs(split.symbol, SPLIT[way](split.symbol))
    model = derive(body(twice, parameters=(*parameters, r)))
    assert len(model.unidentifiable) == 1
    assert set(model.unidentifiable[0]) == {split.symbol, r.symbol}
    assert is_unseen(model.unidentifiable[0], model.force)
