"""Covariances are rows of a table, and the user's choice."""

import json
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import statsmodels.api as sm
from scipy.special import stdtrit

from axisid import Identification, Record, identify, load_result
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation import choices
from axisid.estimation.estimates import COVARIANCES
from tests.recipes import recipe_blocks
from tests.refusals import refuses

NAME, RECIPE = "hc3", "Add a covariance"
MODULE = "axisid.estimation.regression.leave_one_out"


@pytest.fixture
def added(monkeypatch: pytest.MonkeyPatch) -> None:
    text, written = recipe_blocks(RECIPE)
    module = ModuleType(MODULE)
    module.__package__ = MODULE.rpartition(".")[0]
    monkeypatch.setitem(sys.modules, MODULE, module)
    exec(text, vars(module))
    row = eval(written, dict(vars(choices)))  # noqa: S307
    monkeypatch.setattr(choices, "COVARIANCE_ROWS", (*choices.COVARIANCE_ROWS, row))
    monkeypatch.setitem(COVARIANCES, NAME, row)


@pytest.fixture
def result(added: None, emps2015: GeneratedAxis, twin: Record) -> Identification:
    return identify(emps2015, twin, methods=["idm-ls", "ddm-ls"], covariance=NAME)


def test_one_class_and_one_row_add_a_covariance(result: Identification) -> None:
    estimate = result["idm-ls"]
    fitted = sm.OLS(estimate.y, estimate.X).fit(cov_type="HC3")
    assert estimate.covariances[NAME] == pytest.approx(fitted.cov_params(), rel=1e-9)
    for estimate in result.estimates.values():
        for value, variance in zip(
            estimate.parameters.values(), np.diag(estimate.covariances[NAME]), strict=True
        ):
            assert {*value.deviations} == {*COVARIANCES}
            assert value.deviation == value.deviations[NAME] == pytest.approx(np.sqrt(variance))
    assert "HC3" in result.summary(full=True)


@pytest.mark.usefixtures("added")
def test_a_file_of_a_covariance_that_is_not_there_is_refused(
    result: Identification, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "result.json"
    file.write_text(json.dumps(result.to_dict()))
    monkeypatch.delitem(COVARIANCES, NAME)
    with refuses("result-file", says="'hc3'"):
        load_result(file)


@pytest.mark.slow
@pytest.mark.parametrize("chosen", ["hac", "robust", "iid"])
def test_intervals_draws_and_correlation_are_of_the_chosen_covariance(
    emps2015: GeneratedAxis, twin: Record, chosen: str
) -> None:
    result = identify(emps2015, twin, covariance=chosen)  # type: ignore[arg-type]
    for method in ("idm-iv", "ddm-ls"):
        estimate = result[method]
        covariance = estimate.covariances[chosen]
        reach = stdtrit(estimate.freedom[chosen], 0.975) * np.sqrt(np.diag(covariance))
        for value, r, sd in zip(
            estimate.parameters.values(), reach, np.sqrt(np.diag(covariance)), strict=True
        ):
            assert value.deviation == pytest.approx(sd)
            assert value.interval == pytest.approx((value.corrected - r, value.corrected + r))
        drawn = estimate.propagate("M", draws=20_000)
        assert drawn.interval == pytest.approx(
            estimate.parameters["M"].interval, abs=0.06 * estimate.parameters["M"].deviation
        )
        assert estimate.derive("M").deviation == pytest.approx(np.sqrt(covariance[0, 0]))
    assert result.to_dict()["estimates"][0]["chosen_covariance"] == chosen


def test_another_covariance_is_refused(emps2015: GeneratedAxis, twin: Record) -> None:
    with refuses("method", says="hac, robust, iid"):
        identify(emps2015, twin, covariance="bootstrap")  # type: ignore[arg-type]
