"""What the result of a log depends on."""

from pathlib import Path

from axisid import FleetItem
from axisid.fleets.one_log import Settings

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
