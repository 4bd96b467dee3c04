"""Residual tests against statsmodels and SciPy, and on series whose nature is known."""

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import jarque_bera as scipy_jarque_bera
from statsmodels.stats.stattools import durbin_watson
from statsmodels.tsa.stattools import ccf

from axisid.estimation.regression.residual_tests import residual_tests
from axisid.estimation.signals import Neighbours


@pytest.mark.parametrize("colour", [0.0, 0.6])
def test_residual_tests_are_those_of_statsmodels_and_scipy(
    rng: np.random.Generator, colour: float
) -> None:
    shocks = rng.standard_t(5, size=800)
    e = np.zeros(800)
    for i in range(1, 800):
        e[i] = colour * e[i - 1] + shocks[i]
    e -= e.mean()
    ours = residual_tests(e, rng.normal(size=(800, 2)), lags=12)
    assert ours.durbin_watson == pytest.approx(durbin_watson(e), rel=1e-12)
    bera = scipy_jarque_bera(e)
    assert ours.jarque_bera == pytest.approx(bera.statistic, rel=1e-9)
    assert ours.jarque_bera_p == pytest.approx(bera.pvalue, rel=1e-6, abs=1e-300)


@pytest.fixture
def solved(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Residuals of an instrumental-variable fit, and the instruments."""
    Z = rng.normal(size=(500, 3))
    X = Z + 0.5 * rng.normal(size=(500, 3))
    y = X @ [1.0, 2.0, 3.0] + rng.normal(size=500)
    return y - X @ np.linalg.solve(Z.T @ X, Z.T @ y), Z


def test_residuals_are_orthogonal_to_what_solved_them(
    solved: tuple[np.ndarray, np.ndarray],
) -> None:
    residuals, Z = solved
    tests = residual_tests(residuals, Z)
    middle = (len(tests.cross_correlation) - 1) // 2
    assert np.abs(tests.cross_correlation[middle]).max() < 1e-10
    assert tests.bound == pytest.approx(1.96 / np.sqrt(500))


def test_missing_rows_count_as_none_over_every_lag(rng: np.random.Generator) -> None:
    order = Neighbours(np.flatnonzero(rng.random(400) < 0.7))
    e, Z = rng.normal(size=len(order)), rng.normal(size=(len(order), 2))
    tests = residual_tests(e, Z, lags=5, neighbours=order)
    sizes = np.linalg.norm(Z, axis=0) * np.linalg.norm(e)
    about = e - e.mean()
    for lag in range(6):
        late, early = order.pairs(lag)
        after, before = Z[early].T @ e[late], Z[late].T @ e[early]
        assert tests.cross_correlation[5 + lag] == pytest.approx(after / sizes, abs=1e-12)
        assert tests.cross_correlation[5 - lag] == pytest.approx(before / sizes, abs=1e-12)
        own = about[late] @ about[early] / (about @ about)
        assert tests.autocorrelation[lag] == pytest.approx(own, abs=1e-12)


def test_cross_correlation_is_that_of_statsmodels(solved: tuple[np.ndarray, np.ndarray]) -> None:
    """Its own is centred; so are these series here."""
    e, Z = (x - x.mean(axis=0) for x in solved)
    ours = residual_tests(e, Z, lags=8).cross_correlation
    for j in range(3):
        assert ours[8:, j] == pytest.approx(ccf(e, Z[:, j], adjusted=False)[:9], rel=1e-9)
        assert ours[8::-1, j] == pytest.approx(ccf(Z[:, j], e, adjusted=False)[:9], rel=1e-9)


@pytest.mark.parametrize("colour", [0.0, 0.9])
def test_unrelated_series_stay_below_the_limit_however_coloured(
    rng: np.random.Generator, colour: float
) -> None:
    n, above = 600, []
    for _ in range(200):
        e, z = (lfilter([1.0], [1.0, -colour], rng.normal(size=n)) for _ in range(2))
        tests = residual_tests(e, z[:, None])
        above.append(tests.cross_z > tests.cross_limit)
    assert np.mean(above) < 0.08


def test_delayed_part_of_an_instrument_is_found_at_its_lag(rng: np.random.Generator) -> None:
    Z = rng.normal(size=(800, 2))
    e = rng.normal(size=800) + 0.4 * np.roll(Z[:, 1], 3)
    tests = residual_tests(e, Z, lags=10)
    row, column = np.unravel_index(np.abs(tests.cross_correlation).argmax(), (21, 2))
    assert (row - 10, column) == (3, 1)
    assert tests.cross_z > tests.cross_limit
    assert tests.cross_p < 1e-6


def with_gaps(rng: np.random.Generator, rows: int) -> Neighbours:
    """Stretches of 5 to 40 rows, a few rows missing between them."""
    places, at = [], 0
    while len(places) < rows:
        length = int(rng.integers(5, 41))
        places += range(at, at + length)
        at += length + int(rng.integers(1, 8))
    return Neighbours(np.array(places[:rows]))


@pytest.mark.slow
@pytest.mark.parametrize("gaps", [False, True])
def test_independent_residuals_are_rejected_as_often_as_declared(
    rng: np.random.Generator, gaps: bool
) -> None:
    order = with_gaps(rng, 400) if gaps else Neighbours.consecutive(400)
    W = lfilter([1], [1, -0.9], rng.normal(size=(400, 2)), axis=0)
    draws = 600
    tests = [residual_tests(rng.normal(size=400), W, 12, order) for _ in range(draws)]
    within = 4 * np.sqrt(0.05 * 0.95 / draws)
    assert np.mean([t.cross_z > t.cross_limit for t in tests]) < 0.05 + within
    assert np.mean([t.durbin_watson for t in tests]) == pytest.approx(2.0, abs=0.02)


def test_what_gaps_leave_of_a_correlation_is_found(rng: np.random.Generator) -> None:
    """A first-order series of 5000 rows of which one in five is missing, at its own lags."""
    whole = lfilter([1], [1, -0.8], rng.normal(size=6200))
    order = Neighbours(np.flatnonzero(rng.random(6200) < 0.8))
    e = whole[order.places]
    tests = residual_tests(e, np.ones((len(e), 1)), 6, order)
    # Of five pairs four are there.
    assert tests.autocorrelation[1:] == pytest.approx(0.8 * 0.8 ** np.arange(1, 7), abs=0.08)
    assert tests.durbin_watson == pytest.approx(2 * (1 - 0.8), abs=0.05)
    taken = residual_tests(e, np.ones((len(e), 1)), 6)
    assert taken.autocorrelation[6] < tests.autocorrelation[6]


@pytest.mark.slow
@pytest.mark.parametrize(("stretches", "length"), [(20, 20), (20, 25), (40, 20)])
def test_columns_that_act_at_the_ends_of_stretches_raise_no_alarm(
    rng: np.random.Generator, stretches: int, length: int
) -> None:
    """As an acceleration does where reversals are left out: few pairs hold all that it has."""
    order = Neighbours.joined([Neighbours.consecutive(length)] * stretches)
    ends = np.zeros(length)
    ends[:3], ends[-3:] = (3, 2, 1), (-1, -2, -3)
    W = np.column_stack(
        [np.tile(ends, stretches), np.repeat([1.0, -1.0] * (stretches // 2), length)]
    )
    n, draws = stretches * length, 300
    tests = [residual_tests(rng.normal(size=n), W, None, order) for _ in range(draws)]
    within = 4 * np.sqrt(0.05 * 0.95 / draws)
    assert np.mean([t.cross_z > t.cross_limit for t in tests]) < 0.05 + within
    outside = np.mean([np.abs(t.autocorrelation[1:]) > t.bound for t in tests])
    assert outside < 0.06
