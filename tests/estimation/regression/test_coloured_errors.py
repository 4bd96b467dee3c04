"""Errors that follow one another, and tests of residuals, against statsmodels and SciPy."""

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.optimize import brentq
from scipy.signal import lfilter, welch
from scipy.special import stdtrit
from statsmodels.stats.stattools import durbin_watson
from statsmodels.tsa.stattools import acf

from axisid.estimation.regression import (
    CovarianceEstimate,
    Hac,
    Solution,
    autoregression_of,
    power_density,
    sum_covariances,
)
from axisid.estimation.regression.coloured_errors import levinson_whittle
from axisid.estimation.regression.covariance import covariance_of_ar1
from axisid.estimation.regression.linear import factor, least_squares
from axisid.estimation.regression.residual_tests import residual_tests
from axisid.estimation.signals import RowTimes
from axisid.estimation.thresholds import MIN_DEGREES_OF_FREEDOM
from axisid.support.arrays import Array
from axisid.support.missing import Missing

_FIRST = np.array([[0.5, 0.3], [-0.2, 0.6]])
_SECOND = np.array([[-0.2, 0.1], [0.05, -0.3]])
_NOISE = np.array([[1.0, 0.4], [0.4, 2.0]])


def _errors(samples: int, seed: int) -> Array:
    """Of two outputs, rows of a sample neighbours, (2 n,)."""
    noise = np.random.default_rng(seed).multivariate_normal([0, 0], _NOISE, size=samples + 100)
    e = np.zeros_like(noise)
    for t in range(2, len(e)):
        e[t] = _FIRST @ e[t - 1] + _SECOND @ e[t - 2] + noise[t]
    return e[100:].ravel()


@pytest.mark.parametrize("rows", [0, 1, 2, 3, 50, 501])
def test_the_covariance_of_columns_is_that_of_the_whole_matrix(rows: int) -> None:
    random = np.random.default_rng(5)
    errors = np.convolve(random.normal(size=2000), [1.0, 0.8, 0.3])[:2000]
    products = [errors[: len(errors) - k] @ errors[k:] for k in range(20)]
    covariances = np.array(products)[:, None, None] / len(errors)
    model = levinson_whittle(covariances, len(errors))
    assert model.order
    columns = random.normal(size=(rows, 3))
    whole = toeplitz(model.covariances_to(rows)[:, 0, 0])
    found = model.coloured(columns)
    np.testing.assert_allclose(
        found, columns.T @ whole @ columns, rtol=0, atol=1e-11 * np.abs(found).max(initial=0.0)
    )


@pytest.mark.slow
def test_how_sure_a_variance_of_one_output_is_follows_from_its_errors() -> None:
    column = np.random.default_rng(0).normal(size=300)
    variances, claimed = [], []
    for seed in range(150):
        e = lfilter([1.0], [1.0, -1.2, 0.5], np.random.default_rng(seed).normal(size=3000))
        model = autoregression_of([e], 1e-3)
        variances.append(model.coloured(column[:, None])[0, 0])
        claimed.append(model.uncertainty([column], 3000))
    scatter = np.var(variances, ddof=1) / np.mean(variances) ** 2
    assert np.mean(claimed) == pytest.approx(scatter, rel=0.3)


def test_several_outputs_have_coefficients_and_make_of_columns_what_they_say() -> None:
    """By the sums over all pairs of samples."""
    e = _errors(20_000, 0)
    found = autoregression_of([e[:15_000], e[15_000:]], 1e-3, None, 2)
    assert 2 <= found.order <= 3
    np.testing.assert_allclose(found.coefficients[1:3], [-_FIRST, -_SECOND], atol=0.03)
    np.testing.assert_allclose(found.variance, _NOISE, atol=0.06)
    columns = np.random.default_rng(1).normal(size=(80, 2)).cumsum(axis=0)
    lags = [*found.covariances]
    for _ in range(40):
        lags.append(-sum(a @ c for a, c in zip(found.coefficients[1:], lags[::-1], strict=False)))
    whole = np.block(
        [[lags[i - j] if i >= j else lags[j - i].T for j in range(40)] for i in range(40)]
    )
    np.testing.assert_allclose(found.coloured(columns), columns.T @ whole @ columns, rtol=1e-9)


