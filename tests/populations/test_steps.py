"""Steps of a series, and none where nothing changes."""

import numpy as np
import pytest
from scipy.stats import binom

from axisid.populations import steps_in
from axisid.support.arrays import Array


def series(count: int, seed: int, step: float = 0.0) -> tuple[Array, Array]:
    """Values that scatter by 1 beside deviations of their own; the second half is higher."""
    rng = np.random.default_rng(seed)
    variances = rng.uniform(0.1, 0.5, count) ** 2
    values = rng.normal(0.0, np.sqrt(1.0 + variances))
    values[count // 2 :] += step
    return values, variances


def test_a_series_without_a_step_has_one_no_more_often_than_the_level_says() -> None:
    runs, level = 60, 0.05
    found = sum(bool(steps_in(*series(16, seed), level)) for seed in range(runs))
    assert found <= binom.ppf(0.999, runs, level)


def test_a_step_is_told_with_its_place_and_size() -> None:
    for seed in range(5):
        (step,) = steps_in(*series(24, seed, 8.0), 0.01)
        assert step.place == 12
        assert step.difference == pytest.approx(8.0, abs=4 * step.deviation)
        assert step.p_value <= 0.005


def test_two_steps_are_told() -> None:
    values, variances = series(36, 3)
    values[12:24] += 8.0
    assert [step.place for step in steps_in(values, variances, 0.02)] == [12, 24]


def test_too_few_values_have_no_step() -> None:
    assert steps_in(np.array([0.0, 0.0, 0.0, 9.0, 9.0]), np.full(5, 0.01), 0.05) == ()
