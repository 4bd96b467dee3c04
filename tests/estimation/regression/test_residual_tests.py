"""Residual tests and the spectrum against statsmodels and SciPy, and on series of known nature."""

import numpy as np
import pytest
from scipy.signal import lfilter, welch
from scipy.stats import jarque_bera as scipy_jarque_bera
from statsmodels.stats.stattools import durbin_watson
from statsmodels.tsa.stattools import ccf

from axisid.estimation.regression import power_density
from axisid.estimation.regression.residual_tests import residual_tests
from axisid.estimation.signals import RowTimes
from axisid.support.errors import Missing


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
    assert ours.normality.jarque_bera == pytest.approx(bera.statistic, rel=1e-9)
    assert ours.normality.p_value == pytest.approx(bera.pvalue, rel=1e-6, abs=1e-300)


@pytest.fixture
def solved(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Residuals of an instrumental-variable fit, and the instruments."""
    Z = rng.normal(size=(500, 3))
    X = Z + 0.5 * rng.normal(size=(500, 3))
    y = X @ [1.0, 2.0, 3.0] + rng.normal(size=500)
    return y - X @ np.linalg.solve(Z.T @ X, Z.T @ y), Z


def test_missing_rows_count_as_none_over_every_lag(rng: np.random.Generator) -> None:
    order = RowTimes(np.flatnonzero(rng.random(400) < 0.7))
    e, Z = rng.normal(size=len(order)), rng.normal(size=(len(order), 2))
    tests = residual_tests(e, Z, lags=5, neighbours=order)
    crossed = np.transpose(tests.cross_correlation.columns)
    sizes = np.linalg.norm(Z, axis=0) * np.linalg.norm(e)
    about = e - e.mean()
    for lag in range(6):
        late, early = order.pairs(lag)
        after, before = Z[early].T @ e[late], Z[late].T @ e[early]
        assert crossed[5 + lag] == pytest.approx(after / sizes, abs=1e-12)
        assert crossed[5 - lag] == pytest.approx(before / sizes, abs=1e-12)
        own = about[late] @ about[early] / (about @ about)
        assert tests.autocorrelation.values[lag] == pytest.approx(own, abs=1e-12)


def test_cross_correlation_is_that_of_statsmodels(solved: tuple[np.ndarray, np.ndarray]) -> None:
    """Its own is centred; so are these series here."""
    e, Z = (x - x.mean(axis=0) for x in solved)
    tests = residual_tests(e, Z, lags=8)
    assert tests.autocorrelation.bound_95 == pytest.approx(1.96 / np.sqrt(500))
    ours = np.transpose(tests.cross_correlation.columns)
    for j in range(3):
        assert ours[8:, j] == pytest.approx(ccf(e, Z[:, j], adjusted=False)[:9], rel=1e-9)
        assert ours[8::-1, j] == pytest.approx(ccf(Z[:, j], e, adjusted=False)[:9], rel=1e-9)


def with_gaps(rng: np.random.Generator, rows: int) -> RowTimes:
    """Stretches of 5 to 40 rows, a few rows missing between them."""
    places, at = [], 0
    while len(places) < rows:
        length = int(rng.integers(5, 41))
        places += range(at, at + length)
        at += length + int(rng.integers(1, 8))
    return RowTimes(np.array(places[:rows]))


def at_ends(stretches: int, length: int) -> tuple[RowTimes, np.ndarray]:
    """Columns that act at the ends of stretches, as an acceleration where reversals are left out.

    Few pairs hold all that they have.
    """
    order = RowTimes.joined([RowTimes.consecutive(length)] * stretches)
    ends = np.zeros(length)
    ends[:3], ends[-3:] = (3, 2, 1), (-1, -2, -3)
    signs = np.repeat([1.0, -1.0] * (stretches // 2), length)
    return order, np.column_stack([np.tile(ends, stretches), signs])


@pytest.mark.slow
@pytest.mark.parametrize("rows", ["whole", "with gaps", (20, 20), (20, 25), (40, 20)])
def test_independent_residuals_are_rejected_as_often_as_declared(
    rng: np.random.Generator, rows: str | tuple[int, int]
) -> None:
    if isinstance(rows, tuple):
        order, W = at_ends(*rows)
    else:
        order = RowTimes.consecutive(400) if rows == "whole" else with_gaps(rng, 400)
        W = lfilter([1], [1, -0.9], rng.normal(size=(400, 2)), axis=0)
    draws = 500
    tests = [residual_tests(rng.normal(size=len(order)), W, None, order) for _ in range(draws)]
    within = 4 * np.sqrt(0.05 * 0.95 / draws)
    crossed = [t.cross_correlation for t in tests]
    assert np.mean([c.largest > c.limit_95 for c in crossed]) < 0.05 + within
    assert np.mean([t.durbin_watson for t in tests]) == pytest.approx(2.0, abs=0.02)
    own = [t.autocorrelation for t in tests]
    assert np.mean([np.abs(each.values[1:]) > each.bound_95 for each in own]) < 0.06


RATE = 100.0


def test_rows_that_all_follow_each_other_are_welch_s_own(rng: np.random.Generator) -> None:
    both = rng.normal(size=(1000, 2))
    found = power_density(both, RATE, RowTimes.consecutive(1000))
    frequencies, power = welch(both, RATE, nperseg=256, axis=0)
    np.testing.assert_array_equal(found[0], frequencies[1:])
    np.testing.assert_allclose(found[1], power[1:], rtol=1e-12)


def test_missing_rows_leave_the_density_as_it_is(rng: np.random.Generator) -> None:
    """A tone of power 1/2 in noise of power 1 keeps both, though its phase is lost at each gap."""
    pieces = [RowTimes.consecutive(300) for _ in range(20)]
    time = np.arange(6000) / RATE
    values = np.sin(2 * np.pi * 20 * time) + rng.normal(size=6000)
    found = power_density(values, RATE, RowTimes.joined(pieces))
    assert not isinstance(found, Missing)
    frequencies, power = found
    step = frequencies[1] - frequencies[0]
    near = np.abs(frequencies - 20) < 3 * step
    level = float(np.median(power[~near]))
    assert level == pytest.approx(2 / RATE, rel=0.1)
    assert float(np.sum(power[near] - level)) * step == pytest.approx(0.5, rel=0.1)


def test_stretches_that_are_too_short_give_no_density() -> None:
    for length, there in ((7, False), (8, True)):
        order = RowTimes.joined([RowTimes.consecutive(length) for _ in range(30)])
        assert isinstance(power_density(np.ones(30 * length), RATE, order), Missing) is not there
