"""Figures of many runs and their Monte-Carlo errors."""

import math

import numpy as np
import pytest
from statsmodels.stats.proportion import proportion_confint

from axisid.estimation.monte_carlo.figures import Mean, Share


@pytest.mark.parametrize(("count", "of"), [(0, 1), (0, 20), (1, 20), (19, 20), (57, 60), (60, 60)])
def test_share_has_wilsons_interval(count: int, of: int) -> None:
    expected = proportion_confint(count, of, alpha=0.05, method="wilson")
    assert Share(count, of).interval == pytest.approx(expected, abs=1e-12)


def test_share_of_no_time_is_not_a_number_and_may_be_anything() -> None:
    assert math.isnan(Share(0, 0).value)
    assert Share(0, 0).interval == (0.0, 1.0)


def test_mean_and_scatter_have_the_errors_that_they_show_when_repeated() -> None:
    many = np.random.default_rng(1).normal(size=(1000, 50))
    means = [Mean.of_values(values) for values in many]
    scatters = [Mean.of_scatter(values) for values in many]
    for found in (means, scatters):
        stated = np.sqrt(np.mean([each.error**2 for each in found]))
        assert stated == pytest.approx(np.std([each.value for each in found]), rel=0.06)


def test_too_few_runs_have_no_error() -> None:
    assert math.isnan(Mean.of_values(np.array([1.0])).error)
    assert math.isnan(Mean.of_scatter(np.array([1.0])).value)
