"""Errors that are of one colour in dwells and of another in swings have their deviations."""

import numpy as np
import pytest
from scipy.signal import lfilter

from axisid.estimation.told_by_outputs import (
    Scattering,
    added,
    autoregression_of,
    larger,
    uneven,
)
from axisid.support.arrays import Array

_ROWS, _PERIOD = 4000, 1e-3
_DWELLS = np.arange(_ROWS) // 500 % 2 == 0


def _noise(random: np.random.Generator, runs: int) -> Array:
    """Slow in dwells, differentiated in swings, (n, runs)."""
    white = random.standard_normal((_ROWS, runs))
    slow = lfilter([0.3], [1.0, -0.9], white, axis=0)
    fast = lfilter([0.7, -0.4], [1.0], white, axis=0)
    return np.where(_DWELLS[:, None], slow, fast)


def _columns() -> Array:
    """Of what only dwells show, and of what only swings do."""
    wave = np.sin(np.arange(_ROWS) / 40)
    return np.column_stack([wave * _DWELLS, wave * ~_DWELLS])


def _claimed(errors: Array, twins: Array) -> Array:
    found = uneven(_columns(), errors, twins, [slice(0, _ROWS)], _PERIOD)
    assert np.all(found.freedom >= 5)
    return np.sqrt(np.diag(found.matrix))


def test_twins_tell_the_scatter_of_dwells_and_of_swings(rng: np.random.Generator) -> None:
    """An autoregression has one colour for both, and is wrong by a factor each."""
    columns, errors = _columns(), _noise(rng, 400)
    scatter = (columns.T @ errors).std(axis=1)
    twins = _noise(rng, 48)
    claimed = np.mean([_claimed(e, twins) for e in errors.T[:20]], axis=0)
    assert np.all((claimed / scatter > 0.85) & (claimed / scatter < 1.4))
    model = autoregression_of([errors[:, 0]], _PERIOD)
    off = np.sqrt(np.diag(model.coloured(columns))) / scatter
    assert off[0] < 0.85
    assert off[1] > 1.5


def test_what_is_no_noise_of_the_twins_is_seen_by_the_scores(rng: np.random.Generator) -> None:
    columns, errors = _columns(), 10 * _noise(rng, 400)
    scatter = (columns.T @ errors).std(axis=1)
    twins = _noise(rng, 48)
    claimed = np.mean([_claimed(e, twins) for e in errors.T[:20]], axis=0)
    np.testing.assert_allclose(claimed, scatter, rtol=0.4)


def test_a_sum_is_as_sure_as_its_larger_parts() -> None:
    """Degrees of freedom by Satterthwaite's equation; what is known has no end of them."""
    one = Scattering(matrix=np.diag([4.0, 1.0]), freedom=np.array([10.0, 10.0]))
    two = Scattering(matrix=np.diag([4.0, 0.0]), freedom=np.array([10.0, 5.0]))
    both = added([one, two])
    np.testing.assert_allclose(np.diag(both.matrix), [8.0, 1.0])
    np.testing.assert_allclose(both.freedom, [20.0, 10.0])
    np.testing.assert_allclose(one.beside(np.diag([4.0, 0.0])).freedom, [40.0, 10.0])
    nothing = Scattering(matrix=np.zeros((1, 1)), freedom=np.ones(1))
    assert np.isinf(added([nothing]).freedom[0])


def test_twins_count_where_they_tell_more(rng: np.random.Generator) -> None:
    twins = rng.standard_normal((_ROWS, 48)) * np.where(_DWELLS, 3.0, 0.1)[:, None]
    told = Scattering(matrix=_columns().T @ _columns(), freedom=np.array([900.0, 900.0]))
    found = larger(told, _columns(), twins, [slice(0, _ROWS)])
    assert found.matrix[0, 0] == pytest.approx((_columns()[:, 0] @ twins).var(ddof=1))
    assert found.matrix[1, 1] == told.matrix[1, 1]
    assert [*found.freedom] == [47, 900]


def test_stretches_are_no_neighbours(rng: np.random.Generator) -> None:
    """Their products do not count: of two stretches it is the sum of each."""
    errors, columns = _noise(rng, 1)[:, 0], _columns()[:, :1]
    twins = np.zeros((_ROWS, 2))
    spans = [slice(0, 1700), slice(1700, _ROWS)]
    both = uneven(columns, errors, twins, spans, _PERIOD).matrix
    alone = [uneven(columns, errors, twins, [span], _PERIOD).matrix for span in spans]
    np.testing.assert_allclose(both, sum(alone))
