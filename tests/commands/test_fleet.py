"""`axisid fleet` and `axisid trend`: many logs are identified, and their results followed."""

import json
from pathlib import Path
from typing import Any

import pytest
from fleet_logs import AXIS, write_logs

from axisid.commands import fleet as command
from tests.command_line import Refused, Run


@pytest.mark.slow
def test_a_fleet_is_identified_resumed_and_followed(run: Run, tmp_path: Path) -> None:
    write_logs(tmp_path, 2, cycles=1)
    (tmp_path / "bad.npz").write_bytes(b"no archive")
    words = ("fleet", str(tmp_path / "*.npz"), "--axis", AXIS, "--output", str(tmp_path / "out"))
    method = ("--method", "idm-ls", "--jobs", "1")
    code, out, err = run(*words, *method)
    assert code == 6
    assert "2 identified, 1 without a result" in out
    assert err == "axisid: 1 of 3 logs has no result. The reasons are above and in fleet.jsonl.\n"
    assert "2 kept from an earlier run, 1 without a result" in run(*words, *method, "--resume")[1]
    code, out, err = run("trend", str(tmp_path / "out"), "--json", "-")
    assert (code, err) == (0, "")
    assert json.loads(out)["series"][0]["results"] == ["axis00000", "axis00001"]


def test_options_without_effect_and_foreign_files_are_refused(
    refused: Refused, tmp_path: Path
) -> None:
    log = tmp_path / "a.csv"
    log.write_text("time,position\n")
    refused("fleet", log, "--method=idm-ls", "--method=all", says="--method all cannot be combined")
    (tmp_path / "a.json").write_text("{}")
    foreign = "this command did not write it"
    refused("fleet", log, "--axis", AXIS, "--output", tmp_path, says=foreign)
    refused("fleet", tmp_path / "*.mat")
    refused("trend", log, "--csv", "t.txt")
    refused("trend", log, code=3)


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize("begun", [False, True])
def test_ctrl_c_tells_how_a_fleet_goes_on(
    run: Run, monkeypatch: pytest.MonkeyPatch, begun: bool
) -> None:
    def interrupted(*_: Any, **__: Any) -> None:
        if begun:
            Path("results").mkdir()
        raise KeyboardInterrupt

    Path("a.csv").write_text("time,position\n")
    monkeypatch.setattr(command.stages, "fleet", interrupted)
    code, _, err = run("fleet", "a.csv", "--axis", AXIS)
    assert code == 130
    assert ("results of the finished logs are in results. Run" in err) is begun
