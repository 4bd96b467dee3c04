"""The noise of twins: what was asked for, and the same for a run whoever runs it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from axisid.estimation import TwinNoise
from axisid.estimation.monte_carlo.noise import DrawnNoise
from axisid.estimation.simulation.twin import twin_plan
from tests.estimation.monte_carlo.short import axis
from tests.refusals import refuses


def drawn(run: int = 3, **noise: Any) -> DrawnNoise:
    return DrawnNoise(noise=TwinNoise(**noise), plan=twin_plan(axis()), seed=7, run=run)


def test_a_run_has_its_own_noise_of_the_deviation_that_is_asked_for() -> None:
    one, other = drawn(position=2e-6), drawn(run=4, position=2e-6)
    assert one.position(5000).std() == pytest.approx(2e-6, rel=0.05)
    assert np.array_equal(one.position(50), replace(one).position(50))
    assert not np.array_equal(one.position(50), other.position(50))


def test_one_source_of_noise_does_not_change_another() -> None:
    beside = drawn(control=0.1, disturbance=0.2, anywhere=True, resolution=1e-5)
    assert np.array_equal(drawn().position(50), beside.position(50))
    assert drawn().control is None
    assert drawn().phase == 0
    assert 0 < beside.phase < 1e-5


def test_correlated_noise_forgets_within_its_time() -> None:
    noise = drawn(control=0.5, correlation_time=0.02).control
    assert noise is not None
    assert len(noise) == len(twin_plan(axis()).reference)
    assert noise.std() == pytest.approx(0.5, rel=0.15)
    after = np.corrcoef(noise[:-20], noise[20:])[0, 1]
    assert after == pytest.approx(np.exp(-1), abs=0.12)


def test_correlated_noise_is_stationary_from_the_first_sample_however_long_it_lasts() -> None:
    for time in (0.02, 1e5):
        one = drawn(control=0.5, correlation_time=time)
        noises = [replace(one, run=run).control for run in range(200)]
        ends = np.array([noise[[0, -1]] for noise in noises if noise is not None])
        assert ends.std(axis=0) == pytest.approx(0.5, rel=0.2)


@pytest.mark.parametrize(
    "given",
    [{"position": -1.0}, {"control": None}, {"correlation_time": "1"}, {"velocity": np.inf}],
)
def test_noise_that_makes_no_sense_is_refused(given: dict[str, Any]) -> None:
    with refuses("twin-noise"):
        TwinNoise(**given)


def test_a_correlation_time_of_no_noise_is_refused() -> None:
    with refuses("twin-noise-of-nothing"):
        TwinNoise(correlation_time=1.0)
    TwinNoise(correlation_time=1.0, control=0.1)
