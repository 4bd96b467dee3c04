"""A small seeded version of the study of drives, and its contract."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

PROGRAM = [sys.executable, "benchmarks/drives.py", "--json", "-", "--runs", "4"]


@pytest.mark.parametrize("name", ["dead band", "all"])
def test_declared_drives_are_identified_and_a_dead_band_untold_is_named(
    root: Path, name: str
) -> None:
    command = [*PROGRAM, "--only", name]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True, check=True)
    figures = json.loads(done.stdout)[name]
    assert min(figures["held_percent"].values()) >= 75
    assert figures["failing_percent"] == {}
    assert figures["untold_failing_percent"]["missing terms"] == 100
