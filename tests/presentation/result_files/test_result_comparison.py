"""Two results side by side: differences, settings, verdicts, and files that are no results."""

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from axisid import (
    Prefilter,
    Record,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.presentation.result_files.result_comparison import WrittenAlone, compare_results
from tests.command_line import Run
from tests.files import text_file
from tests.refusals import refuses
from tests.unjudged import identify


@pytest.fixture(scope="module")
def files(
    tmp_path_factory: pytest.TempPathFactory, emps2015: GeneratedAxis, twin: Record
) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("results")
    a = identify(emps2015, twin, Prefilter(cutoff=60.0, hold="raw", reversals="keep"))
    slow = Prefilter(cutoff=30.0, decimate=20, reversals="keep")
    b = identify(emps2015, twin, slow, ["idm-ls", "idm-iv"], level=0.02)
    one, other = (json.dumps(each.to_dict()) for each in (a, b))
    return text_file(folder / "a.json", one), text_file(folder / "b.json", other)


def _mass(content: dict[str, Any]) -> dict[str, Any]:
    return dict.__getitem__(content, "estimates")[0]["parameters"]["M"]  # type: ignore[no-any-return]


def spoiled(file: Path, folder: Path, change: Callable[[dict[str, Any]], object]) -> Path:
    content = json.loads(file.read_text())
    change(content)
    target = folder / "spoiled.json"
    target.write_text(json.dumps(content))
    return target


@pytest.mark.slow
def test_differences_are_in_combined_deviations(files: tuple[Path, Path]) -> None:
    a, b = (json.loads(f.read_text()) for f in files)
    result = compare_results(*files)
    assert [d.method for d in result.differences] == ["idm-ls"] * 3 + ["idm-iv"] * 3
    assert [d.name for d in result.differences[:3]] == ["M", "Fv", "Fc"]
    first, second = (each["estimates"][0]["parameters"]["Fv"] for each in (a, b))
    found = result.differences[1]
    assert found.difference == second["value"] - first["value"]
    assert found.deviations == pytest.approx(
        found.difference / math.sqrt(first["sd_hac"] ** 2 + second["sd_hac"] ** 2)
    )


@pytest.mark.slow
def test_settings_verdicts_and_methods_that_differ_are_told(files: tuple[Path, Path]) -> None:
    result = compare_results(*files)
    assert set(result.settings) == {"cutoff", "decimate", "drop", "hold", "level"}
    assert result.settings["cutoff"] == (60.0, 30.0)
    assert result.alone == WrittenAlone(first=("ddm-ls", "ddm-iv", "didim"), second=())
    statuses = [
        {c["name"]: c["status"] for c in json.loads(f.read_text())["verdict"]} for f in files
    ]
    assert set(result.checks) == {n for n in statuses[0] if statuses[0][n] != statuses[1].get(n)}


@pytest.mark.slow
def test_another_unit_is_not_compared_and_exact_estimates_have_no_deviations(
    files: tuple[Path, Path], tmp_path: Path
) -> None:
    def exact(content: dict[str, Any]) -> None:
        content["estimates"][0]["covariance_hac"] = [[0.0] * 3] * 3
        _mass(content).update(sd_hac=0.0)

    rescaled = spoiled(files[0], tmp_path, lambda content: _mass(content).update(unit="kg m"))
    result = compare_results(files[0], rescaled)
    assert result.alone == WrittenAlone(first=("idm-ls M [kg]",), second=("idm-ls M [kg m]",))
    file = spoiled(files[0], tmp_path, exact)
    result = compare_results(file, file)
    assert result.differences[0].deviations is None
    assert "the settings are the same" in result.summary()


def test_command_prints_or_writes_what_its_schema_says(
    run: Run, files: tuple[Path, Path], tmp_path: Path, root: Path
) -> None:
    code, out, err = run("compare-results", *files)
    assert (code, err) == (0, "")
    assert "in sd [1]" in out
    schema = json.loads((root / "docs" / "schema" / "results-1.json").read_text(encoding="utf-8"))
    code, out, err = run("compare-results", *files, "--json", "-")
    assert (code, err) == (0, "")
    written = json.loads(out)
    Draft202012Validator(schema).validate(written)
    assert written["schema"] == "axisid.result_comparison/1"
    target = tmp_path / "c.json"
    assert run("compare-results", *files, "--json", target)[0] == 0
    assert json.loads(target.read_text()) == written
    assert run("compare-results", *files, "--json", files[0])[0] == 2


@pytest.mark.parametrize(
    ("value", "says"),
    [
        (True, "expected float, got bool"),
        ("1", "expected float, got str"),
        (10**400, "number out of range"),
    ],
    ids=["true", "1", "huge"],
)
def test_what_is_no_number_is_not_compared(
    files: tuple[Path, Path], tmp_path: Path, value: Any, says: str
) -> None:
    file = spoiled(files[0], tmp_path, lambda content: _mass(content).update(value=value))
    with refuses("result-file", says):
        compare_results(files[0], file)
