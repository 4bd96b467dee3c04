"""A fleet that goes on: it may have grown, and its logs may have changed."""

import sys
from pathlib import Path

import pytest

from axisid import FleetItem, fleet
from axisid.fleets import Fleet, read_ledger
from axisid.fleets.ledger import FleetRow
from axisid.fleets.one_log import Named, Settings, log_digest, result_file
from axisid.trends.gathering import last_results


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


def test_a_trend_takes_the_last_row_of_each_log() -> None:
    told = [("a", "x", "ok"), ("b", "y", "ok"), ("a-1", "x", "ok"), ("b-1", "y", "failed")]
    rows = [FleetRow(name=n, log=log, axis="s", status=s) for n, log, s in told]  # type: ignore[arg-type]
    assert last_results(rows) == {"a-1"}


def test_a_trend_takes_each_machine_of_a_log_of_two() -> None:
    rows = [
        FleetRow(name=n, log="x", axis="s", columns={"position": n}, status="ok")
        for n in ("px", "py")
    ]
    assert last_results(rows) == {"px", "py"}


def test_lines_that_are_broken_are_told_and_their_logs_made_again(place: Path) -> None:
    run(place, "x", "y")
    ledger = place / "out" / "fleet.jsonl"
    first, second = ledger.read_text().splitlines()
    ledger.write_text(f"{first}\n{second[:40]}\n")
    again = run(place, "x", "y")
    assert sorted(row.status for row in again) == ["ok", "skipped"]
    assert "1 line of" in again.notes[0]
    assert again.notes[0] in " ".join(again.summary().split())


@pytest.mark.parametrize("left", ["", "{", "[]"])
def test_a_result_that_is_broken_is_made_again(place: Path, left: str) -> None:
    run(place, "x")
    (place / "out" / "a.json").write_text(left)
    assert run(place, "x")["a"].status == "ok"
    assert run(place, "x")["a"].status == "skipped"
