"""Covariances of scores, and how sure they are."""

import numpy as np
import pytest

from axisid.estimation.regression import (
    CovarianceEstimate,
    at_least_twin_variances,
    sum_covariances,
)
from axisid.support.arrays import Array

_ROWS = 4000
_DWELLS = np.arange(_ROWS) // 500 % 2 == 0


def _columns() -> Array:
    """Of what only dwells show, and of what only swings do."""
    wave = np.sin(np.arange(_ROWS) / 40)
    return np.column_stack([wave * _DWELLS, wave * ~_DWELLS])


def test_a_sum_is_as_sure_as_its_larger_parts() -> None:
    """Degrees of freedom by Satterthwaite's equation; what is known has no end of them."""
    one = CovarianceEstimate(matrix=np.diag([4.0, 1.0]), freedom=np.array([10.0, 10.0]))
    two = CovarianceEstimate(matrix=np.diag([4.0, 0.0]), freedom=np.array([10.0, 5.0]))
    both = sum_covariances([one, two])
    np.testing.assert_allclose(np.diag(both.matrix), [8.0, 1.0])
    np.testing.assert_allclose(both.freedom, [20.0, 10.0])
    sure = CovarianceEstimate(matrix=np.diag([4.0, 0.0]), freedom=np.full(2, np.inf))
    np.testing.assert_allclose(sum_covariances([one, sure]).freedom, [40.0, 10.0])
    nothing = CovarianceEstimate(matrix=np.zeros((1, 1)), freedom=np.ones(1))
    assert np.isinf(sum_covariances([nothing]).freedom[0])


def test_twins_count_where_they_tell_more(rng: np.random.Generator) -> None:
    twins = rng.standard_normal((_ROWS, 48)) * np.where(_DWELLS, 3.0, 0.1)[:, None]
    told = CovarianceEstimate(matrix=_columns().T @ _columns(), freedom=np.array([900.0, 900.0]))
    found = at_least_twin_variances(told, _columns(), twins, [slice(0, _ROWS)])
    assert found.matrix[0, 0] == pytest.approx((_columns()[:, 0] @ twins).var(ddof=1))
    assert found.matrix[1, 1] == told.matrix[1, 1]
    assert [*found.freedom] == [47, 900]
