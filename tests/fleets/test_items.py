"""Logs by name, pattern, folder and manifest.

What is wrong with all logs of a fleet is refused once; what is wrong with some is theirs.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import polars as pl
import pytest
from fleet_logs import AXIS, write_logs

from axisid import AxisidError, DataError, EstimationError, FleetItem, ModelError, UsageError, fleet
from axisid.fleets.fleet import checked
from axisid.fleets.items import gather_items, with_names
from axisid.fleets.ledger import FleetRow
from tests.refusals import refuses


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("b.csv", "a.csv", "deep/c.mat", "note.md", ".hidden.csv", "out/a.json"):
        file = tmp_path / name
        file.parent.mkdir(exist_ok=True)
        file.write_text("time,position\n0,1\n")
    return tmp_path


def names(folder: Path, *logs: str | Path) -> list[str]:
    found = gather_items(list(logs), folder / "out")
    return [Path(item.log).relative_to(folder).as_posix() for item in found]


def test_a_folder_has_its_logs_but_no_results(folder: Path) -> None:
    (folder / "earlier").mkdir()
    (folder / "earlier/a.json").write_text('{"schema": "axisid.identification/3"}')
    (folder / "earlier/fleet.csv").write_text("name,log,axis,serial,status\na,a.csv,emps,,ok\n")
    (folder / "earlier/fleet.jsonl").write_text('{"schema": "axisid.fleet/1", "name": "a"}\n')
    assert names(folder, folder) == ["a.csv", "b.csv", "deep/c.mat"]


def test_a_link_to_nothing_is_a_log_that_cannot_be_read(folder: Path) -> None:
    (folder / "gone.csv").symlink_to(folder / "unplugged" / "gone.csv")
    (folder / "ring.csv").symlink_to(folder / "ring.csv")
    (folder / "linked.csv").symlink_to(folder / "deep")
    for named in (folder, str(folder / "*.csv")):
        assert {"gone.csv", "ring.csv"} <= set(names(folder, named))
        assert "linked.csv" not in names(folder, named)


def test_a_manifest_in_a_folder_tells_of_its_logs(folder: Path) -> None:
    (folder / "manifest.csv").write_text(f"log,serial\n{folder / 'a.csv'},1\ndeep/../b.csv,17\n")
    found = [(Path(item.log).name, item.serial) for item in gather_items(folder, folder / "out")]
    assert sorted(found) == [("a.csv", "1"), ("b.csv", "17"), ("c.mat", "")]


def test_patterns_and_names_may_name_a_log_twice(folder: Path) -> None:
    assert names(folder, str(folder / "*.csv"), folder / "a.csv") == ["a.csv", "b.csv"]
    assert names(folder, folder / "missing.csv") == ["missing.csv"]  # told as its reason


@pytest.mark.parametrize("kind", ["csv", "semicolons", "parquet"])
def test_a_manifest_says_what_is_known_of_each_log(folder: Path, kind: str) -> None:
    file = folder / f"manifest.{'parquet' if kind == 'parquet' else 'csv'}"
    if kind == "parquet":
        columns = {
            "log": ["a.csv", "b.csv"],
            "axis": ["emps2015", "own.toml"],
            "serial": ["17", None],
            "columns": ["position=q:mm, time=t", None],
            "temperature": [21.5, None],
            "site": ["north", "south"],
        }
        pl.DataFrame(columns).write_parquet(file)
    else:
        text = (
            "log,axis,serial,columns,temperature,site\n"
            'a.csv,emps2015,17,"position=q:mm, time=t",21.5,north\n'
            "b.csv,own.toml,,,,south\n"
        )
        if kind == "semicolons":
            text = text.replace(",", ";").replace(
                '"position=q:mm; time=t"', "position=q:mm, time=t"
            )
        file.write_text(text)
    first, second = gather_items(file, folder / "out")
    assert first == FleetItem(
        log=str(folder / "a.csv"),
        axis="emps2015",
        serial="17",
        columns={"position": "q:mm", "time": "t"},
        conditions={"temperature": 21.5, "site": "north"},
    )
    assert (second.axis, second.conditions) == (str(folder / "own.toml"), {"site": "south"})


def test_results_of_logs_of_one_name_are_told_apart() -> None:
    items = [FleetItem(log=log) for log in ("x/a.csv", "y/A.csv", "b.csv.gz")]
    first, second, third = (item.name for item in with_names(items))
    assert (first[:2], second[:2], third) == ("a-", "A-", "b")
    assert first[2:] != second[2:]
    assert [item.name for item in with_names(items[::-1])] == [third, second, first]


def test_a_log_of_two_machines_is_two_items_with_results_of_their_own(tmp_path: Path) -> None:
    file = tmp_path / "manifest.csv"
    file.write_text('log,serial,columns\na.csv,X,"position=px"\na.csv,Y,"position=py"\n')
    items = gather_items([file, tmp_path / "a.csv"], tmp_path)  # the bare path adds nothing
    assert [(item.serial, item.columns) for item in items] == [
        ("X", {"position": "px"}),
        ("Y", {"position": "py"}),
    ]
    assert len({item.name for item in items}) == 2


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "log,serial,site\na.csv,X,1\na.csv,Y,1\n",
            "row 1, and .*row 2, give different serial of .*'X' and 'Y'",
        ),
        (
            "log,serial,site\na.csv,X,1\na.csv,X,2\n",
            "row 1, and .*row 2, give different conditions of .*site=2",
        ),
        ("log,axis\n,emps\n", "row 1 names no log"),
        ("log,site\na.csv,1,,\na.csv,1,20\n", "row 2 has more cells than the header has names"),
        ("log,log\na.csv,b.csv\n", "has 2 columns named 'log'"),
    ],
)
def test_a_manifest_that_does_not_tell_its_logs_is_refused(
    folder: Path, text: str, said: str
) -> None:
    (folder / "list.csv").write_text(text)
    with pytest.raises(DataError, match=said):
        gather_items(folder / "list.csv", folder / "out")


def test_no_log_at_all_is_refused(tmp_path: Path) -> None:
    for given, says in ((str(tmp_path), "no log was found in"), ([3], "a log is 3")):
        with pytest.raises(UsageError, match=says):
            gather_items(given, tmp_path / "out")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("how", "code"),
    [
        ({"axis": "nosuch"}, "axis-file"),
        ({"axis": None}, "log-file"),  # there are no such files
        ({"fixed": {"K": 3.0}}, "parameters"),
        ({"left_out": ["K"]}, "parameters"),
        ({"methods": ["nosuch"]}, "method"),
        ({"method": ["idm-ls"]}, "fleet"),
        ({"reading": {"column": {}}}, "fleet"),
    ],
)
def test_what_no_log_can_be_identified_with_is_refused_before_any_is_read(
    tmp_path: Path, how: dict[str, Any], code: str
) -> None:
    with refuses(code):
        fleet(["a.csv", "b.csv"], out=tmp_path / "out", jobs=0, **{"axis": AXIS, **how})
    assert not (tmp_path / "out").exists()


def test_logs_without_an_axis_are_refused_at_once(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("time,position\n")
    for logs, code, says in (
        ([tmp_path / "log.csv"], "fleet", "no axis is named for .*log.csv"),
        (["emps2015", "log.csv"], "log-file", "with --axis"),  # before the logs as in identify
    ):
        with refuses(code, says=says):
            fleet(logs, out=tmp_path / "out", jobs=0)
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_column_that_no_log_has_is_refused_once_and_nothing_is_written(tmp_path: Path) -> None:
    logs, out = write_logs(tmp_path, 2, cycles=1), tmp_path / "out"
    reading = {"columns": {"position": "nosuch"}}
    with refuses("columns", "all 2 logs fail for the same reason.*'nosuch'"):
        fleet(logs, AXIS, out, jobs=0, reading=reading)
    assert not out.exists()
    named = FleetItem(log=str(logs[1]), columns={"position": "position"})
    made = fleet([logs[0], named], AXIS, out, jobs=0, reading=reading, methods=["idm-ls"])
    assert [row.code for row in made] == ["columns", ""]


def failed(codes: list[str], begun: list[str]) -> Iterator[tuple[FleetItem, FleetRow]]:
    """Logs that fail by codes; a code that is empty is of a log that does not."""
    for i, code in enumerate(codes):
        begun.append(code)
        status: Any = "failed" if code else "ok"
        reason = f"{code} {i}.csv." if "column" in code else ""
        row = FleetRow(name=f"{i}", log=f"{i}.csv", axis="", status=status, code=code)
        yield FleetItem(log=f"{i}.csv"), msgspec.structs.replace(row, reason=reason)


NO_COLUMN, NO_TERMS = DataError("none.", code="columns"), ModelError("none.", code="no-terms")


@pytest.mark.parametrize(
    ("codes", "error", "refused", "tried"),
    [
        (["no-terms"] * 1000, NO_TERMS, "the first 20 of 1000 logs", 20),
        (["columns"] * 50, NO_COLUMN, "all 50 logs", 50),
        (["columns"] * 40 + ["", "columns"], NO_COLUMN, "", 42),
        (["columns"] * 19 + [""] + ["columns"] * 30, NO_COLUMN, "", 50),
        (["columns"] * 3 + ["empty"], NO_COLUMN, "", 4),
        (["column a", "column b"], NO_COLUMN, "", 2),
        (["internal"] * 3, NO_COLUMN, "", 3),
        ([""] * 3, NO_COLUMN, "", 3),
        (["bad"] * 3, DataError("cut off.", code="cut-off"), "", 3),
        (["bad"] * 3, EstimationError("none.", code="none"), "", 3),
    ],
)
def test_logs_that_all_fail_by_what_no_log_changes_are_refused_once(
    codes: list[str], error: AxisidError, refused: str, tried: int
) -> None:
    begun: list[str] = []

    def again(_: FleetItem) -> None:
        raise error

    found = checked(failed(codes, begun), len(codes), again)
    if refused:
        with refuses(error.code, refused):
            list(found)
    else:
        assert [row.code for row in found] == codes
    assert len(begun) == tried
