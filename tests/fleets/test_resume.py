"""What a fleet remembers of what was done, and what a result depends on."""

import math
import sys
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from axisid import DataError, FleetItem, fleet
from axisid.fleets import Fleet, gather_items, read_ledger
from axisid.fleets.ledger import LEDGER, FleetRow, ledger_of, write_row
from axisid.fleets.one_log import Named, Settings, log_digest, result_file
from axisid.trends.gathering import last_results
from tests.fleets.logs import CENTRE, row_of


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Logs, of which those that are empty fail."""

    def identified(settings: Settings, named: Named) -> FleetRow:
        log = Path(named.item.log)
        if not log.read_text():
            return named.row(status="failed", reason="empty.")
        result_file(settings.folder, named.name).write_text("{}")
        key = settings.key(named.item, log_digest(log))
        return named.row(axis="emps2015", status="ok", key=key)

    monkeypatch.setattr(sys.modules[fleet.__module__], "identify_log", identified)
    for name in ("x", "y"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.csv").write_text(name)
    return tmp_path


def run(place: Path, *names: str, serial: str = "", resume: bool = True) -> Fleet:
    items = [FleetItem(log=str(place / name / "a.csv"), serial=serial) for name in names]
    return fleet(items, "emps2015", place / "out", jobs=0, native=False, resume=resume)


def test_a_result_keeps_its_name_when_another_log_of_that_name_comes(place: Path) -> None:
    assert "Fleet of 1 log\n" in str(run(place, "x"))
    grown = run(place, "x", "y")
    assert [row.status for row in grown] == ["skipped", "ok"]
    assert [row.name for row in run(place, "y", "x")] == [row.name for row in grown][::-1]
    assert len(list((place / "out").glob("*.json"))) == 2


def test_what_is_put_right_of_a_log_that_is_done_goes_into_the_ledger(place: Path) -> None:
    run(place, "x")
    assert run(place, "x", serial="17")["a"].status == "skipped"
    row = read_ledger(place / "out").rows["a"]
    assert (row.serial, row.status) == ("17", "ok")


@pytest.mark.parametrize("resume", [True, False])
def test_the_result_of_a_log_that_fails_now_is_taken_away(place: Path, resume: bool) -> None:
    run(place, "x")
    (place / "x" / "a.csv").write_text("")
    assert run(place, "x", resume=resume)["a"].status == "failed"
    assert not (place / "out" / "a.json").exists()


@pytest.mark.parametrize(
    "left", ['{"axis": "emps2015", "digest": "of other words"}', "", "{", "[]"]
)
def test_a_result_that_was_changed_or_is_broken_is_made_again(place: Path, left: str) -> None:
    run(place, "x")
    result = place / "out" / "a.json"
    result.write_text(left)
    assert [run(place, "x")["a"].status for _ in range(2)] == ["ok", "skipped"]
    assert result.read_text() == "{}"


def test_a_run_file_that_is_wrong_is_told_and_not_left_out(place: Path) -> None:
    run_file = place / "x" / "run.toml"
    run_file.write_text('log = "a.csv\n')
    assert str(run_file) in [item.log for item in gather_items(place / "x", place / "out")]


def test_a_trend_takes_the_last_row_of_each_log_and_machine() -> None:
    told = [("a", "x", "ok"), ("b", "y", "ok"), ("a-1", "x", "ok"), ("b-1", "y", "failed")]
    rows = [FleetRow(name=n, log=log, axis="s", status=s) for n, log, s in told]  # type: ignore[arg-type]
    two = [msgspec.structs.replace(rows[0], name=n, columns={"position": n}) for n in ("p", "q")]
    assert last_results([*rows, *two]) == {"a-1", "p", "q"}


def test_lines_that_are_broken_are_told_and_their_logs_made_again(place: Path) -> None:
    run(place, "x", "y")
    ledger = place / "out" / "fleet.jsonl"
    first, second = ledger.read_text().splitlines()
    ledger.write_text(f"{first}\n{second[:40]}\n")
    again = run(place, "x", "y")
    assert sorted(row.status for row in again) == ["ok", "skipped"]
    assert "1 line of" in again.notes[0]
    assert again.notes[0] in " ".join(again.summary().split())


AXIS = (
    "from dataclasses import replace\nfrom axisid import load_axis\naxis = load_axis('emps2015')\n"
)


def test_an_axis_file_that_changes_while_the_process_lives_is_read_anew(tmp_path: Path) -> None:
    file, item = tmp_path / "own.py", FleetItem(log="a.csv")
    settings = Settings(folder=str(tmp_path), axis=str(file), native=False)
    file.write_text(AXIS)
    before = settings.key(item, "")
    file.write_text(f"{AXIS}axis = replace(axis, name='other')\n")
    assert settings.built(item)[0].axis.name == "other"
    assert len({before, *(replace(settings, native=n).key(item, "") for n in (False, True))}) == 3


def test_rows_are_read_in_the_order_of_their_last_lines_finite_or_not(tmp_path: Path) -> None:
    odd = row_of("odd", np.array([np.nan, 200.0, 20.0]))
    with ledger_of(tmp_path, anew=True) as ledger:
        for row in (row_of("a", CENTRE), odd, row_of("a", CENTRE + 1.0)):
            write_row(ledger, row)
        ledger.write(b'{"schema": "axisid.fle')  # cut off
    rows = read_ledger(tmp_path).rows
    assert read_ledger(tmp_path).broken.endswith("(4)")
    assert list(rows) == ["odd", "a"]
    assert math.isnan(rows["odd"].parameters["M"].value)
    assert rows["a"].parameters["M"].value == CENTRE[0] + 1.0
    (tmp_path / LEDGER).write_text('{"schema": "axisid.fleet/1", "name": null}\n')
    with pytest.raises(DataError, match="line 1 is no row of a fleet"):
        read_ledger(tmp_path)


def test_a_ledger_goes_on_without_empty_lines_also_after_one_that_was_cut_off(
    tmp_path: Path,
) -> None:
    for content in (b"", b"{}\n", b'{"a'):
        (tmp_path / LEDGER).write_bytes(content)
        with ledger_of(tmp_path, anew=False) as ledger:
            write_row(ledger, row_of("a", CENTRE))
        lines = (tmp_path / LEDGER).read_bytes().splitlines()
        assert b"" not in lines
        assert lines[-1].startswith(b'{"schema"')
