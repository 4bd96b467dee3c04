"""Nested models: found from their columns, tested as statsmodels does."""

import numpy as np
import pytest
import statsmodels.api as sm

from axisid.estimation.regression import joint_p
from axisid.estimation.regression.covariance import Classical, Hac
from axisid.estimation.signals import RowTimes
from axisid.estimation.studies.candidate import criteria, embedding, nested_tests, wald_test
from axisid.estimation.studies.held_out import Regression

N = 300


def rows(X: np.ndarray, left: np.ndarray) -> Regression:
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
    X, y = data
    full, part = sm.OLS(y, X).fit(), sm.OLS(y, X[:, :2]).fit()
    found = criteria(rows(X, y).solved())
    assert found.log_likelihood == pytest.approx(full.llf, rel=1e-10)
    assert found.aic == pytest.approx(full.aic, rel=1e-10)
    assert found.bic == pytest.approx(full.bic, rel=1e-10)
    f, p, restrictions = full.compare_f_test(part)
    assert restrictions == 2
    how = embedding(rows(X[:, :2], y), rows(X, y))
    assert wald_test(rows(X, y).solved(), how, Classical()) == pytest.approx((f, p))


def test_robust_wald_is_that_of_statsmodels(data: tuple[np.ndarray, np.ndarray]) -> None:
    X, y = data
    lags = {"maxlags": 6, "use_correction": True}
    robust = sm.OLS(y, X).fit(cov_type="HAC", cov_kwds=lags, use_t=True)
    cases = {
        "a column left out": (X[:, :3], [[0, 0, 0, 1]]),
        "two left out": (X[:, [0, 2]], [[0, 1, 0, 0], [0, 0, 0, 1]]),
        "two columns with one weight": (
            np.column_stack([X[:, 0], X[:, 1] + X[:, 2], X[:, 3]]),
            [[0, 1, -1, 0]],
        ),
    }
    for small, restriction in cases.values():
        how = embedding(rows(small, y), rows(X, y))
        expected = robust.f_test(np.array(restriction, dtype=float))
        larger = rows(X, y).solved()
        statistic, p = wald_test(larger, how, Hac(6))
        assert statistic == pytest.approx(float(expected.fvalue), rel=1e-6)
        # statsmodels takes the rows for the freedom, of which lags leave fewer.
        q, freedom = len(restriction), float(Hac(6).applied(larger).freedom.min())
        assert freedom < N - 4
        assert p == pytest.approx(joint_p(q * statistic, q, freedom))
        assert p >= float(expected.pvalue)


def test_takeuchi_is_akaike_where_rows_are_independent(rng: np.random.Generator) -> None:
    X = rng.normal(size=(40_000, 3))
    found = criteria(rows(X, X @ [1.0, 2.0, 3.0] + rng.normal(size=len(X))).solved())
    assert found.tic - found.aic == pytest.approx(0, abs=0.6)
    grouped = np.repeat(X[:4000], 10, axis=0)
    noise = np.repeat(rng.normal(size=4000), 10)
    repeated = criteria(rows(grouped, grouped @ [1.0, 2.0, 3.0] + noise).solved())
    assert repeated.tic - repeated.aic > 30  # each row ten times: the penalty is ten times 2 k


def test_what_does_not_contain_is_not_nested(data: tuple[np.ndarray, np.ndarray]) -> None:
    X, y = data
    assert embedding(rows(X[:, :2], y), rows(X[:, 1:], y)) is None
    almost = X[:, :2] * [1, 1 + 1e-6] + [0, 1e-6]
    assert embedding(rows(almost, y), rows(X, y)) is None


def test_a_known_part_must_be_spanned_too(data: tuple[np.ndarray, np.ndarray]) -> None:
    """A model with a known coefficient is nested in the one that estimates it."""
    X, y = data
    fixed = rows(X[:, :3], y - 0.02 * X[:, 3])
    how = embedding(fixed, rows(X, y))
    assert how.start == pytest.approx([0, 0, 0, 0.02], abs=1e-9)
    lags = {"maxlags": 6, "use_correction": True}
    robust = sm.OLS(y, X).fit(cov_type="HAC", cov_kwds=lags, use_t=True)
    expected = robust.t_test((np.array([[0.0, 0, 0, 1]]), np.array([0.02])))
    statistic, _ = wald_test(rows(X, y).solved(), how, Hac(6))
    assert statistic == pytest.approx(float(expected.tvalue.item()) ** 2, rel=1e-6)
    assert embedding(rows(X[:, :3], y - np.sin(np.arange(N))), rows(X, y)) is None


def test_only_next_richer_models_are_tested_and_equal_ones_are_told(
    data: tuple[np.ndarray, np.ndarray],
) -> None:
    X, y = data
    models = {
        "one": rows(X[:, :1], y),
        "two": rows(X[:, :2], y),
        "mixed": rows(np.column_stack([X[:, 0] + 50 * X[:, 1], X[:, 1]]), y),
        "other": rows(X[:, 2:3], y),
        "all": rows(X, y),
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
    assert all(t.dof == N - len(models[t.larger].names) for t in tests)
