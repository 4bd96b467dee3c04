"""Diagnostics against linearmodels and statsmodels, and what they say of the paper's twin."""

from dataclasses import replace

import numpy as np
import pytest
import statsmodels.api as sm
from linearmodels.iv import IV2SLS

from axisid import Prefilter, identify, twin_record
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.estimation.diagnostics.estimates.instruments import (
    Endogeneity,
    biased_parameters,
    endogeneity,
    endogeneity_of,
    instrument_tests,
)
from axisid.estimation.regression.covariance import Classical, Hac
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


def test_endogeneity_is_the_wu_hausman_test_of_linearmodels(data: Data) -> None:
    y, X, Z = data
    expected = IV2SLS(y, None, X, Z).fit(cov_type="unadjusted").wu_hausman()
    ours = endogeneity(y, X, Z, Classical())
    assert ours.statistic == pytest.approx(expected.stat, rel=1e-9)
    assert ours.p_value == pytest.approx(expected.pval, rel=1e-7, abs=1e-300)


def test_endogeneity_gives_the_durbin_statistic_of_linearmodels(data: Data) -> None:
    """Durbin's chi-squared and the F of the regression form are two sides of one sum of squares."""
    y, X, Z = data
    expected = IV2SLS(y, None, X, Z).fit(cov_type="unadjusted").durbin()
    ours = endogeneity(y, X, Z, Classical())
    q, dof = X.shape[1], len(y) - 2 * X.shape[1]
    explained = q * ours.statistic
    assert len(y) * explained / (explained + dof) == pytest.approx(expected.stat, rel=1e-9)


@pytest.mark.parametrize(("appropriate", "listed"), [(True, ()), (False, ("M",))])
def test_on_the_papers_twin_the_test_rejects_and_size_decides(
    emps2015: GeneratedAxis, appropriate: bool, listed: tuple[str, ...]
) -> None:
    """Noise enters through the loop, hardly any through the equation: any bias is significant."""
    settings = (60.0, 10) if appropriate else (180.0, 3)
    prefilter = Prefilter(cutoff=settings[0], decimate=settings[1])
    result = identify(emps2015, twin_record(emps2015), prefilter, bootstrap=0)
    tested = endogeneity_of(result["idm-iv"])
    assert isinstance(tested, Endogeneity)
    assert tested.p_value < 1e-3
    assert biased_parameters(result["idm-ls"], result["idm-iv"], tested) == listed
    (check,) = (c for c in result.verdict if c.name == "least squares against instruments")
    assert check.status == "note"
    assert "its 95 % interval of M misses for it" in check.meaning


def test_endogeneity_is_seldom_found_where_there_is_none(rng: np.random.Generator) -> None:
    Z = rng.normal(size=(400, 2))
    X = Z + 0.5 * rng.normal(size=(400, 2))
    p_values = [
        endogeneity(X @ [1.0, 2.0] + rng.normal(size=400), X, Z, Hac()).p_value for _ in range(200)
    ]
    # HAC tests of 400 rows reject somewhat more often than they say.
    assert 0.02 < np.mean(np.array(p_values) < 0.05) < 0.14
    assert endogeneity(X @ [1.0, 2.0] + rng.normal(size=400), X, X, Hac()).p_value == 1.0


def test_exact_instruments_of_one_column_leave_the_others_tested(data: Data) -> None:
    y, X, Z = data
    Z = Z.copy()
    Z[:, 2] = X[:, 2]
    result = endogeneity(y, X, Z, Classical())
    assert np.isnan(result.by_parameter[2])
    assert result.by_parameter[0] < 1e-3


def test_two_columns_with_one_residual_are_tested_once(data: Data) -> None:
    """Friction of its own in each direction: the levels' columns add up to a constant."""
    y, X, Z = data
    noisy, exact = np.sign(X[:, 0]), np.sign(Z[:, 0])
    once = endogeneity(
        y,
        np.column_stack([noisy, np.ones(len(y))]),
        np.column_stack([exact, np.ones(len(y))]),
        Classical(),
    )
    both = endogeneity(
        y,
        np.column_stack([(1 + noisy) / 2, (noisy - 1) / 2]),
        np.column_stack([(1 + exact) / 2, (exact - 1) / 2]),
        Classical(),
    )
    assert both.statistic == pytest.approx(once.statistic, rel=1e-9)
    assert both.by_parameter[0] == pytest.approx(once.by_parameter[0], rel=1e-9)
    assert np.isnan(both.by_parameter[1])


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


def test_weak_instruments_have_a_small_f(rng: np.random.Generator) -> None:
    X = rng.normal(size=(300, 2))
    Z = np.column_stack([X[:, 0], rng.normal(size=300)])
    strong, weak = instrument_tests(X, Z, NAMES[: X.shape[1]]).columns
    assert strong.f > 1e3
    assert weak.f < 10
    assert weak.shea < 0.1


@pytest.mark.parametrize(("disturbance", "listed"), [(0.0, ()), (400.0, ("M",))])
def test_large_bias_is_found_however_wide_the_deviations(
    emps2015: GeneratedAxis, disturbance: float, listed: tuple[str, ...]
) -> None:
    """Noise on the recorded force widens every deviation; a bias of a tenth stays one.

    Without it the noise of the position biases the mass by 1 % at this cut-off, which the paper's
    rule finds within its deviations and nobody would notice.
    """
    record = twin_record(emps2015)
    assert record.control is not None
    noise = np.random.default_rng(3).normal(0.0, disturbance / 35.15, len(record))
    noisy = replace(record, control=record.control + noise)
    prefilter = Prefilter(cutoff=120.0, decimate=4) if disturbance else Prefilter()
    result = identify(emps2015, noisy, prefilter, ["idm-ls", "idm-iv"])
    ls, iv = result["idm-ls"], result["idm-iv"]
    assert biased_parameters(ls, iv, endogeneity_of(iv)) == listed
    if listed:
        assert np.all(
            np.abs(ls.physical - iv.physical) < 3 * np.sqrt(np.diag(iv.covariances["iid"]))
        )


def test_columns_that_rows_do_not_tell_apart_are_named(data: Data) -> None:
    """As where one of several records does not show what all of them do."""
    _, X, Z = data
    for columns, instruments in ((X[:, [0, 0]], Z[:, :2]), (X[:, :2], Z[:, [0, 0]])):
        with refuses("not-told-apart"):
            instrument_tests(columns, instruments, NAMES[:2])
    with refuses("zero-column", "b"):
        instrument_tests(X[:, :2] * [1.0, 0.0], Z[:, :2], NAMES[:2])
