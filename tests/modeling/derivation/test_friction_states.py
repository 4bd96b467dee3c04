"""What an internal state may follow, and what an axis with states may have beside."""

from dataclasses import replace

import pytest
import sympy

from axisid import Constant, Signal, derive, leave_out
from axisid.control import cascade_pd
from axisid.elements import Drive, State, coulomb, dahl, lugre, maxwell_slip
from axisid.modeling.declaration.axis import Axis
from tests.axes.remembering import (
    Fc,
    Fs,
    Fv,
    dahl_axis,
    declared,
    s0,
    s1,
    vs,
    x,
)
from tests.refusals import refused, refuses

q, dq = x.symbol, x.velocity
PARTS = (s0, s1, Fc, Fs, vs)


def _with(*states: State) -> Axis:
    return declared("own", (s0, Fc), *(s0 * state.symbol for state in states), coulomb(Fc, x))


def test_states_stand_in_the_force_and_bring_their_equations_along() -> None:
    model = derive(dahl_axis())
    (state,) = model.states
    z = sympy.Symbol("z_s0", real=True)
    direction = sympy.Symbol("direction", real=True)
    assert sympy.expand(state.rate - (dq - s0.symbol * direction * dq * z / Fc.symbol)) == 0
    assert z in model.force.free_symbols
    assert model.at_start(model.force).free_symbols.isdisjoint({z})


@pytest.mark.parametrize(("start", "first"), [(0.5, 0.5), (2, 1), (-2, -1)])
def test_a_state_starts_where_it_was_declared_but_not_beyond_its_limit(
    start: float, first: float
) -> None:
    preload = State("z", "m", dq, limit=Fc / s0, start=start * Fc / s0)
    (state,) = derive(_with(preload)).states
    assert state.limit == Fc.symbol / s0.symbol
    assert state.start.xreplace({Fc.symbol: 20.0, s0.symbol: 1e6}) == pytest.approx(first * 2e-5)


test_states_that_are_none_of_friction_are_refused = refused(
    [
        (
            "equation",
            "",
            lambda: derive(_with(State("z", "m", lambda z: dq - z / Constant(0.1, "s", "T")))),
        ),
        ("equation", "", lambda: derive(_with(State("z", "m", dq * 2, limit=Fc / s0)))),
        ("equation", "", lambda: derive(_with(State("z", "m", dq, start=q)))),
        (
            "equation",
            "",
            lambda: derive(_with(State("z", "m", lambda z: dq * (1 - z * x.acceleration / 9.0)))),
        ),
        ("equation", "", lambda: _with(State("z", "m", dq), State("z", "m", 2 * dq))),
        (
            "units",
            r"level of a Maxwell slider, 2\*s0, is in N/m",
            lambda: declared("made", (s0,), maxwell_slip(s0, 2 * s0.symbol, x)),
        ),
        (
            "equation",
            "the stiffness of Dahl friction is -1e",
            lambda: dahl(-1e6, x, coulomb=Fc),
        ),
        (
            "equation",
            "the static level of LuGre friction is 0 N",
            lambda: lugre(s0, s1, x, coulomb=Fc, static=0.0, velocity=vs),
        ),
    ]
)


@pytest.mark.parametrize(
    ("name", "unit", "says"),
    [
        ("s0", "N", r"stiffness of LuGre friction, s0, is in N"),
        ("s1", "N", r"damping of LuGre friction, s1, is in N"),
        ("Fc", "m", r"Coulomb level of LuGre friction, Fc, is in m"),
        ("Fs", "kg", r"static level of LuGre friction, Fs, is in kg"),
        ("vs", "m", r"Stribeck velocity of LuGre friction, vs, is in m"),
    ],
)
def test_a_wrong_unit_is_said_of_what_was_declared(name: str, unit: str, says: str) -> None:
    p = {each.name: replace(each, unit=unit if each.name == name else each.unit) for each in PARTS}
    friction = lugre(
        p["s0"], p["s1"], x, coulomb=p["Fc"], static=p["Fs"], velocity=p["vs"], name="bent"
    )
    with refuses("units", says):
        declared("wrong", tuple(p.values()), friction)


def test_what_a_loop_with_states_is_not_simulated_with_is_refused() -> None:
    lagging = dahl_axis(drive=Drive(gain=30.0, lag=1e-3))
    continuous = dahl_axis(control=cascade_pd(kp=60.0, kv=40.0, period=1e-3, continuous=True))
    pressed = Signal("pressed", "N")
    recorded = declared(
        "pressed", (s0, Fc), maxwell_slip(s0, Fc, x), pressed.symbol, signals=(pressed,)
    )
    for axis in (lagging, continuous, recorded):
        with refuses("equation"):
            derive(axis)


def test_a_parameter_that_is_left_out_is_so_in_the_states_too() -> None:
    axis = leave_out(replace(dahl_axis(), name="less"), Fc=15.0)
    (state,) = derive(axis).states
    assert [p.name for p in axis.parameters] == ["M", "s0", "Fv"]
    assert Fc.symbol not in state.rate.free_symbols
    assert Fv in axis.parameters
