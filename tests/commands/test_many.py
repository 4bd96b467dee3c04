"""The commands of many logs, of many results and of many twins."""

import json
import sys
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fleet_logs import AXIS, write_logs

from axisid.commands import simulation_commands as command
from axisid.support.errors import UsageError
from tests.command_line import Refused, Run
from tests.estimation.monte_carlo.short import MOVES


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
    assert "2 kept from before, 1 without a result" in run(*words, *method, "--resume")[1]
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


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Twins move along a short way."""
    module = sys.modules["axisid.estimation.monte_carlo.monte_carlo"]
    whole = module.twin_of
    monkeypatch.setattr(module, "twin_of", lambda axis, truth, _: whole(axis, truth, MOVES))


@pytest.mark.slow
@pytest.mark.usefixtures("short")
def test_figures_are_printed_and_everything_is_written(
    run: Run, refused: Refused, tmp_path: Path
) -> None:
    files = {name: str(tmp_path / name) for name in ("runs.npz", "study.json", "page.html")}
    arguments = ["study", "emps2015", "--runs", "10", "--method", "idm-ls", "--truth", "M=90"]
    arguments += ["--control-noise", "0.01", "--output", files["runs.npz"]]
    arguments += ["--json", files["study.json"], "--report", files["page.html"]]
    arguments += ["--figures", str(tmp_path / "figures")]
    code, out, _ = run(*arguments)
    assert code == 0
    assert "IDM-LS" in out
    assert "noise of the recorded control 0.01 V (white)" in out
    document = json.loads(Path(files["study.json"]).read_text(encoding="utf-8"))
    assert document["estimands"][0]["truth"] == 90.0
    with np.load(files["runs.npz"]) as arrays:
        assert len(arrays["run"]) == 10
    assert len([*(tmp_path / "figures").iterdir()]) == 3
    code, out, _ = run(*arguments[:-2])
    assert code == 0  # over its own files
    Path(files["runs.npz"]).write_text("mine")
    refused(*arguments, says="--force")


@pytest.mark.usefixtures("short")
def test_numbers_are_written_though_nobody_reads_what_is_printed(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def gone(*_: Any) -> None:
        raise BrokenPipeError

    monkeypatch.setattr("axisid.commands.options.outputs.print_result", gone)
    file = tmp_path / "runs.npz"
    arguments = ["--method", "idm-ls", "--loss", "huber", "--output", str(file)]
    run("study", "emps2015", "--runs", "1", *arguments)
    with np.load(file) as arrays:
        settings = json.loads(str(arrays["axisid.monte_carlo"]))["settings"]
    assert settings["loss"] == "huber"


def full(*_: Any) -> None:
    raise UsageError("no space is left.", code="output")


@pytest.mark.slow
@pytest.mark.usefixtures("short")
def test_all_else_is_put_out_though_the_numbers_cannot_be_written(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(command.stages, "write_runs", full)
    files = {name: tmp_path / name for name in ("runs.npz", "study.json", "page.html")}
    arguments = ["--method", "idm-ls", "--output", files["runs.npz"], "--json", files["study.json"]]
    code, out, err = run(
        "study", "emps2015", "--runs", "1", *arguments, "--report", files["page.html"]
    )
    assert (code, err) == (2, "axisid: no space is left.\n")
    assert "IDM-LS" in out
    assert out.endswith(f"wrote {files['page.html']}\n")
    assert json.loads(files["study.json"].read_text())["schema"] == "axisid.monte_carlo/1"


@pytest.mark.slow
@pytest.mark.usefixtures("short")
def test_ctrl_c_ends_with_a_sentence_and_keeps_what_is_done(
    refused: Refused, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(command, "progress_line", lambda _: nullcontext(interrupted))
    file = tmp_path / "runs.npz"
    says = "32 of 40 runs are done and kept in"
    refused("study", "emps2015", "--runs", "40", "--output", str(file), says=says, code=130)
    with np.load(file) as arrays:
        assert len(arrays["run"]) == 32


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
    assert err.startswith("axisid: finished logs are in results; continue with --resume\n") is begun


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--truth", "M"], "NAME=VALUE"),
        (["--truth", "mass=3"], "The parameters are M, Fv, Fc"),
        (["--correlation-time", "0.1"], "--control-noise"),
        (["--position-noise", "-1"], "0 or more"),
        (["--output", "runs.csv"], ".npz or .parquet"),
        (["--method", "fit:control", "--loss", "huber"], "--loss has no effect on"),
    ],
)
def test_studies_that_make_no_sense_are_refused(
    refused: Refused, arguments: list[str], said: str
) -> None:
    refused("study", "emps2015", *arguments, says=said)


SHORT = ("--speed", "0.05", "--speed", "0.1", "--acceleration", "0.75", "--seconds", "0.3")


@pytest.mark.slow
@pytest.mark.usefixtures("here")
def test_a_log_is_identified_as_the_command_says(run: Run) -> None:
    noise = ("--position-noise", "1e-8", "--velocity-noise", "1e-6", "--truth", "M=90")
    code, out, _ = run("twin", "emps2015", "--output", "twin.csv", *SHORT, *noise)
    assert code == 0
    wrote, true, following = out.splitlines()
    assert wrote == "wrote twin.csv"
    assert true == "true: M = 90 kg, Fv = 236.9 N/(m/s), Fc = 24.8 N"
    words = following.removeprefix("next: axisid ").split()
    assert words == ["identify", "emps2015", "twin.csv", "--columns", "velocity=velocity"]
    code, out, _ = run(*words, "--method", "idm-ls")
    assert code == 0
    assert "velocity = velocity" in out


@pytest.mark.slow
@pytest.mark.usefixtures("here")
def test_many_logs_are_a_fleet_and_its_results_a_trend(run: Run) -> None:
    many = ("--count", "2", "--days", "2", "--scatter", "1%", "--scatter", "Fc=0.05")
    code, out, _ = run("twin", "emps2015", "--output", "logs", *SHORT, *many, "--drift", "Fv=3%")
    assert (code, out.splitlines()[0]) == (0, "wrote 4 logs and logs/manifest.csv")
    words = out.splitlines()[1].removeprefix("next: axisid ").split()
    assert words == ["fleet", "logs/manifest.csv"]
    code, out, _ = run(*words, "--method", "idm-ls", "--jobs", "1")
    assert code == 0
    assert "4 identified" in out
    code, out, _ = run("trend", "results", "--by", "date")
    assert code == 0
    assert "emps2015 0002, 2 results by IDM-LS" in out


@pytest.mark.slow
def test_only_logs_of_twins_are_written_over(run: Run, refused: Refused, tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    arguments = ("twin", "emps2015", *SHORT, "--output")
    assert [run(*arguments, file)[0] for _ in range(2)] == [0, 0]
    file.write_text("time,position\n")
    refused(*arguments, file, says="this command did not write it")
    folder = tmp_path / "logs"
    assert [run(*arguments, folder, "--count", "1")[0] for _ in range(2)] == [0, 0]
    (folder / "manifest.csv").write_text("log,axis,serial\n")
    refused(*arguments, folder, "--count", "1")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--output", "logs"], "add --count or --days"),
        (["--output", "t.csv", "--count", "2"], "omit these options"),
        (["--output", "t.csv", "--scatter", "2%"], "--scatter has no effect without --count"),
        (["--output", "logs", "--count", "2", "--drift", "M=1%"], "no effect without --days"),
        (["--output", "logs", "--count", "2", "--scatter", "M=x"], "Write NAME=SHARE"),
        (["--output", "logs", "--count", "2", "--scatter", "m=1%"], "no such parameter"),
        (["--output", "logs", "--count", "2", "--scatter", "1e9%"], "a share of the value"),
        (["--output", "t.csv", "--speed", "0.1"], "--acceleration"),
        (["--output", "t.csv", "--repeat", "2"], "no effect without --speed"),
        (["--output", "t.csv", "--dwell", "0.2"], "no effect without --speed"),
        (["--output", "t.csv", "--truth", "M"], "Write NAME=VALUE"),
    ],
)
def test_twins_that_make_no_sense_are_refused(
    refused: Refused, here: Path, arguments: list[str], said: str
) -> None:
    refused("twin", "emps2015", *arguments, says=said)
    assert not [*here.iterdir()]
