"""A loop counts as running away by what moves it: its reference, its load, noise and counts."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from axisid import build, simulate
from axisid.codegen import GeneratedAxis
from axisid.control import MEASURED_VELOCITY, ControlLaw, cascade_pd
from axisid.elements import Drive, gravity, viscous
from axisid.estimation import simulate_batch
from tests.axes.bodies import M, b, body, q
from tests.refusals import refuses

PERIOD, KP, MASS, GRAVITY, SAG = 1e-3, 40.0, 1.0, 9.80665, 2.3e-3
KV = MASS * GRAVITY / (KP * SAG)
TIME = PERIOD * np.arange(1500)
SMALL = 1e-5 * np.sin(2 * np.pi * TIME)
THETA = np.array([MASS, 1.0])


@cache
def vertical(sign: float = 1.0, kind: str = "cascade") -> GeneratedAxis:
    """A weight on an axis whose loop has no integral part, so that it hangs below its reference."""
    cascade = cascade_pd(kp=KP, kv=KV, period=PERIOD)
    law = {
        "cascade": cascade,
        "late": replace(cascade, delay=2),
        "brake": ControlLaw(name="brake", period=PERIOD, output=-50 * MEASURED_VELOCITY),
    }[kind]
    resistance, drive = (viscous(b, q), gravity(M)), Drive(gain=sign)
    return build(body(*resistance, parameters=(b,), name="vertical", drive=drive, control=law))


@pytest.mark.slow
def test_an_axis_that_sags_further_than_its_reference_moves_is_simulated() -> None:
    loop = simulate(vertical(), THETA, SMALL, PERIOD)
    assert np.abs(loop.position - SMALL).max() > 100 * np.ptp(SMALL)
    assert loop.position[500:] == pytest.approx(-SAG, abs=3e-5)
    batch = simulate_batch(vertical(), np.array([THETA, THETA * 1.1]), SMALL, PERIOD)
    assert not batch.failures
    assert batch["position"][500:, 1] == pytest.approx(-1.1 * SAG, abs=3e-5)


@pytest.mark.slow
@pytest.mark.parametrize("reference", [SMALL, 1e3 * SMALL], ids=["small", "large"])
def test_a_loop_that_runs_away_is_refused_however_far_its_load_moves_it(
    reference: np.ndarray,
) -> None:
    with refuses("simulation", says=r"diverges: the position leaves the range at sample"):
        simulate(vertical(-1.0), THETA, reference, PERIOD)
    light = THETA * 0.03  # the sampled loop swings ever further
    batch = simulate_batch(vertical(), np.array([THETA, light]), reference, PERIOD)
    assert set(batch.failures) == {1}
    assert "diverges" in batch.failures[1]


@pytest.mark.slow
def test_an_axis_moved_by_the_noise_of_its_encoder_alone_is_simulated() -> None:
    level = 1e-9 * np.sin(2 * np.pi * TIME)
    noise = np.random.default_rng(1).normal(0.0, 1e-5, len(TIME))
    still = build(vertical().axis)
    loop = simulate(still, [MASS, 1.0], level - SAG, PERIOD, start=-SAG, position_noise=noise)
    assert np.abs(loop.position).max() > 0


@pytest.mark.slow
def test_a_law_that_brakes_alone_has_no_distance_of_its_own() -> None:
    loop = simulate(vertical(kind="brake"), THETA, SMALL, PERIOD)
    assert loop.position[-1] < -100 * np.ptp(SMALL), "it sinks, as slowly as it is braked"
