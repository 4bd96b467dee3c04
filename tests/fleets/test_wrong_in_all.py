"""What is wrong with all logs of a fleet is refused once; what is wrong with some is theirs."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest
from fleet_logs import AXIS, write_logs

from axisid import DataError, EstimationError, FleetItem, ModelError, fleet
from axisid.fleets.fleet import checked
from axisid.fleets.ledger import FleetRow
from tests.refusals import refuses


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
    with refuses("fleet", says="log.csv has no axis; name one for all"):
        (tmp_path / "log.csv").write_text("time,position\n")
        fleet(tmp_path / "log.csv", out=tmp_path / "out", jobs=0)
    assert not (tmp_path / "out").exists()


def test_an_axis_before_the_logs_as_in_identify_is_told_its_place(tmp_path: Path) -> None:
    with refuses("fleet", says="--axis emps2015"):
        fleet(["emps2015", "log.csv"], out=tmp_path / "out", jobs=0)
    assert not (tmp_path / "out").exists()


def test_a_column_that_no_log_has_is_refused_once_and_nothing_is_written(tmp_path: Path) -> None:
    logs, out = write_logs(tmp_path, 2, cycles=1), tmp_path / "out"
    reading = {"columns": {"position": "nosuch"}}
    with refuses("columns", "all 2 logs fail alike.*'nosuch'"):
        fleet(logs, AXIS, out, jobs=0, reading=reading)
    assert not out.exists()
    named = FleetItem(log=str(logs[1]), columns={"position": "position"})
    made = fleet([logs[0], named], AXIS, out, jobs=0, reading=reading, methods=["idm-ls"])
    assert [row.code for row in made] == ["columns", ""]


def rows(codes: list[str], begun: list[str]) -> Iterator[tuple[FleetItem, FleetRow]]:
    for i, code in enumerate(codes):
        begun.append(code)
        status: Any = "failed" if code else "ok"
        yield (
            FleetItem(log=f"{i}"),
            FleetRow(name=f"{i}", log=f"{i}", axis="", status=status, code=code),
        )


def refusing(error: Exception) -> Any:
    def again(_: FleetItem) -> None:
        raise error

    return again


NO_COLUMN = refusing(DataError("no column.", code="columns"))


def test_many_logs_are_not_all_tried_for_what_no_log_changes() -> None:
    begun: list[str] = []
    with refuses("no-terms", "the first 20 of 1000 logs"):
        wrong = refusing(ModelError("no terms.", code="no-terms"))
        list(checked(rows(["no-terms"] * 1000, begun), 1000, wrong))
    assert len(begun) == 20


def test_only_all_logs_tell_that_a_column_is_in_none() -> None:
    with refuses("columns", "all 50 logs"):
        list(checked(rows(["columns"] * 50, []), 50, NO_COLUMN))
    codes = ["columns"] * 40 + ["", "columns"]
    assert [row.code for row in checked(rows(codes, []), len(codes), NO_COLUMN)] == codes


def test_logs_that_lack_other_columns_are_rows() -> None:
    told = [
        msgspec.structs.replace(row, reason=f"{row.log} has no {name}.")
        for name, (_, row) in zip("ab", rows(["columns"] * 2, []), strict=True)
    ]
    items = [FleetItem(log=row.log) for row in told]
    found = checked(zip(items, told, strict=True), 2, NO_COLUMN)
    assert len(list(found)) == 2


@pytest.mark.parametrize(
    "codes",
    [
        ["columns"] * 19 + [""] + ["columns"] * 30,
        ["columns"] * 3 + ["empty"],
        ["internal"] * 3,
        [""] * 3,
    ],
)
def test_logs_that_do_not_fail_alike_are_rows(codes: list[str]) -> None:
    found = checked(rows(codes, []), len(codes), NO_COLUMN)
    assert [row.code for row in found] == codes


@pytest.mark.parametrize(
    "error", [DataError("cut off.", code="cut-off"), EstimationError("none.", code="none")]
)
def test_logs_that_are_bad_alike_are_rows(error: Exception) -> None:
    assert len(list(checked(rows(["bad"] * 3, []), 3, refusing(error)))) == 3
