"""What is wrong with all logs of a fleet is refused once; what is wrong with some is theirs."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest
from fleet_logs import AXIS, write_logs

from axisid import AxisidError, DataError, EstimationError, FleetItem, ModelError, fleet
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
    (tmp_path / "log.csv").write_text("time,position\n")
    for logs, says in (
        ([tmp_path / "log.csv"], "log.csv has no axis; name one for all"),
        (["emps2015", "log.csv"], "--axis emps2015"),  # before the logs as in identify
    ):
        with refuses("fleet", says=says):
            fleet(logs, out=tmp_path / "out", jobs=0)
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
