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


def test_errors_that_have_nothing_slow_leave_the_kernel_alone(rng: np.random.Generator) -> None:
    solution = fit(np.diff(rng.normal(size=151)))
    assert not autoregressive_covariance(solution).matrix.any()
    applied = Hac().applied(solution)
    assert not applied.widened.any()


@pytest.mark.slow
def test_its_degrees_of_freedom_are_those_of_its_scatter(rng: np.random.Generator) -> None:
    found = [autoregressive_covariance(fit(errors(rng, 600, 0.7))) for _ in range(400)]
    scatter = np.var([np.log(np.diag(each.matrix)) for each in found], axis=0)
    told = np.mean([2 / each.freedom for each in found], axis=0)
    assert told == pytest.approx(scatter, rel=0.35)
    slow = autoregressive_covariance(fit(np.cumsum(rng.normal(size=60))))
    assert np.all(slow.freedom >= MIN_DEGREES_OF_FREEDOM.value)


@pytest.mark.parametrize(
    ("rows", "rho", "widened", "holds"),
    [(150, 0.0, None, True), (150, 0.8, None, True), (100, 0.95, False, False)],
)
def test_hac_holds_the_truth_on_short_records_and_its_kernel_alone_does_not(
    rng: np.random.Generator, rows: int, rho: float, widened: bool | None, *, holds: bool
) -> None:
    kept = np.zeros(2)
    for _ in range(300):
        solution = fit(errors(rng, rows, rho))
        applied = Hac(widened=widened).applied(solution)
        reach = stdtrit(applied.freedom, 0.975) * np.sqrt(np.diag(applied.matrix))
        kept += np.abs(solution.theta - [3.0, 2.0]) <= reach
    assert (kept.min() / 300 >= 0.91) == holds


def test_few_scores_make_no_deviation_smaller_and_leave_correlations(
    rng: np.random.Generator,
) -> None:
    solution = fit(errors(rng, 150, 0.9))
    plain, wide = (Hac(widened=each).applied(solution) for each in (False, None))
    found = autoregressive_covariance(solution)
    least = np.diag(found.matrix)
    # Long records, and lags that are given, have the kernel alone.
    assert plain.widened is Hac(5).applied(solution).widened is None
    assert Hac().applied(fit(errors(rng, 3000, 0.5))).widened is None
    expected = np.maximum(np.diag(plain.matrix), least)
    assert np.diag(wide.matrix) == pytest.approx(expected, rel=1e-12)
    assert np.array_equal(wide.widened, least > np.diag(plain.matrix))
    assert wide.freedom == pytest.approx(np.where(wide.widened, found.freedom, plain.freedom))
    off = [m[0, 1] / np.sqrt(m[0, 0] * m[1, 1]) for m in (plain.matrix, wide.matrix)]
    assert off[1] == pytest.approx(off[0], rel=1e-12)
