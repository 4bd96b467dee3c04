"""Files that hold what their schema allows and no result can be, by every door that reads one."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from axisid import Prefilter, Record, compare_results, export, identify, load_result
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from tests.refusals import refuses

DOORS: dict[str, Callable[[Path], object]] = {
    "load_result": load_result,
    "export": lambda file: export(file, axis="emps2015"),
    "compare_results": lambda file: compare_results(file, file),
}


@pytest.fixture(scope="module")
def written(emps2015: GeneratedAxis, twin: Record) -> str:
    result = identify(emps2015, twin, Prefilter(cutoff=60.0), ["idm-ls", "idm-iv"])
    return json.dumps(result.to_dict())


@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize(
    ("change", "said"),
    [({"judged": "ddm-iv"}, "'ddm-iv'"), ({"estimates": []}, "no summary can be made of it")],
)
def test_every_door_refuses_what_no_result_can_be(
    written: str, tmp_path: Path, change: dict[str, Any], said: str, door: str
) -> None:
    file = tmp_path / "x.json"
    file.write_text(json.dumps({**json.loads(written), **change}))
    with refuses("result-file", says=f"contradicts itself: .*{said}"):
        DOORS[door](file)


@pytest.mark.parametrize("door", DOORS)
def test_every_door_refuses_a_file_that_was_changed_after_it_was_written(
    emps2015: GeneratedAxis, twin: Record, tmp_path: Path, door: str
) -> None:
    file = tmp_path / "x.json"
    identify(emps2015, twin, methods=["idm-ls"]).save(file)
    content = json.loads(file.read_text())
    laid_out = json.dumps(content).replace("1.0,", "1,")  # in another way, which changes nothing
    file.write_text(laid_out)
    DOORS[door](file)
    content["estimates"][0]["parameters"]["M"]["sd_hac"] *= 2
    file.write_text(json.dumps(content))
    with refuses("changed-result", says="take its member digest out"):
        DOORS[door](file)
    del content["digest"]
    file.write_text(json.dumps(content))
    DOORS[door](file)
