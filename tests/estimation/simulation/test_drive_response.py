"""Drives that lag, are late or follow the motion, against integrators of their own."""

from functools import cache
from typing import Any

import numpy as np
import pytest

from axisid import build, simulate
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.elements import CONTROL, DRIVE_GAIN, VELOCITY, Drive, current_drive, formula_drive
from axisid.estimation import simulate_batch
from axisid.estimation.signals import through_path
from axisid.estimation.simulation.simulated_signals import forces_about, signals_about
from benchmarks.motor_joint import (
    MOTOR,
    OHMS,
    PERIOD as JOINT_PERIOD,
    TRUTH,
    Motor,
    integrated as joint_integrated,
    joint,
    on_voltage,
)
from tests.axes.bodies import body, force_law, x
from tests.axes.lagging import GAIN, PERIOD, THETA, integrated, lagging
from tests.estimation.simulation.agreement import LANES, agree
from tests.refusals import refuses

TIME = PERIOD * np.arange(420)
REFERENCE = 2e-3 * np.sin(2 * np.pi * 6.0 * TIME) ** 3  # with rests and reversals
TIMINGS = [
    (1e-3, 0.0),
    (0.0, 3.5e-4),
    (0.0, 1e-3),
    (8e-4, 3.5e-4),
    (5e-5, 2.2e-3),
]


@cache
def axis(lag: float, delay: float, *, native: bool) -> GeneratedAxis:
    """The axis with a lag and a delay."""
    return build(lagging(lag=lag, delay=delay), native=native)


@pytest.mark.slow
@pytest.mark.parametrize("native", [True, False])
@pytest.mark.parametrize(("lag", "delay"), TIMINGS)
def test_loop_moves_as_an_independent_integrator_does(
    lag: float, delay: float, native: bool
) -> None:
    loop = simulate(axis(lag, delay, native=native), THETA, REFERENCE, PERIOD)
    position, force = integrated(REFERENCE, lag, delay)
    assert np.any(loop.mode == 0)
    assert np.sum(np.diff(np.sign(loop.velocity)) != 0) >= 5
    assert np.max(np.abs(loop.position - position)) < 1e-9
    if lag:
        assert np.max(np.abs(loop.force - force)) < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("timing", [{}, {"lag": 8e-4, "delay": 3.5e-4}])
def test_a_command_passes_rate_limit_steps_and_dead_band_before_it_acts(
    timing: dict[str, float],
) -> None:
    path: dict[str, Any] = {"rate_limit": 150.0, "quantisation": 0.02, "deadband": 0.4}
    made = build(lagging(**path, **timing))
    position, force = integrated(REFERENCE, *(timing.get(t, 0.0) for t in ("lag", "delay")), **path)
    loop = simulate(made, THETA, REFERENCE, PERIOD)
    virtual = simulate(build(lagging(**path, **timing), native=False), THETA, REFERENCE, PERIOD)
    assert np.max(np.abs(np.diff(loop.control))) > 0.15
    assert np.max(np.abs(loop.position - position)) < 1e-9
    assert np.max(np.abs(virtual.position - position)) < 1e-9
    if timing:
        assert np.max(np.abs(loop.force - force)) < 1e-3
    else:
        acting = through_path(made.axis.drive.path, loop.control, PERIOD)
        assert np.allclose(loop.force, GAIN * acting, rtol=0, atol=1e-12)
    batch = simulate_batch(made, np.tile(THETA, (33, 1)), np.tile(REFERENCE, (33, 1)).T, PERIOD)
    assert np.max(np.abs(batch["position"][:, 32] - position)) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize(("lag", "delay"), TIMINGS)
def test_lanes_of_a_batch_are_the_single_simulations(lag: float, delay: float) -> None:
    sizes = np.linspace(0.2, 1.5, LANES)
    thetas, references = THETA * (0.8 + 0.4 * sizes[:, None] / 1.5), REFERENCE[:, None] * sizes
    for substeps in (1, 3):
        agree(axis(lag, delay, native=True), thetas, references, PERIOD, substeps=substeps)


def test_the_mean_force_is_what_changes_the_momentum() -> None:
    made = axis(8e-4, 3.5e-4, native=True)
    sliding = np.array([THETA[0], 0.0, 0.0])
    loop = simulate(made, sliding, REFERENCE, PERIOD)
    change = THETA[0] * np.diff(loop.velocity) / PERIOD
    assert np.allclose(forces_about(made, loop)[0][:-1], change, rtol=0, atol=1e-6)


