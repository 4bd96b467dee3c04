"""Methods as rows of a table, and how fast they are."""

import json
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import statsmodels.api as sm

from axisid import Prefilter, Record, identify
from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation import choices
from axisid.estimation.methods import METHODS
from axisid.estimation.methods.instrumental import StepControl
from axisid.estimation.methods.methods import method_of
from axisid.estimation.thresholds import CONVERGED
from tests.recipes import commands_with, recipe_blocks

NAME, RECIPE = "idm-wls", "Add a method of estimation"
MODULE = "axisid.estimation.methods.weighted"


@pytest.fixture
def added(monkeypatch: pytest.MonkeyPatch) -> None:
    text, written = recipe_blocks(RECIPE)
    module = ModuleType(MODULE)
    module.__package__ = MODULE.rpartition(".")[0]
    exec(text, vars(module))
    monkeypatch.setitem(sys.modules, MODULE, module)
    row = eval(written, dict(vars(choices)))  # noqa: S307
    monkeypatch.setattr(choices, "METHOD_ROWS", (*choices.METHOD_ROWS, row))
    monkeypatch.setitem(METHODS, NAME, method_of(row))


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


@pytest.mark.slow
def test_one_file_and_one_row_add_a_method_to_the_command(tmp_path: Path) -> None:
    done = commands_with(
        tmp_path,
        RECIPE,
        f"identify emps2015 --method {NAME} --json result.json --report report.html",
        f"export result.json --axis emps2015 --to csv --method {NAME} -o out.csv",
        "identify --help",
        "export --help",
        module=MODULE,
        table="axisid.estimation.choices",
        rows="METHOD_ROWS",
    )
    assert done.returncode == 0, done.stderr
    (estimate,) = json.loads((tmp_path / "result.json").read_text())["estimates"]
    assert estimate["method"] == NAME
    assert "IDM-WLS" in (tmp_path / "report.html").read_text()
    assert f"emps2015,{NAME},M," in (tmp_path / "out.csv").read_text()
    help_pages = "".join(done.stdout.split())
    assert "[all|idm-ls|ddm-ls|idm-iv|ddm-iv|didim|idm-wls]" in help_pages
    assert "[idm-ls|ddm-ls|idm-iv|ddm-iv|didim|idm-wls]" in help_pages


@pytest.mark.parametrize("unit", [1.0, 1e-6, 1e6])
@pytest.mark.parametrize("slope", [-0.9, -1.0, -1.5, -2.5])
def test_pace_comes_to_rest_where_whole_steps_swing(slope: float, unit: float) -> None:
    """The next estimate is a line through the fixed point at 1, in any unit."""
    pace, at = StepControl(), np.array([5.0 * unit])
    for _ in range(20):
        goal = unit + slope * (at - unit)
        if pace.step(at, goal, np.array([unit]))[0] <= CONVERGED.value:
            break
        at = at + pace.share * (goal - at)
    assert at / unit == pytest.approx(1.0, abs=2 * CONVERGED.value)


def test_steps_that_fall_steadily_are_known_where_they_lead_to() -> None:
    pace, at, unit = StepControl(), np.array([1.0 + 4.0, 2.0 - 0.4]), np.array([1.0, 0.1])
    for _ in range(2):
        goal = np.array([1.0, 2.0]) + 0.1 * (at - [1.0, 2.0])
        size, further = pace.step(at, goal, unit)
        at = goal
    assert size == pytest.approx(0.36)
    assert further == pytest.approx([1.0, 2.0], abs=1e-12)
