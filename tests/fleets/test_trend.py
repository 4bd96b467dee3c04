"""Results over time: limits, results beyond them, steps; as text, page and table."""

import copy
import csv
import io
import json
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec import structs

from axisid import (
    DataError,
    Prefilter,
    UsageError,
    build,
    fit,
    load_axis,
    load_result,
    trend,
    twin_record,
)
from axisid.estimation.monte_carlo import twin_of
from axisid.fleets import FleetRow, Trend
from axisid.fleets.ledger import write_rows
from axisid.fleets.trend import place_of
from axisid.modeling.declaration import back_and_forth
from axisid.support.missing import Missing
from tests.refusals import refuses
from tests.unjudged import identify

SHIFTED = 14  # results from which the mass is another one
BEYOND = 5
SCATTER = 0.6  # between results


def point(**conditions: str | float | None) -> FleetRow:
    return FleetRow(name="r", log="", axis="a", status="ok", conditions=conditions)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results of a machine whose mass steps, and in one of which friction is off."""
    axis = build(load_axis("emps2015"))
    document = identify(axis, twin_record(axis), Prefilter(), ["idm-ls"]).to_dict()
    document["verdict"] = [{**check, "status": "pass"} for check in document["verdict"]]
    place, rng = tmp_path_factory.mktemp("results"), np.random.default_rng(1)
    for i in range(20):
        apart = {"M": 6.0 if i >= SHIFTED else 0.0, "Fc": 8.0 if i == BEYOND else 0.0}
        made = _moved(document, {k: v + SCATTER * rng.normal() for k, v in apart.items()})
        (place / f"r{i:02}.json").write_text(json.dumps(made))
        row = point(date=f"2026-03-{i + 1:02}", run=float(20 - i))
        named = structs.replace(row, name=f"r{i:02}", log=f"r{i:02}.csv", axis="emps2015")
        write_rows(place, [named])
    (place / "other.json").write_text("{}")  # none of the fleet's
    return place


def _moved(document: dict[str, Any], by: dict[str, float]) -> dict[str, Any]:
    made = copy.deepcopy(document)
    for name, distance in by.items():
        value = made["estimates"][0]["parameters"][name]
        value["value"] += distance
        value["interval_95"] = [end + distance for end in value["interval_95"]]
    return made


@pytest.fixture(scope="module")
def made(folder: Path) -> Trend:
    return trend(folder, by="date")


@pytest.mark.slow
def test_a_step_and_a_result_beyond_its_limits_are_told_of_their_parameters(made: Trend) -> None:
    (series,) = made.changed
    charts = {chart.parameter: chart for chart in series.charts}
    assert [step.place for step in charts["M"].steps] == [SHIFTED]
    assert charts["M"].steps[0].difference == pytest.approx(6.0, abs=1.0)
    assert set(range(SHIFTED, 20)) <= {*charts["M"].beyond}
    limits, before = charts["M"].limits, charts["M"].values[:SHIFTED]
    assert limits.centre[0] == pytest.approx(float(np.mean(before)), abs=0.3)
    assert limits.between == pytest.approx(SCATTER, rel=0.5)
    assert charts["Fc"].beyond == (BEYOND,)
    assert not charts["Fv"].steps
    assert [check.status for check in series.checks] == ["fail", "fail"]
    assert made.belief == "with care"


@pytest.mark.slow
def test_a_drift_is_told_with_its_slope_and_limits_about_its_line(
    folder: Path, tmp_path: Path
) -> None:
    files, rng = sorted(folder.glob("r*.json"))[:SHIFTED], np.random.default_rng(2)
    for i, file in enumerate(files):
        made = _moved(json.loads(file.read_text()), {"Fv": 1.0 * i + rng.normal(0.0, 0.3)})
        (tmp_path / file.name).write_text(json.dumps(made))
    found = trend(tmp_path)
    (series,) = found.changed
    (chart,) = [each for each in series.charts if each.parameter == "Fv"]
    assert chart.drift.slope == pytest.approx(1.0, abs=4 * chart.drift.deviation)
    assert not chart.steps
    assert np.allclose(np.diff(chart.limits.centre), chart.drift.slope)
    page = found.write(tmp_path / "t.html").read_text()
    assert found.write(tmp_path / "again.html").read_text() == page
    assert page.count("<img ") == 1
    assert "http" not in page.replace("http-equiv", "")
    rows = list(csv.DictReader(io.StringIO(found.write(tmp_path / "t.csv").read_text())))
    assert {row["drift"] != "" for row in rows if row["parameter"] == "Fv"} == {True}


@pytest.mark.slow
def test_a_condition_orders_the_results(folder: Path, made: Trend) -> None:
    few = [folder / "r03.json", folder / "r04.json"]
    assert [point.name for point in trend(few, by="run").series[0].points] == ["r04", "r03"]
    assert np.diff(made.series[0].places).tolist() == [1.0] * 19
    with pytest.raises(UsageError, match=r"'age' of r03 is not known\..*: date, run\."):
        trend(few, by="age")
    for place in (None, 1e308, -1e308, 1e200):  # no number, or their squares are none
        with refuses("trend"):
            place_of(point(run=place), "run")


def test_values_are_those_of_the_results(folder: Path) -> None:
    saved = load_result(folder / "r03.json")
    point = trend(saved, method="idm-ls").series[0].points[0]
    assert point.parameters["M"].value == saved.preferred.parameters["M"].corrected


def test_the_table_has_a_row_for_each_value(made: Trend, tmp_path: Path) -> None:
    rows = list(csv.DictReader(io.StringIO(made.write(tmp_path / "t.csv").read_text())))
    assert len(rows) == 20 * 3
    assert ("r05", "Fc", "1") in [(r["result"], r["parameter"], r["beyond"]) for r in rows]
    assert float(rows[0]["lower_limit"]) < float(rows[0]["value"]) < float(rows[0]["upper_limit"])


def test_few_results_tell_no_limits(folder: Path) -> None:
    found = trend([folder / "r00.json", folder / "r01.json"])
    assert all(isinstance(c.limits, Missing) for s in found.series for c in s.charts)
    assert found.changed == ()
    assert str(trend(folder / "r00.json"))


def test_values_in_several_units_are_refused_by_the_names_of_their_results(
    folder: Path, tmp_path: Path
) -> None:
    document = json.loads((folder / "r00.json").read_text())
    (tmp_path / "a.json").write_text(json.dumps(document))
    document["estimates"][0]["parameters"]["M"]["unit"] = "kg m"
    (tmp_path / "b.json").write_text(json.dumps(document))
    with pytest.raises(DataError, match="M of emps2015 has the unit 'kg' in a and 'kg m' in b"):
        trend(tmp_path)


@pytest.mark.slow
def test_other_things_are_refused(folder: Path, tmp_path: Path, made: Trend) -> None:
    for code, given, says in (
        ("trend", tmp_path, "no result was found in"),
        ("result-file", "a" * 5000, ""),  # longer than any file's name
        ("trend", [folder, folder], "is given 2 times"),
    ):
        with refuses(code, says):
            trend(given)
    with pytest.raises(UsageError, match=r"ends in \.csv, \.html, \.json"):
        made.write(tmp_path / "t.pdf")


@pytest.fixture(scope="module")
def fitted() -> dict[str, Any]:
    """A fit of a short twin."""
    moves = back_and_forth(speeds=(0.05, 0.1), acceleration=0.75, seconds=0.3)
    axis = twin_of(build(load_axis("emps2015")), {}, moves)
    return fit(axis, twin_record(axis), fixed={"Fv": 236.9}).to_dict()


@pytest.mark.slow
def test_fits_have_a_trend_of_what_they_fitted(fitted: dict[str, Any], tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    for i in range(12):
        made = copy.deepcopy(fitted)
        friction = made["parameters"]["Fc"]
        moved = 4.0 * (i >= 6) + 0.1 * rng.normal()
        friction["value"] += moved
        friction["interval_95"] = [end + moved for end in friction["interval_95"]]
        (tmp_path / f"f{i:02}.json").write_text(json.dumps(made))
    (series,) = trend(tmp_path).series
    assert [chart.parameter for chart in series.charts] == ["M", "Fc"]  # Fv is held
    assert {point.method for point in series.points} == {"fit:control"}
    assert series.points[0].parameters["M"].sd == fitted["parameters"]["M"]["sd"]
    assert [step.place for step in series.charts[1].steps] == [6]
    assert trend(tmp_path, method="fit:control").series == (series,)
    with refuses("trend"):
        trend(tmp_path, method="idm-iv")


@pytest.mark.skipif(not hasattr(time, "tzset"), reason="the zone cannot be set")
def test_a_date_stands_at_the_same_place_in_every_zone(monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patch:
        patch.setenv("TZ", "Asia/Tokyo")
        time.tzset()
        place = place_of(point(date="1970-01-02"), "date")
    time.tzset()
    assert place == 1.0


@pytest.mark.slow
def test_results_whose_verdict_fails_hide_no_drift_and_set_no_limits(
    folder: Path, tmp_path: Path
) -> None:
    document, rng = json.loads((folder / "r00.json").read_text()), np.random.default_rng(2)
    for i in range(14):
        apart = -50.0 if i == BEYOND else SCATTER * (0.5 * rng.normal() + i)
        moved = _moved(document, {"Fc": apart})
        moved["verdict"][0]["status"] = "fail" if i == BEYOND else "pass"
        (tmp_path / f"r{i:02}.json").write_text(json.dumps(moved))

    (series,) = trend(tmp_path).series
    chart = next(c for c in series.charts if c.parameter == "Fc")
    assert series.set_aside == chart.beyond == (BEYOND,)
    assert chart.drift.slope == pytest.approx(SCATTER, rel=0.2)
    assert len(chart.drift.line) == 14

    (counted,) = trend(tmp_path, count_failing=True).series
    assert next(c for c in counted.charts if c.parameter == "Fc").drift is None
    assert counted.set_aside == ()


@pytest.mark.slow
@pytest.mark.parametrize("size", [1e150, 1e308])
def test_a_value_beyond_all_sense_sets_no_limits(folder: Path, tmp_path: Path, size: float) -> None:
    files = sorted(folder.glob("r*.json"))[: SHIFTED - 1]
    huge = _moved(json.loads(files[-1].read_text()), {"M": size})
    (tmp_path / "huge.json").write_text(json.dumps(huge))
    (series,) = trend([*files, tmp_path / "huge.json"]).series
    (whole,) = trend(files).series
    chart, alone = series.charts[0], whole.charts[0]
    assert chart.limits.centre[0] == alone.limits.centre[0]
    assert chart.beyond == (len(files),)
    assert trend([*files, tmp_path / "huge.json"]).write(tmp_path / "t.html").is_file()
