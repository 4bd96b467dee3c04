"""The benchmark of the stages keeps its contract. It is not a timed test."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from axisid.codegen.native.compiler import find_compiler
from axisid.codegen.native.errors import NativeUnavailableError

pytestmark = pytest.mark.slow

STAGES = ["derive", "lower and print", "build for the virtual machine", "compile", "load", "total"]


def test_every_stage_of_an_axis_is_timed_and_the_largest_axis_named(root: Path) -> None:
    try:
        find_compiler()
    except NativeUnavailableError as error:
        pytest.skip(str(error))
    done = subprocess.run(
        [sys.executable, "benchmarks/generation.py", "--json", "-", "--axes", "emps"],
        cwd=root,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    figures = json.loads(done.stdout)
    assert set(figures) == {"axes", "largest"}
    assert figures["largest"] == "emps"
    assert list(figures["axes"]) == ["emps"]
    times = figures["axes"]["emps"]
    assert list(times) == STAGES
    assert all(seconds > 0 for seconds in times.values())
    assert times["total"] == pytest.approx(sum(times[stage] for stage in STAGES[:-1]))
