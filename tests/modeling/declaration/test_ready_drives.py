"""Drives of a motor's figures and of formulas.

What of drives, their times and the gains of ready laws is refused, each with its sentence.
"""

import math
from dataclasses import replace
from typing import Any

import pytest
import sympy

from axisid import Axis, Constant, Coordinate, Parameter
from axisid.codegen.generated_axes import GeneratedAxis, build
from axisid.control import cascade_p_pi
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
from axisid.estimation.simulation import gains_by_lane
from axisid.modeling.declaration import Drive
from tests.axes.bodies import body, x
from tests.axes.lagging import PERIOD, lagging
from tests.refusals import refused, refuses

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


#: Figures of a voltage drive that contradict, and the code of what is said of them.
CONTRADICTING: list[tuple[str, dict[str, Any]]] = [
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
]


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


def test_symbols_and_units_of_the_formulas_are_checked() -> None:
    with refuses("drive", says="heat"):
        body(drive=formula_drive(sympy.Symbol("heat") * CONTROL))
    with refuses("drive"):
        body(drive=formula_drive(Constant(3.0, "N m/V").symbol * CONTROL))
    assert body(drive=formula_drive(Constant(3.0, "N/V").symbol * CONTROL)).drive.force == (
        3.0 * CONTROL
    )


KT = {"kt": 0.05}
WOUND = {**KT, "resistance": 1.25}
GAINS = {"kp": 160.0, "kv": 243.0, "period": PERIOD}


def _timed(name: str = "Tc", **declared: float) -> Axis:
    return lagging(lag=Parameter(name, "s", **{"nominal": 5e-4, **declared}))


test_what_a_drive_or_a_ready_law_cannot_be_is_refused = refused(
    [
        *((code, "", lambda own=own: linear(voltage_drive(**own))) for code, own in CONTRADICTING),
        ("drive", "", lambda: current_drive(**MOTOR, supply=10.0)),
        ("drive", "", lambda: current_drive(**MOTOR, resistance=1.0)),
        ("drive", "", lambda: current_drive(**MOTOR, supply=1.0, resistance=1.0, reach=2)),
        ("drive", "", lambda: formula_drive(CONTROL**3)),
        ("drive", "", lambda: lagging(delay=1e6)),
        ("drive", "", lambda: _timed(upper=0.6e-3)),
        ("drive", "", lambda: _timed(lower=1e-4)),
        ("drive", "", lambda: _timed(known=5e-4, known_sd=1e-5)),
        ("drive", "", lambda: _timed(known=5e-4)),
        ("axis", "", lambda: _timed("Fv")),
        ("axis", "", lambda: _timed("q")),
        ("axis", "", lambda: current_drive(**WOUND, supply=None)),  # type: ignore[arg-type]
        ("axis", "", lambda: current_drive(**KT, supply=math.nan)),
        ("drive", "", lambda: current_drive(**WOUND, supply=-24.0)),
        ("drive", "", lambda: current_drive(**WOUND, supply=Constant(24.0, "A"))),
        ("drive", "", lambda: current_drive(**KT, ke=0.05)),
        ("drive", "", lambda: current_drive(**KT, ke=0.05, reach=3.0)),
        ("drive", "", lambda: current_drive(**KT, reach=math.nan)),
        ("drive", "", lambda: current_drive(**KT, reach=-3.0)),
        ("drive", "", lambda: current_drive(**KT, reach=2 * VELOCITY)),
        ("drive", "", lambda: current_drive(**KT, reach=1 / VELOCITY)),
        ("drive", "", lambda: voltage_drive(**WOUND, reach=3.0)),
        ("drive", "", lambda: current_drive(**KT, gear=3.0)),
        ("drive", "", lambda: formula_drive(sympy.Symbol("u"), friction=1.0)),
        ("drive", "", lambda: voltage_drive(**WOUND, volts=Constant(24.0, "V"))),
        ("drive", "", lambda: voltage_drive(**WOUND, unit="A")),
        ("drive", "", lambda: current_drive(**KT, unit="V")),
        ("drive", "", lambda: current_drive(**KT, efficiency=1e-9)),
        ("axis", "", lambda: cascade_p_pi(**GAINS, speed_limit=-math.inf)),
        ("law", "", lambda: cascade_p_pi(**GAINS, feed_forward=math.nan)),
        ("law", "", lambda: replace(cascade_p_pi(**GAINS, tn=0.1), positive=("ki",))),
    ]
)


@pytest.fixture(scope="module")
def cascaded() -> GeneratedAxis:
    return build(replace(lagging(), control=cascade_p_pi(**GAINS, tn=0.1)), native=False)


@pytest.mark.parametrize(
    ("code", "says", "gains"),
    [
        ("simulation-input", "shape", {"kp": [1.0, 2.0]}),
        ("simulation-input", "kp of lane 1 is nan", {"kp": [1.0, math.nan, 2.0]}),
        ("simulation-input", "kp is inf", {"kp": math.inf}),
        ("simulation-input", "tn of lane 2 is 0", {"tn": [1.0, 2.0, 0.0]}),
    ],
)
def test_gains_that_a_lane_cannot_have_are_named(
    cascaded: GeneratedAxis, code: str, says: str, gains: dict[str, Any]
) -> None:
    with refuses(code, says):
        gains_by_lane(cascaded, gains, 3)


def test_another_gain_keeps_to_the_range_of_its_law(cascaded: GeneratedAxis) -> None:
    with refuses("law", "'tn'"):
        cascaded.with_gains({"tn": -0.1})
    assert cascaded.with_gains({"tn": 0.2, "kp": -1.0}).axis.control is not None
