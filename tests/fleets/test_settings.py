"""What the result of a log depends on."""

from pathlib import Path
from typing import Any

import pytest

from axisid import FleetItem, fleet
from axisid.fleets.settings import Settings
from tests.refusals import refuses

AXIS = (
    "from dataclasses import replace\nfrom axisid import load_axis\naxis = load_axis('emps2015')\n"
)


def test_an_axis_file_that_changes_while_the_process_lives_is_read_anew(tmp_path: Path) -> None:
    file, item = tmp_path / "own.py", FleetItem(log="a.csv")
    settings = Settings(folder=str(tmp_path), axis=str(file), native=False)
    file.write_text(AXIS)
    before = settings.key(item, "")
    file.write_text(f"{AXIS}axis = replace(axis, name='other')\n")
    assert settings.generated(item).axis.name == "other"
    assert settings.key(item, "") != before


def test_whether_compiled_code_runs_is_an_option_too(tmp_path: Path) -> None:
    item = FleetItem(log="a.csv", axis="emps2015")
    keys = {Settings(folder="", native=native).key(item, "") for native in (False, True)}
    assert len(keys) == 2


@pytest.mark.parametrize(
    ("given", "code"),
    [
        ({"logs": 3}, "fleet-logs"),
        ({"out": None}, "fleet-folder"),
        ({"fixed": 3}, "fleet-setting"),
    ],
)
def test_what_is_of_no_kind_that_it_can_be_is_refused_before_any_log(
    tmp_path: Path, given: dict[str, Any], code: str
) -> None:
    with refuses(code):
        fleet(**{"logs": ["a.csv"], "axis": "emps2015", "out": tmp_path / "out", **given})
    assert not [*tmp_path.iterdir()]
