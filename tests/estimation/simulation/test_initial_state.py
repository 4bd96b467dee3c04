"""Loops that start in motion, and drives that remember something at the start."""

from dataclasses import replace

import numpy as np
import pytest

from axisid import build, newton, simulate
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.control import (
    BALANCED,
    MEASURED_POSITION,
    PERIOD,
    REFERENCE,
    ControlLaw,
    Memory,
    gain,
)
from axisid.elements import Drive, coulomb, offset, viscous
from axisid.estimation import simulate_batch
from benchmarks.event_integrator import EventIntegrator
from tests.axes.simulated import AXES, F0, Fc, Fv, M, q
from tests.estimation.simulation.agreement import LANES, agree

T = 1e-3
THETA = np.array([100.2, 236.9, 24.8, 300.0])


def p_pi(start: object, delay: int = 0) -> ControlLaw:
    """A velocity loop with an integral under a position loop, as drives have it."""
    last = Memory("last", MEASURED_POSITION, MEASURED_POSITION)
    velocity = (MEASURED_POSITION - last.symbol) / PERIOD
    error = gain("kp") * (REFERENCE - MEASURED_POSITION) - velocity
    total = Memory("total", gain("total") + gain("ki") * PERIOD * error, start)
    return ControlLaw(
        name="P-PI",
        period=T,
        gains={"kp": 40.0, "kv": 150.0, "ki": 4000.0},
        output=gain("kv") * error + total.symbol,
        memory=(last, total),
        delay=delay,
    )


def stage(law: ControlLaw, *, native: bool = True) -> GeneratedAxis:
    """A stage that carries a load."""
    axis = newton(
        "vertical",
        coordinate=q,
        parameters=(M, Fv, Fc, F0),
        inertia=M,
        resistance=(viscous(Fv, q), coulomb(Fc, q), offset(F0)),
        drive=Drive(gain=35.15, limit=100.0),
        control=law,
    )
    return build(axis, native=native)


def vertical(start: object = 0, delay: int = 0, *, native: bool = True) -> GeneratedAxis:
    """Under an integral."""
    return stage(p_pi(start, delay), native=native)


def by_events(
    reference: np.ndarray,
    period: float,
    times: np.ndarray,
    start: tuple[float, float] | None = None,
    memory: tuple[float, float] | None = None,
) -> np.ndarray:
    """Positions of the stage under its P-PI law at any times, reversals located."""
    mass, damping, friction, load = map(float, THETA)
    position, velocity = start or (float(reference[0]), 0.0)
    body = EventIntegrator(
        lambda _, v, tau, s, __: (tau - load - damping * v - friction * s) / mass,
        position,
        v=velocity,
    )
    last, total = memory or (position, load / 35.15)
    out = np.empty(len(times))
    for k, r in enumerate(reference):
        error = 40.0 * (r - body.q) - (body.q - last) / period
        force = 35.15 * float(np.clip(150.0 * error + total, -100.0, 100.0))
        last, total, now = body.q, total + 4000.0 * period * error, 0.0
        inside = (times >= k * period - 1e-12) & (times < (k + 1) * period - 1e-12)
        for i in np.flatnonzero(inside):
            since = max(float(times[i]) - k * period, 0.0)
            body.advance(lambda *_, force=force: force, since - now, held=True)
            out[i], now = body.q, since
        body.advance(lambda *_, force=force: force, period - now, held=True)
    return out


@pytest.mark.slow
@pytest.mark.parametrize("velocity", [0.15, -0.05, 0.0])
def test_a_loop_that_starts_in_motion_follows_an_independent_integrator(velocity: float) -> None:
    reference = 0.01 * np.sin(2 * np.pi * 4 * T * np.arange(200))
    memory = (0.002 - velocity * T, 300.0 / 35.15 + 1.0)
    expected = by_events(reference, T, T * np.arange(200), (0.002, velocity), memory)
    for native in (True, False):
        axis = vertical(native=native)
        loop = simulate(
            axis, THETA, reference, T, start=0.002, start_velocity=velocity, memory=[*memory]
        )
        assert np.abs(loop.position - expected).max() < 1e-10
        assert loop.velocity[0] == velocity
        assert loop.direction_before[0] == loop.direction[0]


@pytest.mark.slow
@pytest.mark.parametrize("name", AXES)
def test_lanes_start_each_in_its_own_way(name: str) -> None:
    axis, rng = build(AXES[name]), np.random.default_rng(3)
    law = axis.axis.control
    reference = 0.01 * np.sin(30 * law.period * np.arange(60))
    velocity = np.where(np.arange(LANES) % 3, 0.05 * rng.normal(size=LANES), 0.0)
    memory = 1e-4 * rng.normal(size=(LANES, len(law.memory) + law.delay))
    given = np.tile(axis.nominal, (LANES, 1)), reference, law.period
    own = {"start_velocity": velocity, "memory": memory}
    agree(axis, *given, machine=build(AXES[name], native=False), **own)


@pytest.mark.slow
@pytest.mark.parametrize("delay", [0, 2])
@pytest.mark.parametrize("native", [True, False], ids=["native", "virtual machine"])
def test_an_integral_in_balance_holds_the_load(delay: int, native: bool) -> None:
    reference = np.full(300, 0.1)
    loop = simulate(vertical(BALANCED, delay, native=native), THETA, reference, T)
    assert np.all(loop.position == 0.1)
    assert loop.control == pytest.approx(300.0 / 35.15)
    dropped = simulate(vertical(0, delay, native=native), THETA, reference, T)
    assert np.ptp(dropped.position) > 1e-4
    lanes = np.array([THETA, THETA * [1, 1, 1, -2]])
    batch = simulate_batch(vertical(BALANCED, delay, native=native), lanes, reference, T)
    assert np.all(batch["position"] == 0.1)


@pytest.mark.parametrize("native", [True, False])
def test_a_law_between_two_counts_remembers_what_its_encoder_measured(native: bool) -> None:
    axis, count, reference = vertical(BALANCED, native=native), 1e-4, np.full(20, 0.1 + 4e-5)
    loop = simulate(axis, THETA, reference, T, resolution=count)
    batch = simulate_batch(
        axis, [THETA], reference, T, resolution=count, wanted=("control", "position")
    )
    for control in (loop.control, batch["control"][:, 0]):
        assert control[0] == pytest.approx(300.0 / 35.15, rel=1e-12)
        # From there the integral follows the part of a count that is measured: 6.4 mA a sample.
        assert np.diff(control[:5]) == pytest.approx(40.0 * 4e-5 * 4000.0 * T, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("path", [{"lag": 2e-3}, {"delay": 1.5e-3}, {"rate_limit": 1e3}])
def test_a_drive_that_rounds_begins_with_the_force_of_a_command(path: dict[str, float]) -> None:
    drive = Drive(gain=35.15, limit=100.0, quantisation=0.5, **path)
    axis = build(replace(vertical(BALANCED).declared, drive=drive))
    loop = simulate(axis, THETA, np.full(20, 0.1), T)
    # 300 N are 8.53 A, and the nearest command that acts 8.5 A.
    assert loop.control[0] == pytest.approx(300.0 / 35.15)
    assert loop.force[:3] == pytest.approx(8.5 * 35.15)
