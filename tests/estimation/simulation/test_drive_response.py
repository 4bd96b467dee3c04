"""A drive with a lag and a delay, against an independent integrator, one by one and in a batch."""

from functools import cache
from typing import Any

import numpy as np
import pytest

from axisid import build, simulate
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.signals import through_path
from axisid.estimation.simulation.batch import simulate_batch
from axisid.estimation.simulation.simulated import forces_about
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


def test_a_loop_with_a_response_runs_at_its_own_clock_alone() -> None:
    with refuses("loop-period"):
        simulate(axis(1e-3, 0.0, native=True), THETA, REFERENCE[::2], 2 * PERIOD)


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