@pytest.mark.slow
def test_a_simulation_goes_on_from_what_the_drive_remembers() -> None:
    made = axis(8e-4, 1.35e-3, native=True)
    names = made.functions["closed_loop_step"].size1_in("state")
    with refuses("simulation-input", "force_of_command1"):
        simulate(made, THETA, REFERENCE, PERIOD, memory=np.zeros(names - 1))
    pushed = np.zeros(names)
    pushed[-1] = 100.0
    loop = simulate(made, THETA, np.zeros(5), PERIOD, memory=pushed)
    assert loop.force[0] == 100.0
    assert loop.position[2] > 0


JOINT = np.array(list(TRUTH.values()))
SWINGS = (
    0.06 * np.sin(2 * np.pi * 12.0 * JOINT_PERIOD * np.arange(150)) ** 3
)  # with rests and reversals
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
def test_a_motor_moves_as_an_independent_integrator_does(name: str) -> None:
    motor, _, allowed = CASES[name]
    loop = simulate(made(name), JOINT, SWINGS, JOINT_PERIOD)
    wanted = joint_integrated(motor, SWINGS, np.zeros_like(SWINGS))
    assert np.sum(np.diff(np.sign(loop.velocity)) != 0) >= 3
    assert np.max(np.abs(loop.position - wanted["position"])) < allowed * np.ptp(SWINGS)
    assert np.max(np.abs(loop.control)) < 24.0


@pytest.mark.parametrize("name", ["voltage", "gear", "supply"])
def test_signals_before_and_after_a_sample_satisfy_the_model(name: str) -> None:
    axis = made(name)
    loop = simulate(axis, JOINT, SWINGS, JOINT_PERIOD)
    after, before = signals_about(axis, JOINT, loop)
    np.testing.assert_allclose(after.force, loop.force, rtol=0, atol=1e-12)
    sliding = (loop.velocity != 0) & (np.abs(np.diff(loop.control, prepend=0)) > 0)
    if name == "voltage":
        braking = 0.05 * MOTOR["ratio"] * loop.velocity[1:]
        wanted = axis.axis.drive.gain * (loop.control[:-1] - braking)
        np.testing.assert_allclose(before.force[1:], wanted, rtol=0, atol=1e-12)
    for side in (after, before):
        motion = side.position, side.velocity, side.acceleration, side.direction
        needed = axis.evaluate("inverse_dynamics", *motion, JOINT)[0][:, 0]
        np.testing.assert_allclose(needed[sliding], side.force[sliding], rtol=0, atol=1e-9)


def test_a_load_within_the_gears_reach_is_held_and_beyond_it_moves() -> None:
    """At rest the loss is as set-valued as friction: 1 N at the motor holds 0.5 to 2 N of load."""
    drive = current_drive(kt=1.0, efficiency=0.5)
    for load, held in ((0.6, True), (1.9, True), (0.4, False), (2.1, False)):
        axis = build(body(load, coordinate=x, control=force_law(), drive=drive), native=False)
        loop = simulate(axis, [1.0], np.ones(30), JOINT_PERIOD, start=1.0)
        assert np.all(loop.velocity == 0.0) == held
        share = load if held else 0.5 if load < 1 else 2.0
        assert loop.force[20] == pytest.approx(share)


@pytest.mark.parametrize("delay", [1e-3, 3.5e-4, 2.3e-3])
def test_a_late_command_brakes_with_the_motion_of_its_time(delay: float) -> None:
    """Of a force without the motion, a mass alone: what the drive's own braking makes of steps."""
    drive = formula_drive(DRIVE_GAIN * CONTROL - 3 * VELOCITY, delay=delay)
    axis = build(body(coordinate=x, control=force_law(), drive=drive), native=False)
    reference = np.where(np.arange(60) >= 10, 2.0, 0.0)
    loop = simulate(axis, [1.0], reference, JOINT_PERIOD, start=0.0)
    since = np.maximum(JOINT_PERIOD * np.arange(60) - 10 * JOINT_PERIOD - delay, 0.0)
    np.testing.assert_allclose(loop.velocity, 2 / 3 * (1 - np.exp(-3 * since)), atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_native_code_and_batches_are_the_virtual_machine(name: str) -> None:
    thetas = JOINT * np.linspace(0.8, 1.2, LANES)[:, None]
    agree(build(joint(CASES[name][1])), thetas, SWINGS, JOINT_PERIOD, machine=made(name))
