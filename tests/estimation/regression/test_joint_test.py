"""The test of several parameters at once: known distributions, and its size."""

import numpy as np
import pytest
from scipy import stats

from axisid.estimation.regression import joint_p


@pytest.mark.parametrize("freedom", [3.7, 40.0, 900.0])
def test_one_parameter_is_students_test(freedom: float) -> None:
    expected = 2 * stats.t.sf(2.3, freedom)
    for one_variance in (False, True):
        found = joint_p(2.3**2, 1, freedom, one_variance=one_variance)
        assert found == pytest.approx(expected, rel=1e-9)


def test_one_variance_is_the_classical_f() -> None:
    assert joint_p(9.0, 3, 50, one_variance=True) == pytest.approx(stats.f.sf(3.0, 3, 50))


@pytest.mark.parametrize(("restrictions", "samples"), [(2, 12), (4, 12), (4, 60)])
def test_it_rejects_as_often_as_it_says(
    rng: np.random.Generator, restrictions: int, samples: int
) -> None:
    """Means of normal samples with the covariance of the samples: Hotelling's own case."""
    drawn = rng.normal(size=(2000, samples, restrictions))
    means = drawn.mean(axis=1)
    chances = [
        joint_p(float(m @ np.linalg.solve(np.cov(s.T) / samples, m)), restrictions, samples - 1)
        for m, s in zip(means, drawn, strict=True)
    ]
    assert np.mean(np.array(chances) < 0.05) == pytest.approx(0.05, abs=0.015)


def test_few_degrees_of_freedom_make_it_no_surer() -> None:
    chances = [joint_p(20.0, 3, freedom) for freedom in (1e6, 100.0, 10.0, 4.0, 2.5)]
    assert chances == sorted(chances)
    assert chances[0] == pytest.approx(stats.chi2.sf(20.0, 3), rel=1e-3)
