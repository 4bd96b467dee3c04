"""What no motion tells apart where parameters enter nonlinearly, said before any motion is run."""

from collections.abc import Mapping

import numpy as np
import pytest
import sympy
from hypothesis import given, settings, strategies as st

from axisid import Constant, Parameter, build, derive
from axisid.elements import coulomb, stribeck, viscous
from axisid.modeling.derivation.description import (
    derived_sections,
    describe_loss,
)
from axisid.modeling.derivation.null_space import generic_points, nominal_point
from axisid.modeling.quantities.symbols import DIRECTION
from tests.axes.bodies import M, body, q

dq, sign, speed = q.velocity, sympy.sign(q.velocity), sympy.Abs(q.velocity)
a = Parameter("a", "N/(m/s)")
b, d = Parameter("b", "1"), Parameter("d", "1", nominal=1.5)
c, p, s, w = (Parameter(name, "N") for name in "cpsw")
u, v = Parameter("u", "m/s", nominal=0.02), Parameter("v", "m/s", nominal=0.1, lower=1e-3)
METRE = Constant(1.0, "m")
ANGLE = q / METRE


BEYOND = Parameter("b", "1", nominal=3.0)
#: Resistance, parameters, and what is said; only names where the weights depend on parameters.
HIDDEN = {
    "a factor that is a power": ((a * sympy.exp(b.symbol) * dq,), (a, b), ["a and b"]),
    "a quotient beside a coefficient": (
        (a * dq, s * dq / v),
        (a, s, v),
        ["a and s", "a and v"],
    ),
    "a root of squares beside a level": (
        ((c + sympy.sqrt(p**2 + w**2)) * sign,),
        (c, p, w),
        ["c and p", "c and w"],
    ),
    "two Stribeck velocities that add up": (
        (c * sign, s * sympy.exp(-((speed / (u + v)) ** 2)) * sign),
        (c, s, u, v),
        ["u -1, v +1; only u + v"],
    ),
    "a scale under a root": ((s * sympy.sqrt(speed / v) * sign,), (s, v), ["s and v"]),
    "a scale under a logarithm": (
        (c * sign, s * sympy.log(speed / v) * sign),
        (c, s, v),
        ["c and v"],
    ),
    "a scale to a power": ((s * (speed / v) ** d.symbol * sign,), (s, v, d), ["s and v"]),
    "a phase beside both its parts": (
        (p * sympy.sin(ANGLE + b), s * sympy.sin(ANGLE), w * sympy.cos(ANGLE)),
        (p, b, s, w),
        ["p, b and s", "p, b and w"],
    ),
    "outside the domain of a function": (
        (c * sympy.asin(BEYOND.symbol) * sign,),
        (c, BEYOND),
        [],
    ),
}


@pytest.mark.parametrize("name", HIDDEN)
def test_what_trades_is_found_and_said_and_changes_no_force(name: str) -> None:
    resistance, parameters, said = HIDDEN[name]
    model = derive(body(*resistance, parameters=parameters))
    words = {
        True: "no motion distinguishes {} at the nominal values",
        False: "no motion shows a change of {}",
    }
    forms = [words[" and " in each].format(each) for each in said]
    ends = ["" if " and " in each else " can be identified" for each in said]
    expected = [form + end for form, end in zip(forms, ends, strict=True)]
    assert [describe_loss(h) for h in model.unidentifiable] == expected
    for h in model.unidentifiable:
        assert is_unseen(h, model.force, nominal_point(model.axis.parameters))


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


def test_a_parameter_that_another_one_hides_is_hidden_at_the_nominal_values_only() -> None:
    larger = Parameter("g", "1", nominal=3.0)
    hiding = c * sympy.Max(larger.symbol, b.symbol) * sign
    (hidden,) = derive(body(hiding, a * dq, parameters=(a, b, c, larger))).unidentifiable[:1]
    assert hidden[b.symbol].is_Float
    assert describe_loss(hidden).endswith("at the nominal values")


def test_it_stands_in_the_equations_and_in_the_generated_axis() -> None:
    unidentifiable = body(a * sympy.exp(b.symbol) * dq, parameters=(a, b))
    sentence = "no motion distinguishes a and b at the nominal values"
    assert derived_sections(derive(unidentifiable))[-1].lines == (sentence,)
    assert build(unidentifiable, native=False).unidentifiable == (sentence,)


def is_unseen(
    direction: dict[sympy.Symbol, sympy.Expr],
    force: sympy.Expr,
    point: Mapping[sympy.Symbol, sympy.Expr],
) -> bool:
    """Whether a force does not change along a direction at a point, at random motions."""
    change = sum((force.diff(x) * weight for x, weight in direction.items()), sympy.S.Zero)
    size = sum((sympy.Abs(force.diff(x) * w) for x, w in direction.items()), sympy.S.Zero)
    rng = np.random.default_rng(1)
    for way in (1, -1, 1):
        values = {x: rng.uniform(0.3, 2.0) for x in sorted(force.free_symbols, key=str)}
        values |= {dq: way * rng.uniform(0.3, 2.0), DIRECTION: way, **point}
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
    nominal = nominal_point(model.axis.parameters)
    assert is_unseen(model.unidentifiable[0], model.force, nominal)
