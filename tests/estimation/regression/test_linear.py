"""Least squares and instrumental variables against independent solutions."""

import numpy as np
import pytest
import statsmodels.api as sm
from hypothesis import given, strategies as st

from axisid import Prefilter
from axisid.estimation import delta_method
from axisid.estimation.regression.covariance import Classical, PublishedCovariance, Robust
from axisid.estimation.regression.linear import (
    condition_number,
    factor,
    instrumental_variables,
    least_squares,
    weighted_least_squares,
)
from axisid.estimation.signals import SampledFilter
from tests.refusals import refuses

NAMES = ["a", "b", "c"]


def problem(rng: np.random.Generator, n: int = 60) -> tuple[np.ndarray, np.ndarray]:
    X = rng.normal(size=(n, 3)) * [1.0, 1e4, 1e-5] + [0.5, 0.0, 1e-5]
    return X @ [3.0, -2e-4, 7e5] + 0.1 * rng.normal(size=n), X


def test_least_squares_equals_numpy(rng: np.random.Generator) -> None:
    y, X = problem(rng)
    scale = np.linalg.norm(X, axis=0)
    expected = np.linalg.lstsq(X / scale, y, rcond=None)[0] / scale
    solution = least_squares(y, factor(X, NAMES))
    assert solution.theta == pytest.approx(expected, rel=1e-12)
    assert solution.residuals == pytest.approx(y - X @ expected, abs=1e-10)


def test_covariance_is_the_textbook_formula(rng: np.random.Generator) -> None:
    y, X = problem(rng)
    solution = least_squares(y, factor(X, NAMES))
    rss = float(np.sum((y - X @ solution.theta) ** 2))
    inverse = np.linalg.inv(X.T @ X)
    assert PublishedCovariance().matrix(solution) == pytest.approx(rss / 59 * inverse, rel=1e-9)
    assert Classical().matrix(solution) == pytest.approx(rss / 57 * inverse, rel=1e-9)


def test_instrumental_variables_are_the_textbook_formula(rng: np.random.Generator) -> None:
    y, X = problem(rng)
    Z = X + 0.1 * np.linalg.norm(X, axis=0) * rng.normal(size=X.shape) / 8
    solution = instrumental_variables(y, factor(X, NAMES), factor(Z, NAMES))
    assert solution.theta == pytest.approx(np.linalg.solve(Z.T @ X, Z.T @ y), rel=1e-8)
    assert Z.T @ solution.residuals == pytest.approx(np.zeros(3), abs=1e-6 * np.abs(Z).max())
    variance = solution.residuals @ solution.residuals / 59
    assert PublishedCovariance().matrix(solution) == pytest.approx(
        variance * np.linalg.inv(Z.T @ Z), rel=1e-8
    )


def test_instruments_equal_to_the_regressor_give_least_squares(rng: np.random.Generator) -> None:
    y, X = problem(rng)
    by_iv, by_ls = (
        instrumental_variables(y, factor(X, NAMES), factor(X, NAMES)),
        least_squares(y, factor(X, NAMES)),
    )
    assert by_iv.theta == pytest.approx(by_ls.theta, rel=1e-12)


@given(exponents=st.lists(st.integers(-12, 12), min_size=3, max_size=3))
def test_units_of_the_columns_do_not_matter(exponents: list[int]) -> None:
    y, X = problem(np.random.default_rng(1))
    scale = 10.0 ** np.array(exponents)
    assert least_squares(y, factor(X * scale, NAMES)).theta * scale == pytest.approx(
        least_squares(y, factor(X, NAMES)).theta, rel=1e-11
    )


def test_weights_are_those_of_statsmodels_and_their_unit_does_not_matter(
    rng: np.random.Generator,
) -> None:
    X, weights = rng.normal(size=(200, 3)), rng.uniform(0.1, 3.0, 200)
    y = X @ [1.0, -2.0, 0.5] + rng.normal(size=200)
    expected = sm.WLS(y, X, weights).fit()
    columns = factor(X, "abc")
    found = weighted_least_squares(y, columns, weights)
    assert found.theta == pytest.approx(expected.params, rel=1e-11)
    robust = expected.get_robustcov_results("HC0").cov_params()
    assert Robust(corrected=False).matrix(found) == pytest.approx(robust, rel=1e-10)
    sandwich = found.influence.T @ found.influence * np.sum(found.residuals**2) / 199
    assert PublishedCovariance().matrix(found) == pytest.approx(sandwich, rel=1e-11)
    scaled = weighted_least_squares(y, columns, 1e6 * weights)
    alike = weighted_least_squares(y, columns, np.full(200, 7.0))
    plain = least_squares(y, columns)
    for covariance in (PublishedCovariance(), Classical(), Robust()):
        assert covariance.matrix(scaled) == pytest.approx(covariance.matrix(found), rel=1e-10)
        assert covariance.matrix(alike) == pytest.approx(covariance.matrix(plain), rel=1e-10)


