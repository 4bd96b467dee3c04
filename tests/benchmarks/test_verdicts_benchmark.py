"""The study of verdicts in small: right machines hold, wrong ones are named, all is counted."""

import json
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

study: Any = import_module("verdicts")


@pytest.mark.slow
@pytest.mark.parametrize("by", ["identify", "control"])
@pytest.mark.parametrize("name", ["PD, 2 s", "P-PI, 5 ms, 1 um, dwells"])
def test_a_right_machine_passes_and_holds(name: str, by: str) -> None:
    found = study.right_figures(study.runs_of(name, runs=3, seed=1, by=(by,))[by])
    assert (found["fail"], found["not"]) == (0, 0)
    assert found["hold"] > 75


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fault", "by"),
    [
        ("quadratic", "identify"),
        ("offset", "identify"),
        ("offset", "control"),
        ("cogging", "identify"),
    ],
)
def test_what_is_wrong_is_named(fault: str, by: str) -> None:
    named = study.cases(1)[f"{fault}; stage"].named
    found = study.wrong_figures(
        study.runs_of(f"{fault}; stage", runs=3, seed=1, by=(by,))[by], named
    )
    assert (found["runs"], found["noticed"], found["named"]) == (1, 1, 1)


def test_silence_is_counted_where_nothing_fails_and_a_value_is_far_off() -> None:
    def run(failing: list[str], error: float) -> Any:
        return study.Run(belief="", failing=failing, said="an offset", errors={"M": error}, held={})

    runs = [run([], 9.0), run([], 1.0), run(["missing terms"], 9.0)]
    found = study.wrong_figures(runs, "offset")
    assert (found["noticed"], found["named"], found["silent"], found["refused"]) == (1, 1, 1, 0)


def test_coverage_and_bias_are_of_all_runs_of_right_machines() -> None:
    def run(error: float, held: bool) -> Any:
        return study.Run(belief="", failing=[], said="", errors={"M": error}, held={"M": held})

    found = study.right_figures([run(3.0, False), run(-1.0, True)])
    assert (found["hold"], found["bias"], found["fail"]) == (50.0, 1.0, 0)


@pytest.mark.slow
def test_the_tables_are_printed_and_written(root: Path) -> None:
    command = [sys.executable, "benchmarks/verdicts.py", "--only", "PD, 2 s", "--runs", "1"]

    def done(*options: str) -> str:
        full = [*command, "--by", "control", *options]
        return subprocess.run(full, cwd=root, capture_output=True, text=True, check=True).stdout

    assert "right machines" in done()
    (runs,) = json.loads(done("--json", "-")).values()
    assert set(runs["control"][0]) >= {"belief", "failing", "errors", "held"}
