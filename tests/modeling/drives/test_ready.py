"""Drives of a motor's figures and of formulas."""

from dataclasses import replace
from typing import Any

import pytest
import sympy

from axisid import Constant, Coordinate, Parameter
from axisid.elements import (
    CONTROL,
    DIRECTION,
    DRIVE_GAIN,
    FORCE,
    VELOCITY,
    back_emf,
    current_drive,
    formula_drive,
    viscous,
    voltage_drive,
)
from axisid.modeling.declaration import Axis, Drive
from tests.axes.bodies import body, x
from tests.refusals import refuses

MOTOR = {"kt": 0.05, "ratio": 50.0}
WINDING = {**MOTOR, "resistance": 1.25}
VOLTS_A_SPEED = 0.05 * 50.0


def made(drive: Drive, control: float, velocity: float) -> float:
    """The force at a velocity that is its own friction direction."""
    signals = {CONTROL: control, VELOCITY: velocity, DIRECTION: sympy.sign(velocity)}
    return float(drive.force.subs({**signals, **drive.constants}))


def undone(drive: Drive, force: float, velocity: float) -> float:
    signals = {FORCE: force, VELOCITY: velocity, DIRECTION: sympy.sign(velocity)}
    return float(drive.inverse.subs({**signals, **drive.constants}))


def linear(drive: Drive) -> Axis:
    return body(coordinate=x, drive=drive)


def test_a_voltage_makes_the_force_that_the_back_emf_leaves_of_it() -> None:
    drive = voltage_drive(ke=0.05, **WINDING)
    assert made(drive, 10.0, 2.0) == pytest.approx(2.5 / 1.25 * (10 - VOLTS_A_SPEED * 2))
    assert undone(drive, made(drive, 10.0, 2.0), 2.0) == pytest.approx(10.0)


def test_a_duty_is_so_many_volts() -> None:
    duty, volts = (
        voltage_drive(ke=0.05, volts=24.0, unit="1", **WINDING),
        voltage_drive(ke=0.05, **WINDING),
    )
    assert made(duty, 0.5, 1.3) == pytest.approx(made(volts, 12.0, 1.3))


@pytest.mark.parametrize(
    ("control", "velocity", "share"),
    [(3.0, 0.5, 0.8), (-3.0, -0.5, 0.8), (3.0, -0.5, 1.25), (-3.0, 0.5, 1.25)],
)
def test_a_gear_takes_its_share_of_the_power_on_either_way(
    control: float, velocity: float, share: float
) -> None:
    drive = current_drive(efficiency=0.8, **MOTOR)
    assert made(drive, control, velocity) == pytest.approx(share * 2.5 * control)
    assert undone(drive, made(drive, control, velocity), velocity) == pytest.approx(control)


def test_at_rest_a_gear_holds_what_is_within_its_efficiency_and_its_reciprocal() -> None:
    drive = current_drive(efficiency=0.8, **MOTOR)
    ends = [drive.force.subs({**drive.constants, CONTROL: 1, DIRECTION: s}) for s in (1, -1)]
    assert [float(end) for end in ends] == pytest.approx([0.8 * 2.5, 2.5 / 0.8])


def test_a_current_reaches_as_far_as_the_supply_leaves_room_at_a_speed() -> None:
    drive = current_drive(supply=10.0, resistance=1.25, limit=100.0, **MOTOR)
    for speed in (-3.0, 0.0, 3.0):
        forwards, backwards = made(drive, 100.0, speed), made(drive, -100.0, speed)
        assert forwards == pytest.approx(2.5 * (10 - VOLTS_A_SPEED * speed) / 1.25)
        assert backwards == pytest.approx(2.5 * (-10 - VOLTS_A_SPEED * speed) / 1.25)
    assert made(drive, 1.0, 1.0) == pytest.approx(2.5)


def test_a_torque_curve_of_ones_own_bounds_the_force_both_ways() -> None:
    drive = current_drive(reach=sympy.Min(8, 12 - 2 * VELOCITY), **MOTOR)
    assert [made(drive, u, v) for u, v in ((9, 0), (9, 5), (-9, 0), (-9, -5))] == [8, 2, -8, -2]


def test_a_motor_without_its_back_emf_is_a_gain_and_says_where_that_is() -> None:
    drive = voltage_drive(**WINDING)
    assert drive.is_gain
    assert not linear(drive).drives_by_motion
    assert "viscous friction" in drive.remark
    assert not voltage_drive(ke=0.05, **WINDING).remark


