"""Instruments are as strong as linearmodels and statsmodels have them."""

from dataclasses import replace

import numpy as np
import pytest
import statsmodels.api as sm
from linearmodels.iv import IV2SLS

from axisid import Identification
from axisid.estimation.diagnostics.agreement_of_estimates import (
    InstrumentTests,
    instrument_tests,
    tests_of_instruments as strength_of,
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


def test_strength_is_the_first_stage_of_linearmodels_and_statsmodels(data: Data) -> None:
    """The conditional F of Sanderson and Windmeijer (2016), of what the other columns leave."""
    y, X, Z = data
    stage = IV2SLS(y, None, X, Z).fit(cov_type="unadjusted").first_stage.diagnostics
    for j, ours in enumerate(instrument_tests(X, Z, NAMES).columns):
        assert ours.r_squared == pytest.approx(stage["rsquared"].iloc[j], rel=1e-9)
        assert ours.shea == pytest.approx(stage["shea.rsquared"].iloc[j], rel=1e-9)
        assert ours.f == pytest.approx(sm.OLS(X[:, j], Z).fit().fvalue, rel=1e-9)
        others = np.delete(X, j, axis=1)
        left_over = IV2SLS(X[:, j], None, others, Z).fit().resids.to_numpy()
        fit = sm.OLS(left_over, Z).fit()
        assert ours.conditional_f == pytest.approx(fit.ess / (fit.ssr / fit.df_resid), rel=1e-8)


def test_strength_is_of_the_rows_as_the_fit_weights_them(result: Identification) -> None:
    """As of records of unlike noise."""
    iv = result["idm-iv"]
    weights = np.where(np.arange(len(iv.y)) < len(iv.y) / 2, 30.0, 1 / 30)
    tests = strength_of(replace(iv, weights=weights))
    stage = IV2SLS(iv.y, None, iv.X, iv.Z, weights=weights**2).fit().first_stage.diagnostics
    assert isinstance(tests, InstrumentTests)
    ours = [(column.r_squared, column.shea) for column in tests.columns]
    assert ours == pytest.approx(stage[["rsquared", "shea.rsquared"]].to_numpy(), rel=1e-6)


def test_instruments_of_columns_that_they_cannot_tell_apart_are_weak(
    rng: np.random.Generator,
) -> None:
    Z = rng.normal(size=(300, 2))
    both = Z @ [1.0, 1.0]
    X = np.column_stack([both, both]) + 0.1 * rng.normal(size=(300, 2))
    for column in instrument_tests(X, Z, NAMES[: X.shape[1]]).columns:
        assert column.f > 1e3
        assert column.conditional_f < 10


def test_one_column_and_one_that_is_its_own_instrument(data: Data) -> None:
    _, X, Z = data
    (only,) = instrument_tests(X[:, :1], Z[:, :1], NAMES[:1]).columns
    assert only.conditional_f == pytest.approx(only.f, rel=1e-12)
    Z[:, 2] = X[:, 2]
    assert instrument_tests(X, Z, NAMES).columns[2].conditional_f == float("inf")


def test_columns_that_rows_do_not_tell_apart_are_named(data: Data) -> None:
    """As where one of several records does not show what all of them do."""
    _, X, Z = data
    for columns, instruments, named in (
        (X[:, [0, 0]], Z[:, :2], ()),
        (X[:, :2], Z[:, [0, 0]], ()),
        (X[:, :2] * [1.0, 0.0], Z[:, :2], ("b",)),
    ):
        with refuses("not-shown", *named):
            instrument_tests(columns, instruments, NAMES[:2])
