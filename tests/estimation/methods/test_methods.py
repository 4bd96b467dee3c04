"""Methods as rows of a table, the pace of iterations, and rows that count for less."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import numpy as np
import pytest
import statsmodels.api as sm

from axisid import (
    Prefilter,
    Record,
    build,
    load_axis,
    twin_record,
)
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation import choices
from axisid.estimation.identification import Identification
from axisid.estimation.methods import METHODS
from axisid.estimation.methods.instrumental import StepControl
from axisid.estimation.methods.least_squares import robust_solution
from axisid.estimation.regression import Hac, Robust, Solution, factor
from axisid.estimation.thresholds import CONVERGED
from axisid.support.arrays import Array
from tests.recipes import commands_with, row_of_recipe
from tests.unjudged import identify

NAME, RECIPE = "idm-wls", "Add a method of estimation"
MODULE = "axisid.estimation.methods.weighted"


@pytest.fixture
def added(monkeypatch: pytest.MonkeyPatch) -> None:
    row = row_of_recipe(RECIPE, MODULE, monkeypatch)
    monkeypatch.setattr(choices, "METHOD_ROWS", (*choices.METHOD_ROWS, row))
    made = resolve_name(row.method)(name=row.name, form=resolve_name(row.form))
    monkeypatch.setitem(METHODS, NAME, made)


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


@pytest.mark.parametrize("slope", [-0.1, -0.3])
def test_steps_are_whole_where_deviations_shrink_with_them(slope: float) -> None:
    """Without noise the deviation is of the distance from the solution at 1."""
    pace, at = StepControl(), np.array([5.0])
    for _ in range(9):
        goal = 1.0 + slope * (at - 1.0)
        pace.step(at, goal, 1e-3 * np.abs(goal - at))
        at = at + pace.share * (goal - at)
    assert at == pytest.approx(1.0, abs=4 * 0.3**9)


def test_steps_that_fall_steadily_are_known_where_they_lead_to() -> None:
    pace, at, unit = StepControl(), np.array([1.0 + 4.0, 2.0 - 0.4]), np.array([1.0, 0.1])
    for _ in range(2):
        goal = np.array([1.0, 2.0]) + 0.1 * (at - [1.0, 2.0])
        size, further = pace.step(at, goal, unit)
        at = goal
    assert size == pytest.approx(0.36)
    assert further == pytest.approx([1.0, 2.0], abs=1e-12)


LOSSES = ("huber", "bisquare")


def _contaminated(loss: str, seed: int = 3) -> tuple[Array, Array, Solution]:
    """A regression of which a tenth of the rows has forty times the noise, to one side; solved."""
    rng = np.random.default_rng(seed)
    X = rng.normal(size=(400, 3)) * [1.0, 10.0, 1e-3]
    y = X @ [2.0, -0.3, 500.0] + rng.normal(scale=0.1, size=400)
    y[::10] += np.abs(rng.normal(scale=4.0, size=40))
    columns = factor(X, ("a", "b", "c"))
    return y, X, robust_solution(y, columns, columns, loss)


@pytest.mark.parametrize("loss", LOSSES)
def test_estimate_is_that_of_another_program(loss: str) -> None:
    y, X, found = _contaminated(loss)
    norm = sm.robust.norms.HuberT(1.345) if loss == "huber" else sm.robust.norms.TukeyBiweight()
    other: Any = sm.RLM(y, X / np.linalg.norm(X, axis=0), M=norm)
    oracle = other.fit(tol=1e-14, maxiter=500)
    assert found.theta * np.linalg.norm(X, axis=0) == pytest.approx(oracle.params, rel=1e-7)
    assert found.counts.weights == pytest.approx(oracle.weights, abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("loss", LOSSES)
def test_intervals_of_contaminated_rows_hold_the_truth(loss: str) -> None:
    held, truth = np.zeros((2, 3)), np.array([2.0, -0.3, 500.0])
    for seed in range(200):
        *_, found = _contaminated(loss, seed)
        for place, model in enumerate((Robust(), Hac())):
            away = 1.96 * np.sqrt(np.diag(model.matrix(found)))
            held[place] += np.abs(found.theta - truth) < away
    assert np.all((held >= 0.91 * 200) & (held <= 0.99 * 200))


@pytest.mark.parametrize("loss", LOSSES)
def test_the_estimate_follows_the_size_of_its_left_side(loss: str) -> None:
    # Estimates by a loss are as large as what they explain, so that the slope is the estimate, but
    # for what the median of the residuals does.
    y, _, found = _contaminated(loss)
    assert found.response.T @ y == pytest.approx(found.theta, rel=0.02)


@cache
def _axis() -> GeneratedAxis:
    return build(load_axis("emps2015"))


@cache
def _shocked() -> Record:
    """The paper's twin, whose force has a few shocks."""
    record = twin_record(_axis(), position_noise=1e-7)
    force = _axis().axis.drive.gain * np.asarray(record.control)
    for place in range(900, len(force) - 100, 1700):
        force[place : place + 40] += 60.0
    return replace(record, control=None, force=force)


_HELD = Prefilter(hold="zoh")  # the force of a drive that holds its control


@cache
def _identified(loss: str) -> Identification:
    return identify(_axis(), _shocked(), _HELD, ["idm-ls"], loss=loss)


@pytest.mark.parametrize(
    ("loss", "method"),
    [("huber", "idm-ls"), ("bisquare", "idm-ls"), ("bisquare", "idm-iv"), ("bisquare", "didim")],
)
def test_shocks_lead_least_squares_and_the_loss_does_without(loss: str, method: str) -> None:
    truth = np.array([*_shocked().provenance.truth.values()])
    by_squares = np.abs(_identified("squares").preferred.physical / truth - 1)
    found = identify(_axis(), _shocked(), _HELD, [method], loss=loss)
    robust = found[method]
    assert np.all(np.abs(robust.corrected / truth - 1) < 0.1 * by_squares)
    assert 0 < robust.light_rows.mean() < 0.2
    assert {c.name: c.status for c in found.verdict}["outliers"] != "fail"


@pytest.mark.slow
def test_what_counts_for_little_is_told_and_written() -> None:
    result = _identified("huber")
    written, light = result.to_dict()["estimates"][0], int(result.preferred.light_rows.sum())
    assert (written["loss"], written["light_rows"]) == ("huber", light)
    assert f"{light} of {len(result.preferred.y)} rows" in result.summary()
    assert "loss" not in _identified("squares").to_dict()["estimates"][0]
