"""Methods are rows of a table: the recipe's goes through text, JSON, page and command."""

import json
from pathlib import Path

import numpy as np
import pytest
import statsmodels.api as sm

from axisid import Prefilter, Record, UsageError, identify
from axisid.codegen.artefacts import GeneratedAxis
from axisid.commands.options import inputs
from axisid.estimation.estimates import METHODS
from axisid.estimation.regression import InverseForm
from axisid.presentation.report.page import report_html
from tests.recipes import recipe_blocks

NAME = "idm-wls"


@pytest.fixture
def added(monkeypatch: pytest.MonkeyPatch) -> None:
    module, row = recipe_blocks("Add a method of estimation")
    package = "axisid.estimation.estimates"
    names = {"__name__": f"{package}.weighted", "__package__": package, "InverseForm": InverseForm}
    exec(module, names)
    monkeypatch.setitem(METHODS, NAME, eval(row, names))  # noqa: S307


@pytest.mark.usefixtures("added")
def test_one_file_and_one_row_add_a_method(emps2015: GeneratedAxis, twin: Record) -> None:
    result = identify(emps2015, twin, Prefilter())
    assert list(result) == [*METHODS]
    alone = identify(emps2015, twin, Prefilter(), NAME)
    assert alone.preferred.method == NAME
    for each in (result, alone):
        written = json.loads(json.dumps(each.to_dict()))
        assert NAME in [e["method"] for e in written["estimates"]]
        assert "IDM-WLS" in each.summary()
        assert "IDM-WLS" in report_html(each)


@pytest.mark.usefixtures("added")
def test_what_the_recipe_estimates_is_that_of_statsmodels(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    result = identify(emps2015, twin, Prefilter(), NAME)
    found, data = result[NAME], result.data
    speed = np.abs(data.reduce(data.signals.velocity))
    weighted = sm.WLS(found.y, found.X, weights=1 / (0.1 * speed.max() + speed)).fit()
    robust = weighted.get_robustcov_results("HC1").cov_params()
    assert found.physical == pytest.approx(weighted.params, rel=1e-9)
    assert found.covariances["robust"] == pytest.approx(robust, rel=1e-6)
    ratio = np.sqrt(np.diag(found.covariances["robust"]) / np.diag(found.covariances["iid"]))
    assert np.all((ratio > 0.5) & (ratio < 2)), "of one size, whatever the unit of the weights"


@pytest.mark.usefixtures("added")
def test_checks_of_the_loop_say_that_the_method_simulates_none(
    emps2015: GeneratedAxis, twin: Record
) -> None:
    verdict = {c.name: c for c in identify(emps2015, twin, Prefilter(), NAME).verdict}
    for name in ("simulation", "filter bias"):
        assert verdict[name].status == "not evaluated"
        assert verdict[name].meaning == "the method simulates no loop"


def test_no_method_is_known_but_those_of_the_table(emps2015: GeneratedAxis, twin: Record) -> None:
    with pytest.raises(UsageError, match="there is no method 'idm-wls'"):
        identify(emps2015, twin, methods=[NAME])
    assert list(METHODS) == [method.name for method in METHODS.values()]


def test_the_command_line_knows_the_methods_of_the_table(root: Path) -> None:
    assert (*inputs.METHODS,) == (*METHODS,)
    assert "options/inputs.py" in (root / "CONTRIBUTING.md").read_text(encoding="utf-8")