@pytest.mark.parametrize("other", [0.0, 1.0, -3.0])
def test_an_output_that_is_a_function_of_another_tells_nothing_more(other: float) -> None:
    e = _errors(4_000, 4)[::2].copy()
    both = autoregression_of([np.column_stack([e, other * e]).ravel()], 1e-3, None, 2)
    column = np.random.default_rng(5).normal(size=(200, 1))
    wide = np.hstack([column, np.zeros_like(column)]).reshape(-1, 1)
    alone = autoregression_of([e], 1e-3).coloured(column)
    np.testing.assert_allclose(both.coloured(wide), alone, rtol=0.1)


def test_masked_samples_are_no_errors() -> None:
    e = _errors(20_000, 6)
    there = np.ones(len(e), dtype=bool)
    there[4_000:6_000] = there[9_000:12_000] = False
    found = autoregression_of([np.where(there, e, 0.0)], 1e-3, [there], 2)
    np.testing.assert_allclose(found.variance, _NOISE, atol=0.1)


@pytest.mark.slow
def test_lags_are_as_long_in_time_for_several_outputs_as_for_one() -> None:
    """At 10 kHz, of errors that come back after 20 and after 38 ms."""
    noise = np.random.default_rng(3).standard_normal((30_000, 2))
    e = np.zeros_like(noise)
    for t in range(380, len(e)):
        e[t] = 0.5 * e[t - 200] + 0.3 * e[t - 380] + noise[t]
    both = autoregression_of([e.ravel()], 1e-4, None, 2)
    alone = autoregression_of([np.ascontiguousarray(e[:, 0])], 1e-4)
    assert [both.order, alone.order] == pytest.approx([380, 380], abs=5)


def test_a_sum_is_as_sure_as_its_larger_parts() -> None:
    """Degrees of freedom by Satterthwaite's equation; what is known has no end of them."""
    one, two, sure = (
        CovarianceEstimate(matrix=np.diag(variances), freedom=np.array(freedom))
        for variances, freedom in (
            ([4.0, 1.0], [10.0, 10.0]),
            ([4.0, 0.0], [10.0, 5.0]),
            ([4.0, 0.0], [np.inf, np.inf]),
        )
    )
    both = sum_covariances([one, two])
    np.testing.assert_allclose(np.diag(both.matrix), [8.0, 1.0])
    np.testing.assert_allclose(both.freedom, [20.0, 10.0])
    np.testing.assert_allclose(sum_covariances([one, sure]).freedom, [40.0, 10.0])


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
    assert covariance_of_ar1(solution).matrix == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("colour", [0.3, 0.8])
def test_its_degrees_of_freedom_are_those_of_the_delta_method(
    rng: np.random.Generator, colour: float
) -> None:
    """By dense algebra: how the variance of each parameter changes with the coefficient."""
    solution = fit(errors(rng, 150, colour))
    A, e, rows = solution.influence, solution.residuals, len(solution.residuals)
    shown = float(np.mean(e[1:] * e[:-1]) / np.mean(e**2))
    rho = float(brentq(lambda each: dense(solution, each)[1] - shown, 0.0, 0.98))
    apart = np.abs(np.subtract.outer(np.arange(rows), np.arange(rows)))

    def logarithms(of: float) -> np.ndarray:
        return np.asarray(np.log(np.diag(A.T @ of**apart @ A) / (1 - of**2)))

    slopes = (logarithms(rho + 1e-4) - logarithms(rho - 1e-4)) / 2e-4
    expected = 2 * rows / (2 + slopes**2 * (1 - rho**2))
    found = covariance_of_ar1(solution)
    assert found.freedom == pytest.approx(expected, rel=0.02)
    assert np.all(found.freedom < rows - 2)  # no bound decides


