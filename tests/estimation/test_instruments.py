"""Diagnostics against linearmodels and statsmodels, and what they say of the paper's twin."""

import numpy as np
import pytest
import statsmodels.api as sm
from linearmodels.iv import IV2SLS

from axisid.estimation import Classical, Hac
from axisid.estimation.instruments import endogeneity, instrument_tests

Data = tuple[np.ndarray, np.ndarray, np.ndarray]


@pytest.fixture
def data(rng: np.random.Generator) -> Data:
    n = 500
    e = rng.normal(size=n)
    Z = rng.normal(size=(n, 3))
    X = Z @ np.array([[1, 0.2, 0], [0, 0.5, 0], [0.3, 0, 2]]) + 0.5 * rng.normal(size=(n, 3))
    X += 0.3 * e[:, None]
    return X @ [1.0, 2.0, 3.0] + e, X, Z


def test_endogeneity_is_the_wu_hausman_test_of_linearmodels(data: Data) -> None:
    y, X, Z = data
    expected = IV2SLS(y, None, X, Z).fit(cov_type="unadjusted").wu_hausman()
    ours = endogeneity(y, X, Z, Classical())
    assert ours.statistic == pytest.approx(expected.stat, rel=1e-9)
    assert ours.p_value == pytest.approx(expected.pval, rel=1e-7, abs=1e-300)


def test_endogeneity_is_not_found_where_there_is_none(rng: np.random.Generator) -> None:
    Z = rng.normal(size=(400, 2))
    X = Z + 0.5 * rng.normal(size=(400, 2))
    p_values = [
        endogeneity(X @ [1.0, 2.0] + rng.normal(size=400), X, Z, Hac()).p_value for _ in range(200)
    ]
    assert 0.02 < np.mean(np.array(p_values) < 0.05) < 0.10
    assert endogeneity(X @ [1.0, 2.0] + rng.normal(size=400), X, X, Hac()).p_value == 1.0


def test_exact_instruments_of_one_column_leave_the_others_tested(data: Data) -> None:
    y, X, Z = data
    Z = Z.copy()
    Z[:, 2] = X[:, 2]
    result = endogeneity(y, X, Z, Classical())
    assert np.isnan(result.by_parameter[2])
    assert result.by_parameter[0] < 1e-3


def test_strength_is_the_first_stage_of_linearmodels(data: Data) -> None:
    y, X, Z = data
    stage = IV2SLS(y, None, X, Z).fit(cov_type="unadjusted").first_stage.diagnostics
    for j, ours in enumerate(instrument_tests(X, Z).columns):
        assert ours.r_squared == pytest.approx(stage["rsquared"].iloc[j], rel=1e-9)
        assert ours.shea == pytest.approx(stage["shea.rsquared"].iloc[j], rel=1e-9)


def test_f_of_the_first_stage_is_that_of_the_regression(data: Data) -> None:
    _, X, Z = data
    for j, ours in enumerate(instrument_tests(X, Z).columns):
        fit = sm.OLS(X[:, j], Z).fit()
        assert ours.f == pytest.approx(fit.fvalue, rel=1e-9)


def test_weak_instruments_have_a_small_f(rng: np.random.Generator) -> None:
    X = rng.normal(size=(300, 2))
    Z = np.column_stack([X[:, 0], rng.normal(size=300)])
    strong, weak = instrument_tests(X, Z).columns
    assert strong.f > 1e3
    assert weak.f < 10
    assert weak.shea < 0.1
