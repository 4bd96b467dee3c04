"""The friction ladder: what gives way, what stays, and that each law contains those before it."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import sympy

from axisid import (
    Axis,
    Constant,
    Parameter,
    load_axis,
)
from axisid.elements import asymmetric_coulomb, asymmetric_viscous, quadratic, stribeck
from axisid.modeling.derivation.friction_ladder import friction_ladder
from axisid.modeling.derivation.model import derive
from axisid.modeling.quantities.symbols import DIRECTION
from axisid.modeling.quantities.units import parse_unit
from tests.axes.bodies import b, body, c, energetic, k, m, x
from tests.axes.simulated import AXES
from tests.refusals import refused

LAWS = ("viscous", "Coulomb", "offset", "directional")

w = Parameter("w", "N")
v = Parameter("v", "m/s", nominal=0.1)


def stage(*resistance: sympy.Expr, parameters: tuple[Parameter, ...]) -> Axis:
    return body(*resistance, coordinate=x, inertia=m, parameters=parameters, name="stage")


def names(axis: Axis) -> list[str]:
    return [p.name for p in axis.parameters]


def spanned(small: Axis, large: Axis) -> bool:
    """Whether the larger regressor's columns give the smaller's, at random motions."""
    models = derive(small), derive(large)
    motion = np.random.default_rng(1).normal(size=(4, 30))
    motion[3] = np.sign(motion[1])
    q = small.coordinate
    symbols = (q.symbol, q.velocity, q.acceleration, DIRECTION)
    inner, outer = (
        np.array([sympy.lambdify(symbols, c)(*motion) + np.zeros(30) for c in model.idm.columns])
        for model in models
    )
    return bool(np.linalg.matrix_rank(np.vstack([inner, outer])) == len(outer))


def test_every_law_contains_those_before_it() -> None:
    ladder = friction_ladder(AXES["offset"])
    assert tuple(ladder) == LAWS
    rungs = list(ladder.values())
    assert all(spanned(small, large) for small, large in pairwise(rungs))
    assert not spanned(rungs[-1], rungs[-2])


def test_positive_parameters_oppose_the_motion_in_their_direction() -> None:
    directional = friction_ladder(AXES["offset"])["directional"]
    q = directional.coordinate
    values = {"M": 0, "Fvp": 10, "Fvm": 20, "Fcp": 3, "Fcm": 5}
    force = directional.force.subs({p.symbol: values[p.name] for p in directional.parameters})
    assert [force.subs(q.velocity, v) for v in (2, -2)] == [23, -45]


def test_springs_gravity_and_what_depends_on_the_position_stay() -> None:
    axis = AXES["position_dependent"]
    ladder = friction_ladder(axis)
    assert names(ladder["viscous"]) == ["M", "Fb", "k", "Fv"]
    assert names(ladder["Coulomb"]) == ["M", "Fb", "k", "Fv", "Fc"]
    assert list(ladder)[-1] == "declared"
    assert ladder["declared"] is axis
    pendulum = friction_ladder(AXES["pendulum"])
    assert names(pendulum["directional"]) == ["J", "mgl", "Fvp", "Fvm", "fcp", "fcm"]
    assert str(pendulum["viscous"].parameters[-1].unit) == "N m/(rad/s)"


@pytest.mark.slow
@pytest.mark.parametrize("axis", AXES.values(), ids=AXES.keys())
def test_every_rung_can_be_derived_with_fitting_units(axis: Axis) -> None:
    for rung in friction_ladder(axis, quadratic=True, stribeck=0.01).values():
        model, q = derive(rung), axis.coordinate
        speed = parse_unit(f"{q.unit}/s")
        sizes = {"Fv": q.force_unit / speed, "Fc": q.force_unit, "Fq": q.force_unit / speed**2}
        for p in rung.parameters:
            if p.name in sizes:
                assert parse_unit(p.unit).same_dimension(sizes[p.name])
        assert not model.base.changed or rung is axis or derive(axis).base.changed


test_a_stribeck_velocity_that_is_none_is_refused = refused(
    ("axis", "Stribeck velocity is", lambda v=v: friction_ladder(AXES["offset"], stribeck=v))
    for v in [0.0, -1.0, float("nan"), float("inf"), "0.1"]
)


def test_an_axis_that_differs_by_direction_is_the_directional_rung_by_its_own_names() -> None:
    axis = load_axis("belt_axis")
    ladder = friction_ladder(axis, quadratic=True)
    assert tuple(ladder) == (*LAWS, "quadratic")
    assert ladder["directional"] is axis
    assert names(ladder["offset"]) == ["m", "Fv", "Fc", "F0"]
    assert names(ladder["quadratic"]) == ["m", "Fvp", "Fvm", "Fcp", "Fcm", "Fq"]


SIGN, SPEED = sympy.sign(x.velocity), sympy.Abs(x.velocity)
MORE = Parameter("more", "N/(m/s)")
DRAG = Parameter("drag", "N/(m/s)^2")


@pytest.mark.parametrize(
    ("friction", "parameters", "law"),
    [
        ((c * SIGN, b * SPEED * SIGN), (b, c), "Coulomb"),
        ((b * x.velocity, c * (2 * sympy.Heaviside(x.velocity) - 1)), (b, c), "Coulomb"),
        ((b * x.velocity + c * SIGN, MORE * SPEED + w), (b, c, w, MORE), "directional"),
        ((b * x.velocity + c * SIGN + w, w * SIGN), (b, c, w), "offset"),
        (
            (asymmetric_viscous(b, MORE, x), asymmetric_coulomb(c, w, x), quadratic(DRAG, x)),
            (b, c, w, MORE, DRAG),
            "quadratic",
        ),
        (
            (
                asymmetric_viscous(b, MORE, x),
                asymmetric_coulomb(c, w, x),
                stribeck(k, x, velocity=0.02),
            ),
            (b, c, w, MORE, k),
            "Stribeck",
        ),
    ],
)
def test_a_law_is_recognised_however_it_is_written(
    friction: tuple[sympy.Expr, ...], parameters: tuple[Parameter, ...], law: str
) -> None:
    force = [replace(p, unit="N") if p is k else p for p in parameters]
    axis = stage(*friction, parameters=tuple(force))
    ladder = friction_ladder(axis, quadratic=True, stribeck=0.02)
    assert [name for name, rung in ladder.items() if rung is axis] == [law]
    assert all(p.name in names(ladder[law]) for p in parameters)


@pytest.mark.parametrize(
    ("friction", "parameters"),
    [
        ((b * (x.velocity + Constant(0.1, "m/s") * SIGN),), (b,)),
        ((b * x.velocity, MORE * SPEED), (b, MORE)),
        ((b * x.velocity + Constant(1.0, "m^2/(N s^2)") * b.symbol**2 * SIGN,), (b,)),
        ((b * x.velocity, c * sympy.tanh(x.velocity / v)), (b, c, v)),
    ],
)
def test_another_law_is_a_rung_of_its_own(
    friction: tuple[sympy.Expr, ...], parameters: tuple[Parameter, ...]
) -> None:
    axis = stage(*friction, parameters=parameters)
    ladder = friction_ladder(axis)
    assert tuple(ladder) == (*LAWS, "declared")
    assert ladder["declared"] is axis


def test_an_axis_without_friction_gets_it() -> None:
    axis = energetic(coordinate=x, inertia=m, parameters=(k,), potential=k * x.symbol**2 / 2)
    assert names(friction_ladder(axis)["Coulomb"]) == ["m", "k", "Fv", "Fc"]


def test_levels_that_have_the_constant_force_in_them_are_not_bounded() -> None:
    """A weight of 150 N makes a Coulomb friction of 40 N one of -110 N in one direction."""
    bounded = replace(c, lower=0.0, upper=100.0)
    damped = replace(b, lower=0.0)
    axis = stage(
        b * x.velocity, c * sympy.sign(x.velocity), w * 1, parameters=(m, damped, bounded, w)
    )
    by_name = {p.name: p for p in friction_ladder(axis)["directional"].parameters}
    for level in ("cp", "cm"):
        assert not by_name[level].is_bounded
    for coefficient in ("bp", "bm"):
        assert by_name[coefficient].lower == 0.0
    assert {p.name: p for p in friction_ladder(axis)["Coulomb"].parameters}["c"] == bounded
