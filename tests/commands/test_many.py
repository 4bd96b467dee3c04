"""The commands of many logs and of many results."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from fleet_logs import AXIS, write_logs

Run = Callable[..., tuple[int, str, str]]


@pytest.mark.slow
def test_a_fleet_is_identified_resumed_and_followed(run: Run, tmp_path: Path) -> None:
    write_logs(tmp_path, 2, cycles=1)
    (tmp_path / "bad.npz").write_bytes(b"no archive")
    words = ("fleet", str(tmp_path / "*.npz"), "--axis", AXIS, "--output", str(tmp_path / "out"))
    method = ("--method", "idm-ls", "--jobs", "1")
    code, out, err = run(*words, *method)
    assert code == 6
    assert "2 identified, 1 without a result" in out
    assert err == "axisid: 1 of 3 logs has no result; the reasons are above and in fleet.jsonl.\n"
    assert "2 done before, 1 without a result" in run(*words, *method, "--resume")[1]
    code, out, err = run("trend", str(tmp_path / "out"), "--json", "-")
    assert (code, err) == (0, "")
    assert json.loads(out)["series"][0]["results"] == ["axis00000", "axis00001"]


def test_options_without_effect_and_foreign_files_are_refused(run: Run, tmp_path: Path) -> None:
    log = tmp_path / "a.csv"
    log.write_text("time,position\n")
    code, _, err = run("fleet", str(log), "--method", "idm-ls", "--method", "all")
    assert (code, "--method all is by itself" in err) == (2, True)
    (tmp_path / "a.json").write_text("{}")
    code, _, err = run("fleet", str(log), "--axis", AXIS, "--output", str(tmp_path))
    assert (code, "this command did not write it" in err) == (2, True)
    assert run("fleet", str(tmp_path / "*.mat"))[0] == 2
    assert run("trend", str(log), "--csv", "t.txt")[0] == 2
    assert run("trend", str(log))[0] == 3
