"""Diagnostics against linearmodels and statsmodels, and what they say of the paper's twin."""

import numpy as np
import pytest
import statsmodels.api as sm
from linearmodels.iv import IV2SLS

from axisid.estimation.diagnostics.estimates.method import (
    instrument_tests,
)
from tests.refusals import refuses

Data = tuple[np.ndarray, np.ndarray, np.ndarray]
NAMES = ("a", "b", "c")


@pytest.fixture
def data(rng: np.random.Generator) -> Data:
    n = 500
    e = rng.normal(size=n)
    Z = rng.normal(size=(n, 3))
    X = Z @ np.array([[1, 0.2, 0], [0, 0.5, 0], [0.3, 0, 2]]) + 0.5 * rng.normal(size=(n, 3))
    X += 0.3 * e[:, None]
    return X @ [1.0, 2.0, 3.0] + e, X, Z


def test_strength_is_the_first_stage_of_linearmodels(data: Data) -> None:
    y, X, Z = data
    stage = IV2SLS(y, None, X, Z).fit(cov_type="unadjusted").first_stage.diagnostics
    for j, ours in enumerate(instrument_tests(X, Z, NAMES[: X.shape[1]]).columns):
        assert ours.r_squared == pytest.approx(stage["rsquared"].iloc[j], rel=1e-9)
        assert ours.shea == pytest.approx(stage["shea.rsquared"].iloc[j], rel=1e-9)


def test_f_of_the_first_stage_is_that_of_the_regression(data: Data) -> None:
    _, X, Z = data
    for j, ours in enumerate(instrument_tests(X, Z, NAMES[: X.shape[1]]).columns):
        fit = sm.OLS(X[:, j], Z).fit()
        assert ours.f == pytest.approx(fit.fvalue, rel=1e-9)


def test_conditional_f_is_the_first_stage_of_what_the_other_columns_leave(data: Data) -> None:
    """Sanderson and Windmeijer (2016), put together from two estimators of others."""
    _, X, Z = data
    for j, ours in enumerate(instrument_tests(X, Z, NAMES[: X.shape[1]]).columns):
        others = np.delete(X, j, axis=1)
        left_over = IV2SLS(X[:, j], None, others, Z).fit().resids.to_numpy()
        stage = sm.OLS(left_over, Z).fit()
        expected = stage.ess / (stage.ssr / stage.df_resid)
        assert ours.conditional_f == pytest.approx(expected, rel=1e-8)


def test_instruments_of_columns_that_they_cannot_tell_apart_are_weak(
    rng: np.random.Generator,
) -> None:
    Z = rng.normal(size=(300, 2))
    both = Z @ [1.0, 1.0]
    X = np.column_stack([both, both]) + 0.1 * rng.normal(size=(300, 2))
    for column in instrument_tests(X, Z, NAMES[: X.shape[1]]).columns:
        assert column.f > 1e3
        assert column.conditional_f < 10


def test_conditional_f_of_one_column_is_its_f(data: Data) -> None:
    _, X, Z = data
    (only,) = instrument_tests(X[:, :1], Z[:, :1], NAMES[:1]).columns
    assert only.conditional_f == pytest.approx(only.f, rel=1e-12)


def test_column_that_is_its_own_instrument_is_strong(data: Data) -> None:
    _, X, Z = data
    Z[:, 2] = X[:, 2]
    assert instrument_tests(X, Z, NAMES[: X.shape[1]]).columns[2].conditional_f == float("inf")


def test_columns_that_rows_do_not_tell_apart_are_named(data: Data) -> None:
    """As where one of several records does not show what all of them do."""
    _, X, Z = data
    for columns, instruments in ((X[:, [0, 0]], Z[:, :2]), (X[:, :2], Z[:, [0, 0]])):
        with refuses("not-shown"):
            instrument_tests(columns, instruments, NAMES[:2])
    with refuses("not-shown", "b"):
        instrument_tests(X[:, :2] * [1.0, 0.0], Z[:, :2], NAMES[:2])
