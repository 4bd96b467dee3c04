"""Covariances are rows of a table: the recipe's goes through text, JSON, exports and back."""

import json
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import statsmodels.api as sm

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


def test_what_the_recipe_says_is_what_statsmodels_says(result: Identification) -> None:
    estimate = result["idm-ls"]
    fitted = sm.OLS(estimate.y, estimate.X).fit(cov_type="HC3")
    assert estimate.covariances[NAME] == pytest.approx(fitted.cov_params(), rel=1e-9)


def test_one_class_and_one_row_add_a_covariance(result: Identification) -> None:
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
    with refuses("unknown-saved-covariance", says="'hc3'"):
        load_result(file)
