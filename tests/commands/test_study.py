"""``axisid study``."""

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from axisid.commands import study as command
from tests.estimation.monte_carlo.short import MOVES

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Twins move along a short way."""
    module = sys.modules["axisid.estimation.monte_carlo.monte_carlo"]
    whole = module.twin_of
    monkeypatch.setattr(module, "twin_of", lambda axis, truth, _: whole(axis, truth, MOVES))


@pytest.mark.slow
@pytest.mark.usefixtures("short")
def test_figures_are_printed_and_everything_is_written(run: Run, tmp_path: Path) -> None:
    files = {name: str(tmp_path / name) for name in ("runs.npz", "study.json", "page.html")}
    arguments = ["study", "emps2015", "--runs", "10", "--method", "idm-ls", "--truth", "M=90"]
    arguments += ["--control-noise", "0.01", "--output", files["runs.npz"]]
    arguments += ["--json", files["study.json"], "--report", files["page.html"]]
    arguments += ["--figures", str(tmp_path / "figures")]
    code, out, _ = run(*arguments)
    assert code == 0
    assert "IDM-LS" in out
    assert "0.01 V of noise of the recorded control, white" in out
    document = json.loads(Path(files["study.json"]).read_text(encoding="utf-8"))
    assert document["estimands"][0]["truth"] == 90.0
    with np.load(files["runs.npz"]) as arrays:
        assert len(arrays["run"]) == 10
    assert len([*(tmp_path / "figures").iterdir()]) == 3
    code, out, _ = run(*arguments[:-2])
    assert code == 0  # over its own files
    Path(files["runs.npz"]).write_text("mine")
    code, _, err = run(*arguments)
    assert code == 2
    assert "--force" in err


@pytest.mark.usefixtures("short")
def test_numbers_are_written_though_nobody_reads_what_is_printed(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def gone(*_: Any) -> None:
        raise BrokenPipeError

    monkeypatch.setattr(command, "put_result", gone)
    file = tmp_path / "runs.npz"
    arguments = ["--method", "idm-ls", "--loss", "huber", "--output", str(file)]
    run("study", "emps2015", "--runs", "1", *arguments)
    with np.load(file) as arrays:
        settings = json.loads(str(arrays["axisid.monte_carlo"]))["settings"]
    assert settings["loss"] == "huber"


@pytest.mark.usefixtures("short")
def test_ctrl_c_ends_with_a_sentence_and_keeps_what_is_done(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Impatient(command.ProgressLine):
        def __call__(self, *_: Any) -> None:
            raise KeyboardInterrupt

    monkeypatch.setattr(command, "ProgressLine", Impatient)
    file = tmp_path / "runs.npz"
    code, out, err = run("study", "emps2015", "--runs", "40", "--output", str(file))
    assert (code, out) == (130, "")
    assert "32 of 40 runs are done and kept in" in err
    with np.load(file) as arrays:
        assert len(arrays["run"]) == 32


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--truth", "M"], "NAME=VALUE"),
        (["--truth", "mass=3"], "the parameters are M, Fv, Fc"),
        (["--correlation-time", "0.1"], "--control-noise"),
        (["--position-noise", "-1"], "0 or more"),
        (["--output", "runs.csv"], ".npz or .parquet"),
        (["--method", "fit:control", "--loss", "huber"], "--loss is of identify"),
    ],
)
def test_what_makes_no_sense_is_refused(run: Run, arguments: list[str], said: str) -> None:
    code, _, err = run("study", "emps2015", *arguments)
    assert code == 2
    assert said in err
