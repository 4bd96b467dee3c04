"""Checks of residuals: which status each figure has, and whether the numbers suffer of it."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from axisid.estimation.diagnostics.remainder.residuals import normality
from axisid.estimation.estimates import Estimate
from axisid.estimation.regression import ResidualTests
from axisid.estimation.regression.residual_tests import residual_tests

ROWS = 400


def white(seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """Independent normal residuals, at right angles to two instruments."""
    rng = np.random.default_rng(seed)
    W = rng.normal(size=(ROWS, 2))
    residuals = rng.normal(size=ROWS)
    return residuals - W @ np.linalg.lstsq(W, residuals, rcond=None)[0], W


def judged(residuals: np.ndarray) -> ResidualTests:
    return residual_tests(residuals, white()[1])


@pytest.fixture(scope="module")
def good() -> ResidualTests:
    return judged(white()[0])


def estimate(residuals: np.ndarray, **more: Any) -> Estimate:
    """What the checks ask of an estimate."""
    coordinate = SimpleNamespace(force_unit="N", acceleration_unit="m/s^2")
    form = SimpleNamespace(
        left="force",
        axis=SimpleNamespace(axis=SimpleNamespace(coordinate=coordinate)),
        quantities=[
            SimpleNamespace(name="M", label="M", expression=""),
            SimpleNamespace(name="Fv", label="Fv", expression=""),
        ],
    )
    settled = {"y": residuals, "Z": None, "period": 1e-3, "times": None, "noise_free": None}
    settled |= {"counts": None, "score_columns": more.get("X")}
    settled["net_residuals"] = residuals
    rows = 10 * np.arange(len(residuals))
    return cast(
        Estimate,
        SimpleNamespace(
            residuals=residuals, form=form, rows=rows, by_output_error=False, **{**settled, **more}
        ),
    )


def test_white_residuals_pass(good: ResidualTests) -> None:
    assert normality(good, estimate(white()[0])).status == "pass"


def test_heavy_tails_count_once_where_another_check_names_what_makes_them() -> None:
    heavy = white()[0]
    heavy[::40] *= 12
    found = [normality(judged(heavy), estimate(heavy), explained=e).status for e in (False, True)]
    assert found == ["fail", "note"]


@pytest.mark.parametrize(
    ("rows", "kurtosis", "status"),
    [(99, 1.0, "fail"), (100, 1.0, "note"), (1000, 8.1, "fail"), (1000, 7.9, "note")],
)
def test_tails_matter_where_rows_are_few_or_outliers_decide(
    good: ResidualTests, rows: int, kurtosis: float, status: str
) -> None:
    tails = replace(good, jarque_bera=50.0, jarque_bera_p=1e-9, excess_kurtosis=kurtosis)
    assert normality(tails, estimate(np.resize(white()[0], rows))).status == status


@pytest.mark.parametrize(("place", "status"), [(0, "note"), (ROWS - 1, "fail")])
def test_tails_that_are_near_reversals_are_told_of_by_other_checks(place: int, status: str) -> None:
    """Outliers among the first rows, which are near a reversal, and in the last."""
    residuals = white()[0].copy()
    residuals[place] = 30.0
    away = np.arange(ROWS) >= 20
    made = estimate(residuals, net_residuals=residuals)
    assert normality(judged(residuals), made, away).status == status
    assert normality(judged(residuals), made).status == "fail"
    assert normality(judged(residuals), made, np.arange(ROWS) >= ROWS - 20).status == "fail"


def test_the_largest_residual_is_told_with_its_sample_and_time(good: ResidualTests) -> None:
    residuals = white()[0].copy()
    residuals[123] = -40.0
    tails = replace(good, jarque_bera_p=0.0, excess_kurtosis=50.0)
    assert "sample 1231, 1.23 s" in normality(tails, estimate(residuals)).meaning
    times = 5.0 + np.arange(ROWS)
    assert "sample 1231, 128 s" in normality(tails, estimate(residuals, times=times)).meaning
    light = replace(tails, excess_kurtosis=-1.0)
    assert "sample" not in normality(light, estimate(residuals)).meaning
