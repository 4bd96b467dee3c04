"""Criteria and tests of nested models are those of statsmodels."""

import numpy as np
import pytest
import statsmodels.api as sm

from axisid.estimation.model_selection.comparison import criteria
from axisid.estimation.model_selection.held_out import Regression
from axisid.estimation.model_selection.nested_models import nested_tests, nesting, wald_test
from axisid.estimation.regression import hotelling_p_value
from axisid.estimation.regression.covariance import Classical, Hac
from axisid.estimation.signals import RowTimes

N = 300
#: Of statsmodels' HAC covariance.
ROBUST = {
    "cov_type": "HAC",
    "cov_kwds": {"maxlags": 6, "use_correction": True},
    "use_t": True,
}


def regression(X: np.ndarray, left: np.ndarray) -> Regression:
    return Regression(
        left=left,
        regressor=X,
        instruments=None,
        names=tuple(f"p{i}" for i in range(X.shape[1])),
        neighbours=RowTimes.consecutive(len(left)),
    )


@pytest.fixture
def data(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Columns of unlike sizes, and a response with autocorrelated residuals."""
    X = rng.normal(size=(N, 4)) * [1e3, 1.0, 1e-4, 10.0]
    shocks, e = rng.normal(size=N), np.zeros(N)
    for i in range(1, N):
        e[i] = 0.6 * e[i - 1] + shocks[i]
    return X, X @ [1e-3, 0.5, 500.0, 0.01] + e


def test_criteria_and_f_are_those_of_statsmodels(data: tuple[np.ndarray, np.ndarray]) -> None:
    """The Wald statistic is F by the covariance of least squares."""
    X, y = data
    full = sm.OLS(y, X).fit()
    found = criteria(regression(X, y))
    wanted = (full.llf, full.aic, full.bic)
    assert (found.log_likelihood, found.aic, found.bic) == pytest.approx(wanted, rel=1e-10)
    f, p, _ = full.compare_f_test(sm.OLS(y, X[:, :2]).fit())
    how = nesting(regression(X[:, :2], y), regression(X, y))
    assert wald_test(regression(X, y).solved(), how, Classical()) == pytest.approx((f, p))


def test_robust_wald_is_that_of_statsmodels(data: tuple[np.ndarray, np.ndarray]) -> None:
    X, y = data
    robust = sm.OLS(y, X).fit(**ROBUST)
    cases = {
        "a column left out": (X[:, :3], [[0, 0, 0, 1]]),
        "two left out": (X[:, [0, 2]], [[0, 1, 0, 0], [0, 0, 0, 1]]),
        "two columns with one weight": (
            np.column_stack([X[:, 0], X[:, 1] + X[:, 2], X[:, 3]]),
            [[0, 1, -1, 0]],
        ),
    }
    larger = regression(X, y).solved()
    # statsmodels takes the regression for the freedom, of which lags leave fewer.
    freedom = float(Hac(6).applied(larger).freedom.min())
    assert freedom < N - 4
    for small, restriction in cases.values():
        how = nesting(regression(small, y), regression(X, y))
        expected, q = robust.f_test(np.array(restriction, dtype=float)), len(restriction)
        statistic, p = wald_test(larger, how, Hac(6))
        assert statistic == pytest.approx(float(expected.fvalue), rel=1e-6)
        assert p == pytest.approx(hotelling_p_value(q * statistic, q, freedom))
        assert p >= float(expected.pvalue)


def test_a_known_part_must_be_spanned_too(data: tuple[np.ndarray, np.ndarray]) -> None:
    """A model with a known coefficient is nested in the one that estimates it."""
    X, y = data
    fixed = regression(X[:, :3], y - 0.02 * X[:, 3])
    how = nesting(fixed, regression(X, y))
    assert how[1] == pytest.approx([0, 0, 0, 0.02], abs=1e-9)
    robust = sm.OLS(y, X).fit(**ROBUST)
    expected = robust.t_test((np.array([[0.0, 0, 0, 1]]), np.array([0.02])))
    statistic, _ = wald_test(regression(X, y).solved(), how, Hac(6))
    assert statistic == pytest.approx(float(expected.tvalue.item()) ** 2, rel=1e-6)
    almost = X[:, :2] * [1, 1 + 1e-6] + [0, 1e-6]
    for columns, left in ((X[:, :3], y - np.sin(np.arange(N))), (almost, y)):
        assert nesting(regression(columns, left), regression(X, y)) is None


def test_only_next_richer_models_are_tested_and_equal_ones_are_told(
    data: tuple[np.ndarray, np.ndarray],
) -> None:
    X, y = data
    models = {
        "one": regression(X[:, :1], y),
        "two": regression(X[:, :2], y),
        "mixed": regression(np.column_stack([X[:, 0] + 50 * X[:, 1], X[:, 1]]), y),
        "other": regression(X[:, 2:3], y),
        "all": regression(X, y),
    }
    tests, same = nested_tests(models)
    assert same == (("two", "mixed"),)
    assert {(t.smaller, t.larger, t.restrictions) for t in tests} == {
        ("one", "two", 1),
        ("one", "mixed", 1),
        ("two", "all", 2),
        ("mixed", "all", 2),
        ("other", "all", 3),
    }