def test_an_identified_back_emf_is_a_viscous_friction_of_its_size() -> None:
    q, ke = Coordinate("q", unit="rad"), Parameter("ke", "V/(rad/s)")
    term = back_emf(ke, q, **WINDING)
    numbers = {s: s.value for s in term.free_symbols if hasattr(s, "value")}
    assert float(term.subs(numbers) / ke.symbol / q.velocity) == pytest.approx(0.05 * 50**2 / 1.25)
    fv = Parameter("fv", "N m/(rad/s)")
    axis = body(term, viscous(fv, q), coordinate=q, inertia=_J, parameters=(ke, fv))
    assert not axis.unchecked_terms


_J = Parameter("J", "kg m^2", nominal=1.0)
_KT, _N = Constant(0.05, "N m/A"), Constant(1257.0, "rad/m")


@pytest.mark.parametrize(
    ("code", "figures"),
    [
        ("drive", {**WINDING, "efficiency": 1.2}),
        ("drive", {**WINDING, "efficiency": 0.0}),
        ("drive", {**WINDING, "resistance": 0.0}),
        ("drive", {**WINDING, "kt": -1.0}),
        ("drive", {**WINDING, "inductance": -1e-3}),
        ("drive", {**WINDING, "kt": Constant(1.0, "N")}),
        ("drive", {**WINDING, "resistance": Constant(1.0, "A")}),
        ("drive", {**WINDING, "gain": 2.0}),
        ("drive", {**WINDING, "lag": 1e-3}),
        ("drive", {**WINDING, "ke": 0.05, "inductance": 1e-3, "logged": "current"}),
        ("drive", {**WINDING, "kt": Constant(10.0, "N/A")}),
        ("drive", {**WINDING, "ke": Constant(10.0, "V/(m/s)")}),
        ("drive", {**WINDING, "kt": _KT, "ratio": 1.0}),
        ("drive", {**WINDING, "kt": _KT, "ratio": Constant(50.0, "1")}),
    ],
)
def test_figures_that_contradict_are_refused(code: str, figures: dict[str, Any]) -> None:
    with refuses(code):
        linear(voltage_drive(**figures))


@pytest.mark.parametrize(
    "figures",
    [{"supply": 10.0}, {"resistance": 1.0}, {"supply": 1.0, "resistance": 1.0, "reach": 2}],
)
def test_a_limit_of_the_supply_is_given_once_and_whole(figures: dict[str, Any]) -> None:
    with refuses("drive"):
        current_drive(**MOTOR, **figures)


def test_figures_with_units_fit_where_the_gear_turns_one_into_the_other() -> None:
    axis = linear(voltage_drive(kt=_KT, resistance=Constant(1.25, "V/A"), ratio=_N))
    assert axis.drive.gain == pytest.approx(0.05 * 1257 / 1.25)
    with refuses("drive"):
        replace(axis, drive=current_drive(**MOTOR, reach=Constant(3.0, "V").symbol))


BRAKED = DRIVE_GAIN * CONTROL - 40 * VELOCITY


def test_the_inverse_of_a_straight_line_follows() -> None:
    drive = formula_drive(BRAKED, gain=12.0)
    assert sympy.simplify(drive.inverse - (FORCE + 40 * VELOCITY) / DRIVE_GAIN) == 0
    assert drive.constants == {DRIVE_GAIN: 12.0}


def test_the_motion_is_the_axiss_own_or_that_of_any() -> None:
    for velocity in (VELOCITY, x.velocity):
        axis = body(coordinate=x, drive=formula_drive(3 * CONTROL - 2 * velocity))
        assert axis.drives_by_motion
        assert "2*dx" in axis.drive.force_text(x).replace("dot x", "dx")


def test_what_no_inverse_follows_from_is_refused() -> None:
    with refuses("drive"):
        formula_drive(CONTROL**3)


def test_symbols_and_units_of_the_formulas_are_checked() -> None:
    with refuses("drive", says="heat"):
        body(drive=formula_drive(sympy.Symbol("heat") * CONTROL))
    with refuses("drive"):
        body(drive=formula_drive(Constant(3.0, "N m/V").symbol * CONTROL))
    assert body(drive=formula_drive(Constant(3.0, "N/V").symbol * CONTROL)).drive.force == (
        3.0 * CONTROL
    )
