"""Deviations of autoregressive residuals against dense algebra, and what they hold."""

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.special import stdtrit

from axisid.estimation.regression import Hac, Solution
from axisid.estimation.regression.autoregressive import autoregressive_covariance
from axisid.estimation.regression.linear import factor, least_squares
from axisid.estimation.signals import RowTimes
from axisid.estimation.thresholds import MIN_DEGREES_OF_FREEDOM

NAMES = ("a", "b")


def columns(rows: int) -> np.ndarray:
    """A few pulses of one sign and the other, and a slow wave: few scores are independent."""
    time = np.arange(rows)
    return np.column_stack([np.sign(np.sin(time / 11)) * (time % 35 < 9), np.sin(time / 29)])


def errors(rng: np.random.Generator, rows: int, rho: float) -> np.ndarray:
    return np.asarray(lfilter([1.0], [1.0, -rho], rng.normal(size=rows + 200)))[200:]


def fit(e: np.ndarray, size: float = 1.0, order: RowTimes | None = None) -> Solution:
    X = columns(len(e)) * [1.0, size]
    return least_squares(X @ [3.0, 2.0 / size] + e, factor(X, NAMES, neighbours=order))


def dense(solution: Solution, rho: float) -> tuple[np.ndarray, float]:
    """The covariance for a coefficient, and the autocorrelation that residuals then show."""
    A, e, places = solution.influence, solution.residuals, solution.neighbours.places
    apart = np.abs(places[:, None] - places[None, :])
    left = np.eye(len(e)) - A @ np.linalg.solve(A.T @ A, A.T)
    shown = left @ rho**apart @ left
    power = np.trace(shown)
    covariance = e @ e / power * (A.T @ rho**apart @ A)
    return covariance, shown[apart == 1].mean() / (power / len(e))


@pytest.mark.slow
@pytest.mark.parametrize("missing", [0.0, 0.2])
def test_it_is_that_of_dense_algebra_at_the_coefficient_that_the_residuals_show(
    rng: np.random.Generator, missing: float
) -> None:
    e = errors(rng, 150, 0.8)
    places = np.flatnonzero(np.r_[True, rng.random(len(e) - 1) >= missing])
    solution = fit(e[: len(places)], order=RowTimes(places))
    residuals = solution.residuals
    apart = np.abs(places[:, None] - places[None, :])
    shown = np.outer(residuals, residuals)[apart == 1].mean() / np.mean(residuals**2)
    rhos = np.linspace(0.3, 0.98, 700)
    rho = min(rhos, key=lambda each: abs(dense(solution, float(each))[1] - shown))
    expected, _ = dense(solution, float(rho))
    assert autoregressive_covariance(solution).matrix == pytest.approx(expected, rel=0.02)


def test_it_does_not_depend_on_units(rng: np.random.Generator) -> None:
    e, units = errors(rng, 200, 0.9), np.array([1.0, 1e6])
    there, here = (autoregressive_covariance(fit(e, size=size)) for size in (1e6, 1.0))
    assert there.matrix * np.outer(units, units) == pytest.approx(here.matrix, rel=1e-6)
    assert there.freedom == pytest.approx(here.freedom, rel=1e-6)


def test_errors_that_have_nothing_slow_leave_the_kernel_alone(rng: np.random.Generator) -> None:
    solution = fit(np.diff(rng.normal(size=151)))
    assert not autoregressive_covariance(solution).matrix.any()
    applied = Hac().applied(solution)
    assert not applied.widened.any()


def test_residuals_of_nothing_have_none() -> None:
    solution = fit(np.zeros(100))
    exact = Solution(
        theta=solution.theta,
        residuals=np.zeros(100),
        inverse_factor=solution.inverse_factor,
        influence=solution.influence,
        neighbours=solution.neighbours,
    )
    assert not autoregressive_covariance(exact).matrix.any()


@pytest.mark.slow
def test_its_degrees_of_freedom_are_those_of_its_scatter(rng: np.random.Generator) -> None:
    found = [autoregressive_covariance(fit(errors(rng, 600, 0.7))) for _ in range(400)]
    scatter = np.var([np.log(np.diag(each.matrix)) for each in found], axis=0)
    told = np.mean([2 / each.freedom for each in found], axis=0)
    assert told == pytest.approx(scatter, rel=0.35)
    slow = autoregressive_covariance(fit(np.cumsum(rng.normal(size=60))))
    assert np.all(slow.freedom >= MIN_DEGREES_OF_FREEDOM.value)


def held(rng: np.random.Generator, hac: Hac, rows: int, rho: float) -> np.ndarray:
    """Share of 300 fits in which the 95 % interval of each parameter holds the truth."""
    kept = np.zeros(2)
    for _ in range(300):
        solution = fit(errors(rng, rows, rho))
        applied = hac.applied(solution)
        reach = stdtrit(applied.freedom, 0.975) * np.sqrt(np.diag(applied.matrix))
        kept += np.abs(solution.theta - [3.0, 2.0]) <= reach
    return kept / 300


@pytest.mark.parametrize("rho", [0.0, 0.8, 0.95])
def test_hac_holds_the_truth_on_short_records(rng: np.random.Generator, rho: float) -> None:
    assert np.all(held(rng, Hac(), 150, rho) >= 0.92)


def test_the_kernel_alone_does_not(rng: np.random.Generator) -> None:
    assert np.all(held(rng, Hac(widened=False), 100, 0.95) < 0.9)


def test_few_scores_make_no_deviation_smaller_and_leave_correlations(
    rng: np.random.Generator,
) -> None:
    solution = fit(errors(rng, 150, 0.9))
    plain, wide = (Hac(widened=each).applied(solution) for each in (False, None))
    found = autoregressive_covariance(solution)
    least = np.diag(found.matrix)
    assert plain.widened is None
    expected = np.maximum(np.diag(plain.matrix), least)
    assert np.diag(wide.matrix) == pytest.approx(expected, rel=1e-12)
    assert np.array_equal(wide.widened, least > np.diag(plain.matrix))
    assert wide.freedom == pytest.approx(np.where(wide.widened, found.freedom, plain.freedom))
    off = [m[0, 1] / np.sqrt(m[0, 0] * m[1, 1]) for m in (plain.matrix, wide.matrix)]
    assert off[1] == pytest.approx(off[0], rel=1e-12)


def test_long_records_and_lags_that_are_given_have_the_kernel_alone(
    rng: np.random.Generator,
) -> None:
    long, short = fit(errors(rng, 3000, 0.5)), fit(errors(rng, 150, 0.9))
    assert Hac().applied(long).widened is None
    assert Hac(5).applied(short).widened is None
    assert np.array_equal(Hac().matrix(long), Hac(widened=False).matrix(long))
