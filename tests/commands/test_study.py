"""`axisid study`: many twins are identified, and the figures written."""

import json
import sys
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from axisid.commands import study as command
from axisid.support.errors import UsageError
from tests.command_line import Refused, Run
from tests.estimation.monte_carlo.short import MOVES


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
    says = f"32 of 40 runs were finished and are kept in {file}"
    refused("study", "emps2015", "--runs", "40", "--output", str(file), says=says, code=130)
    with np.load(file) as arrays:
        assert len(arrays["run"]) == 32


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--truth", "M"], "NAME=VALUE"),
        (["--truth", "mass=3"], "declared parameters: M, Fv, Fc"),
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
