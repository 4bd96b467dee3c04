"""Deviations of estimates whose errors follow one another."""

import numpy as np
import pytest
from scipy.signal import lfilter

from axisid.estimation.fitting.assembly import cut_interval
from axisid.estimation.fitting.spread import Scores, autoregression_of
from axisid.support.arrays import Array


def test_the_autoregression_of_errors_is_found(rng: np.random.Generator) -> None:
    e = lfilter([1.0], [1.0, -1.2, 0.5], 0.3 * rng.standard_normal(20_000))
    found = autoregression_of([e[:9000], e[9000:]], 1e-3)
    assert 2 <= found.order <= 10
    np.testing.assert_allclose(found.coefficients[:3], [1.0, -1.2, 0.5], atol=0.05)
    assert found.variance == pytest.approx(0.09, rel=0.05)


def test_errors_that_are_white_need_none(rng: np.random.Generator) -> None:
    assert autoregression_of([rng.standard_normal(5000)], 1e-3).order <= 4
    assert autoregression_of([np.zeros(500)], 1e-3).order == 0


def _scores(J: Array, e: Array) -> Scores:
    rows = slice(0, len(e))
    nothing = np.zeros((0, J.shape[1]))
    return Scores(
        jacobian=J,
        errors=e,
        curvature=np.ones(len(e)),
        known=nothing,
        spans=((rows,),),
        periods=(1e-3,),
    )


@pytest.mark.parametrize("a", [-0.6, 0.8])
def test_the_sandwich_is_the_scatter_of_estimates_with_coloured_errors(
    a: float, rng: np.random.Generator
) -> None:
    n, runs = 2000, 300
    time = np.arange(n) / 50
    J = np.column_stack([np.sin(time), np.sign(np.sin(0.3 * time))])
    errors = lfilter([1.0], [1.0, -a], rng.standard_normal((runs, n)), axis=1)
    scatter = np.linalg.lstsq(J, errors.T, rcond=None)[0].std(axis=1)
    claimed = []
    for e in errors[:20]:
        scores = _scores(J, e)
        claimed.append(np.sqrt(np.diag(scores.coloured(scores.autoregressions))))
    np.testing.assert_allclose(np.mean(claimed, axis=0), scatter, rtol=0.12)
    independent = np.sqrt(np.diag(_scores(J, errors[0]).independent()))
    assert np.all((independent > 1.5 * scatter) if a < 0 else (independent < 0.7 * scatter))


def test_what_was_known_before_counts_as_rows() -> None:
    J, e = np.ones((100, 1)), np.zeros(100)
    e[::2], e[1::2] = 1.0, -1.0
    scores = _scores(J, e)
    rows = slice(0, 100)
    known = Scores(
        jacobian=J,
        errors=e,
        curvature=np.ones(100),
        known=np.array([[10.0]]),
        spans=((rows,),),
        periods=(1e-3,),
    )
    assert known.inverse[0, 0] == pytest.approx(1 / 200)
    assert known.independent()[0, 0] < scores.independent()[0, 0]


def test_an_interval_at_a_bound_is_on_the_side_that_is_allowed(rng: np.random.Generator) -> None:
    """95 % of a normal distribution, of which nothing is below the bound."""
    for centre in (0.5, 0.0, -3.0):
        low, high = cut_interval(0.0, centre, 1.0, -1)
        draws = rng.normal(centre, 1.0, 2_000_000)
        beyond = draws[draws > 0]
        assert low == 0.0
        assert np.mean(beyond <= high) == pytest.approx(0.95, abs=0.01)
        assert cut_interval(0.0, -centre, 1.0, 1) == pytest.approx((-high, 0.0))
