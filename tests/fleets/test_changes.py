"""Steps and drifts of a series, and none where nothing changes."""

import numpy as np
import pytest
from scipy.stats import binom

from axisid.fleets.robust_statistics import Drift, Step, change_in
from axisid.support.arrays import Array

CHECK_LEVEL = 0.05
NOTHING = ((), None)
Changes = tuple[tuple[Step, ...], Drift | None]


def series(count: int, seed: int, step: float = 0.0, drift: float = 0.0) -> tuple[Array, Array]:
    """Values that scatter by 1 beside deviations of their own.

    The second half is higher by `step`, the last one by `drift` beside that.
    """
    rng = np.random.default_rng(seed)
    variances = rng.uniform(0.1, 0.5, count) ** 2
    values = rng.normal(0.0, np.sqrt(1.0 + variances)) + drift * np.linspace(0.0, 1.0, count)
    values[count // 2 :] += step
    return values, variances


def changes(values: Array, variances: Array, level: float = CHECK_LEVEL) -> Changes:
    return change_in(values, variances, np.arange(len(values), dtype=float), level)


def test_a_series_that_does_not_change_is_told_to_no_more_often_than_the_level_says() -> None:
    runs = 60
    found = sum(changes(*series(16, seed)) != NOTHING for seed in range(runs))
    assert found <= binom.ppf(0.999, runs, CHECK_LEVEL)


def test_a_step_is_told_with_its_place_and_size() -> None:
    for seed in range(5):
        (step,), drift = changes(*series(24, seed, step=8.0), 0.01)
        assert (drift, step.place) == (None, 12)
        assert step.difference == pytest.approx(8.0, abs=4 * step.deviation)
        assert step.p_value <= 0.005


def test_two_steps_are_told() -> None:
    values, variances = series(36, 3)
    values[12:24] += 8.0
    assert [step.place for step in changes(values, variances, 0.02)[0]] == [12, 24]


def test_a_drift_is_told_in_place_of_steps_with_its_slope() -> None:
    runs = 20
    found = [changes(*series(20, seed, drift=6.0)) for seed in range(runs)]
    drifts = [drift for _, drift in found if drift is not None]
    assert len(drifts) >= 14  # of measured 9 in ten
    assert all(not steps for steps, drift in found if drift is not None)
    for drift in drifts:
        assert drift.slope == pytest.approx(6.0 / 19, abs=4 * drift.deviation)
        assert np.allclose(np.diff(drift.line), drift.slope)


def test_a_drift_is_by_the_places_of_the_values() -> None:
    values, variances = series(24, 1)
    places = np.sort(np.random.default_rng(0).uniform(0.0, 100.0, 24))
    _, drift = change_in(values + 0.1 * places, variances, places, CHECK_LEVEL)
    assert drift.slope == pytest.approx(0.1, abs=4 * drift.deviation)


def test_too_few_values_and_values_at_one_place_tell_nothing_of_time() -> None:
    assert changes(np.array([0.0, 0.0, 0.0, 9.0, 9.0]), np.full(5, 0.01)) == NOTHING
    values, variances = series(16, 4)
    for places in (np.ones(16), 1e-322 * np.arange(16.0)):  # and too close to reckon with
        assert change_in(values, variances, places, CHECK_LEVEL) == NOTHING


@pytest.mark.parametrize("unit", [1e-95, 1e95])
def test_a_drift_is_the_same_in_every_unit_of_the_places(unit: float) -> None:
    values, variances = series(20, 5, drift=12.0)
    places = np.arange(20.0)
    own, other = (
        change_in(values, variances, each, CHECK_LEVEL)[1] for each in (places, unit * places)
    )
    assert other.p_value == own.p_value
    assert other.slope * unit == pytest.approx(own.slope)