def test_instruments_remove_the_bias_of_noisy_regressors() -> None:
    rng = np.random.default_rng(3)
    clean = rng.normal(size=(20_000, 1))
    noisy = clean + rng.normal(size=clean.shape)
    y = 2.0 * clean[:, 0]
    assert least_squares(y, factor(noisy, ["a"])).theta[0] == pytest.approx(1.0, abs=0.05)
    assert instrumental_variables(y, factor(noisy, ["a"]), factor(clean, ["a"])).theta[
        0
    ] == pytest.approx(2.0, abs=0.05)


def test_dependent_columns_are_named_with_their_trade(rng: np.random.Generator) -> None:
    y, X = problem(rng)
    X[:, 2] = 4e-4 * X[:, 0]
    with refuses("not-told-apart", says=r"change of a -0\.0004, c \+1|a -0.0004"):
        least_squares(y, factor(X, NAMES))


def test_rounding_of_filtered_columns_does_not_hide_their_dependence(
    rng: np.random.Generator,
) -> None:
    """Heavy decimation leaves few rows, and more rounding than their number would excuse."""
    q = np.cumsum(rng.normal(size=20_000))
    f = SampledFilter(Prefilter(cutoff=1.0, decimate=100, drop=(0, 0)), 1e-3)
    X = f.reduce(np.column_stack([q, q - 0.0213, np.ones_like(q)]))
    with refuses("not-told-apart", says="change of a"):
        factor(X, NAMES)


def test_silent_column_is_named(rng: np.random.Generator) -> None:
    y, X = problem(rng)
    X[:, 1] = 0.0
    with refuses("zero-column", says=r"cannot show b"):
        least_squares(y, factor(X, NAMES))


def test_useless_instruments_are_refused(rng: np.random.Generator) -> None:
    _, X = problem(rng)
    with refuses("not-told-apart", says="simulated loop"):
        factor(np.ones_like(X), NAMES, "the simulated loop")


def test_orthogonal_instruments_are_refused() -> None:
    X = np.repeat([[1.0], [-1.0]], 10, axis=0)
    with refuses("not-told-apart", says="instruments together with the record"):
        instrumental_variables(X[:, 0], factor(X, ["a"]), factor(np.ones_like(X), ["a"]))


def test_fewer_rows_than_parameters_are_refused(rng: np.random.Generator) -> None:
    y, X = problem(rng, n=3)
    with refuses("too-few-rows", says="3 rows are left for 3"):
        least_squares(y, factor(X, NAMES))


def test_regressor_that_is_not_finite_is_refused(rng: np.random.Generator) -> None:
    y, X = problem(rng)
    X[4, 1] = np.inf
    with refuses("regressor-not-finite"):
        least_squares(y, factor(X, NAMES))


def test_condition_number_is_that_of_the_columns_as_they_are() -> None:
    assert condition_number(np.diag([100.0, 1.0])) == pytest.approx(100.0)
    assert condition_number(np.empty((0, 2))) == np.inf


def test_delta_method_is_exact_for_linear_maps(rng: np.random.Generator) -> None:
    root = rng.normal(size=(3, 3))
    J = rng.normal(size=(2, 3))
    mapped = delta_method(root @ root.T, J)
    assert mapped == pytest.approx(J @ root @ root.T @ J.T)
    assert np.array_equal(mapped, mapped.T)


@pytest.mark.parametrize(
    ("sizes", "named"), [((1.0, 1e160, 1.0), "b"), ((-1e200, 1.0, 1e300), "a, c")]
)
def test_columns_whose_squares_no_number_holds_are_refused_by_name(
    rng: np.random.Generator, sizes: tuple[float, ...], named: str
) -> None:
    _, X = problem(rng)
    X = X / np.abs(X).max(axis=0) * sizes
    largest = f"{max(map(abs, sizes)):.3g}".replace("+", r"\+")
    with refuses(
        "regressor-too-large",
        says=rf"^the regressor of the log reaches {largest} in the columns of {named}, whose",
    ):
        factor(X, NAMES, "the log")


def test_columns_whose_squares_a_number_just_holds_are_factored(rng: np.random.Generator) -> None:
    y, X = problem(rng)
    large = X / np.linalg.norm(X, axis=0) * 1e153
    theta = least_squares(y, factor(large, NAMES)).theta
    assert large @ theta == pytest.approx(X @ least_squares(y, factor(X, NAMES)).theta, rel=1e-9)