def test_errors_that_have_nothing_slow_leave_the_kernel_alone(rng: np.random.Generator) -> None:
    solution = fit(np.diff(rng.normal(size=151)))
    assert not covariance_of_ar1(solution).matrix.any()
    assert not Hac().applied(solution).note.is_at_least_ar1


@pytest.mark.slow
def test_its_degrees_of_freedom_are_those_of_its_scatter(rng: np.random.Generator) -> None:
    found = [covariance_of_ar1(fit(errors(rng, 600, 0.7))) for _ in range(400)]
    scatter = np.var([np.log(np.diag(each.matrix)) for each in found], axis=0)
    told = np.mean([2 / each.freedom for each in found], axis=0)
    assert told == pytest.approx(scatter, rel=0.35)
    slow = covariance_of_ar1(fit(np.cumsum(rng.normal(size=60))))
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
    found = covariance_of_ar1(solution)
    least = np.diag(found.matrix)
    # Long records, and lags that are given, have the kernel alone.
    long = Hac().applied(fit(errors(rng, 3000, 0.5)))
    told = [each.note.is_at_least_ar1 for each in (wide, plain, Hac(5).applied(solution), long)]
    assert told == [True, False, False, False]
    expected = np.maximum(np.diag(plain.matrix), least)
    assert np.diag(wide.matrix) == pytest.approx(expected, rel=1e-12)
    wider = least > np.diag(plain.matrix)
    assert wide.freedom == pytest.approx(np.where(wider, found.freedom, plain.freedom))
    off = [m[0, 1] / np.sqrt(m[0, 0] * m[1, 1]) for m in (plain.matrix, wide.matrix)]
    assert off[1] == pytest.approx(off[0], rel=1e-12)


@pytest.mark.parametrize("colour", [0.0, 0.6])
def test_residual_tests_are_those_of_statsmodels(rng: np.random.Generator, colour: float) -> None:
    shocks = rng.standard_t(5, size=800)
    e = np.zeros(800)
    for i in range(1, 800):
        e[i] = colour * e[i - 1] + shocks[i]
    e -= e.mean()
    ours = residual_tests(e, lags=12)
    assert ours.durbin_watson == pytest.approx(durbin_watson(e), rel=1e-12)
    assert ours.autocorrelation.values == pytest.approx(acf(e, nlags=12), rel=1e-9)
    assert ours.autocorrelation.bound_95 == pytest.approx(1.96 / np.sqrt(800))


def test_missing_rows_count_as_none_over_every_lag(rng: np.random.Generator) -> None:
    order = RowTimes(np.flatnonzero(rng.random(400) < 0.7))
    e = rng.normal(size=len(order))
    tests = residual_tests(e, lags=5, neighbours=order)
    about = e - e.mean()
    for lag in range(6):
        late, early = order.pairs(lag)
        own = about[late] @ about[early] / (about @ about)
        assert tests.autocorrelation.values[lag] == pytest.approx(own, abs=1e-12)


def with_gaps(rng: np.random.Generator, rows: int) -> RowTimes:
    """Stretches of 5 to 40 rows, a few rows missing between them."""
    places, at = [], 0
    while len(places) < rows:
        length = int(rng.integers(5, 41))
        places += range(at, at + length)
        at += length + int(rng.integers(1, 8))
    return RowTimes(np.array(places[:rows]))


@pytest.mark.slow
@pytest.mark.parametrize("rows", ["whole", "with gaps"])
def test_independent_residuals_are_rejected_as_often_as_declared(
    rng: np.random.Generator, rows: str
) -> None:
    order = RowTimes.consecutive(400) if rows == "whole" else with_gaps(rng, 400)
    tests = [residual_tests(rng.normal(size=len(order)), None, order) for _ in range(500)]
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
