"""The machines of the field move as the axes that are declared of them, faults apart."""

from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
import pytest

from axisid import simulate
from benchmarks.machines import Machine, autoregressive, records

field: Any = import_module("field")


@pytest.mark.slow
@pytest.mark.parametrize(
    "machine",
    [
        Machine(coulomb=40.0),
        Machine(offset=150.0, coulomb=40.0),
        Machine(kp=25.0, kv=150.0, tn=0.05),
        Machine(kp=1200.0, ki=4000.0, kd=80.0),
        Machine(kp=15.0, kv=100.0, tn=0.1, period=5e-3),
    ],
    ids=["cascade", "weight", "P-PI", "PID", "P-PI, 5 ms"],
)
def test_a_machine_under_each_law_moves_and_rests_as_its_axis_is_simulated(
    machine: Machine,
) -> None:
    case = field.Case(machine=machine, declared=machine)
    reference = field.reference_of(case.motion, machine.period)[: round(3.2 / machine.period)]
    loop = simulate(case.axis, [*case.truth.values()], reference, machine.period)
    (columns,) = records(machine, reference, 1, seed=1)
    np.testing.assert_allclose(columns["position"], loop.position, atol=1e-7)
    np.testing.assert_allclose(columns["control"], loop.control, atol=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["stage", "P-PI", "PID"])
def test_every_fault_changes_what_is_recorded(name: str) -> None:
    drawn = field.axes_of_faults(1)[name]
    plain = replace(drawn, motion=drawn.motion._replace(seconds=3.0))
    (own,) = plain.records(1, 1)
    for fault, (change, _) in field.FAULTS.items():
        case = change(plain)
        (record,) = case.records(1, 1)
        rows = len(record)
        force = (record.control - own.control[:rows]) / own.control.std()
        motion = (record.position - own.position[:rows]) / own.position.std()
        assert max(np.abs(force).max(), np.abs(motion).max()) > 0.01, fault
        assert case.axis is plain.axis


def test_a_stuck_machine_breaks_away_at_what_its_friction_is_at_rest() -> None:
    sticky = Machine(coulomb=20.0, shape=lambda _, v: 1.0 + 0.3 * np.exp(-v / 0.01))
    held, moved = (_pushed(sticky, share * 20.0 / sticky.gain, 0.2) for share in (1.29, 1.31))
    assert not held.any()
    assert moved[-1] > 0


def test_machines_are_drawn_anew_from_a_seed_and_alike_from_the_same() -> None:
    assert [*field.drawn(3, 4)] == [*field.drawn(3, 4)]
    assert not {*field.drawn(3, 4)} & {*field.drawn(4, 4)}


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_drawn_machines_follow_their_motion_within_their_limits(seed: int) -> None:
    for name, case in field.drawn(seed, 7).items():
        (record,) = case.records(1, 1)
        assert np.abs(record.control).max() < case.machine.limit, name
        lag = np.abs(record.position - record.reference).max() / case.motion.speed
        assert lag < 0.2, name


def test_autoregressive_noise_has_its_deviation_and_its_time(rng: np.random.Generator) -> None:
    noise = autoregressive(2.0, 0.05, 1e-3)(rng, 200, 2000)
    assert noise.std() == pytest.approx(2.0, rel=0.05)
    assert noise[:, 0].std() == pytest.approx(2.0, rel=0.2)
    shared = np.mean(noise[:, 50:] * noise[:, :-50]) / noise.var()
    assert shared == pytest.approx(np.exp(-1), abs=0.05)


def test_a_load_behind_a_spring_swings_at_its_frequency_and_is_carried_along() -> None:
    """Beside a free axis, as two masses do, and with nothing lost that nothing takes."""
    free = Machine(
        viscous=0.0, coulomb=0.0, kp=0.0, kv=0.0, load=40.0, antiresonance=35.0, load_damping=0.0
    )
    push = replace(free, injected=np.where(np.arange(2000) < 40, 5.0, 0.0))
    (columns,) = records(push, np.zeros(2000), 1, seed=1)
    velocity = np.gradient(columns["position"], 1e-3)[60:]
    expected = 0.04 * 5.0 * push.gain / push.mass
    assert velocity.mean() == pytest.approx(expected, rel=0.01)
    swing = np.abs(np.fft.rfft((velocity - velocity.mean()) * np.hanning(len(velocity)), 1 << 16))
    frequency = np.fft.rfftfreq(1 << 16, 1e-3)[np.argmax(swing)]
    assert frequency == pytest.approx(35.0 * np.sqrt(100 / 60), rel=0.01)


def _pushed(machine: Machine, volts: float, seconds: float) -> np.ndarray:
    """Velocities of an axis without a law under a constant control."""
    samples = round(seconds / machine.period)
    free = replace(machine, kp=0.0, kv=0.0, injected=np.full(samples, volts))
    (columns,) = records(free, np.zeros(samples), 1, seed=1)
    return np.gradient(columns["position"], machine.period)[1:-1]


def test_a_load_within_its_play_is_not_moved_and_beyond_it_is() -> None:
    machine = Machine(viscous=0.0, coulomb=0.0, load=40.0, antiresonance=80.0, play=0.02)
    free = replace(machine, load_damping=0.3)
    velocity = _pushed(free, 1.0, 0.5)
    touched = np.flatnonzero(np.cumsum(velocity) * free.period > 0.01)[0]
    time = free.period * np.arange(1, len(velocity) + 1)
    np.testing.assert_allclose(velocity[: touched - 5], (free.gain / 60 * time)[: touched - 5])
    assert velocity[-1] < 0.8 * free.gain / 60 * time[-1]


def test_a_loss_by_the_load_is_a_share_of_the_force_and_wear_is_one_of_friction() -> None:
    steady = Machine(viscous=1000.0, loss=0.1, friction_at=lambda _: 1.2)
    expected = (0.9 * 2 * steady.gain - 1.2 * steady.coulomb) / (1.2 * steady.viscous)
    assert _pushed(steady, 2.0, 2.0)[-1] == pytest.approx(expected, rel=1e-6)


def test_samples_that_jitter_are_even_on_average() -> None:
    plain = Machine(viscous=0.0, coulomb=0.0)
    even, uneven = (_pushed(replace(plain, clock_jitter=j), 1.0, 1.0) for j in (0.0, 0.2))
    assert np.abs(uneven / even - 1)[200:].max() > 0.01
    assert np.sum(uneven) == pytest.approx(np.sum(even), rel=0.002)
