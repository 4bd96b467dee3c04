"""Drives whose force follows the motion, against an integrator that shares nothing with them."""

from functools import cache

import numpy as np
import pytest

from axisid import build, simulate
from axisid.codegen.artefacts import GeneratedAxis
from axisid.elements import CONTROL, DRIVE_GAIN, VELOCITY, Drive, current_drive, formula_drive
from axisid.estimation.simulation.simulated import signals_about
from benchmarks.motor_joint import MOTOR, OHMS, PERIOD, TRUTH, Motor, integrated, joint, on_voltage
from tests.axes.bodies import body, force_law, x
from tests.estimation.simulation.agreement import LANES, agree
from tests.refusals import refuses

THETA = np.array(list(TRUTH.values()))
TIME = PERIOD * np.arange(150)
REFERENCE = 0.06 * np.sin(2 * np.pi * 12.0 * TIME) ** 3  # with rests and reversals
SUPPLY = 4.0
CASES: dict[str, tuple[Motor, Drive, float]] = {
    "voltage": (Motor(), on_voltage(), 1e-9),
    "gear": (Motor(efficiency=0.7), on_voltage(efficiency=0.7), 1e-8),
    "supply": (
        Motor(supply=SUPPLY),
        current_drive(**MOTOR, supply=SUPPLY, resistance=OHMS),
        1e-5,  # where the limit is reached within a sample is not located
    ),
    "inductance": (Motor(lag=5e-4), on_voltage(inductance=5e-4 * OHMS), 4e-5),
}


@cache
def made(name: str) -> GeneratedAxis:
    return build(joint(CASES[name][1]), native=False)


@pytest.mark.parametrize("name", CASES)
def test_the_loop_moves_as_an_independent_integrator_does(name: str) -> None:
    motor, _, allowed = CASES[name]
    loop = simulate(made(name), THETA, REFERENCE, PERIOD)
    wanted = integrated(motor, REFERENCE, np.zeros_like(REFERENCE))
    assert np.sum(np.diff(np.sign(loop.velocity)) != 0) >= 3
    assert np.max(np.abs(loop.position - wanted["position"])) < allowed * np.ptp(REFERENCE)
    assert np.max(np.abs(loop.control)) < 24.0


@pytest.mark.parametrize("name", ["voltage", "gear", "supply"])
def test_signals_before_and_after_a_sample_satisfy_the_model(name: str) -> None:
    axis = made(name)
    loop = simulate(axis, THETA, REFERENCE, PERIOD)
    after, before = signals_about(axis, THETA, loop)
    np.testing.assert_allclose(after.force, loop.force, rtol=0, atol=1e-12)
    sliding = (loop.velocity != 0) & (np.abs(np.diff(loop.control, prepend=0)) > 0)
    if name == "voltage":
        braking = 0.05 * MOTOR["ratio"] * loop.velocity[1:]
        wanted = axis.axis.drive.gain * (loop.control[:-1] - braking)
        np.testing.assert_allclose(before.force[1:], wanted, rtol=0, atol=1e-12)
    for side in (after, before):
        motion = side.position, side.velocity, side.acceleration, side.direction
        needed = axis.evaluate("inverse_dynamics", *motion, THETA)[0][:, 0]
        np.testing.assert_allclose(needed[sliding], side.force[sliding], rtol=0, atol=1e-9)


def test_a_load_within_the_gears_reach_is_held_and_beyond_it_moves() -> None:
    """At rest the loss is as set-valued as friction: 1 N at the motor holds 0.5 to 2 N of load."""
    drive = current_drive(kt=1.0, efficiency=0.5)
    for load, held in ((0.6, True), (1.9, True), (0.4, False), (2.1, False)):
        axis = build(body(load, coordinate=x, control=force_law(), drive=drive), native=False)
        loop = simulate(axis, [1.0], np.ones(30), PERIOD, start=1.0)
        assert np.all(loop.velocity == 0.0) == held
        share = load if held else 0.5 if load < 1 else 2.0
        assert loop.force[20] == pytest.approx(share)


@pytest.mark.parametrize("delay", [1e-3, 3.5e-4, 2.3e-3])
def test_a_late_command_brakes_with_the_motion_of_its_time(delay: float) -> None:
    """Of a force without the motion, a mass alone: what the drive's own braking makes of steps."""
    drive = formula_drive(DRIVE_GAIN * CONTROL - 3 * VELOCITY, delay=delay)
    axis = build(body(coordinate=x, control=force_law(), drive=drive), native=False)
    reference = np.where(np.arange(60) >= 10, 2.0, 0.0)
    loop = simulate(axis, [1.0], reference, PERIOD, start=0.0)
    since = np.maximum(PERIOD * np.arange(60) - 10 * PERIOD - delay, 0.0)
    np.testing.assert_allclose(loop.velocity, 2 / 3 * (1 - np.exp(-3 * since)), atol=1e-12)


def test_a_loop_whose_drive_follows_the_motion_runs_at_its_own_clock() -> None:
    with refuses("loop-period"):
        simulate(made("voltage"), THETA, REFERENCE[::2], 2 * PERIOD)


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_native_code_and_batches_are_the_virtual_machine(name: str) -> None:
    thetas = THETA * np.linspace(0.8, 1.2, LANES)[:, None]
    agree(build(joint(CASES[name][1])), thetas, REFERENCE, PERIOD, machine=made(name))
