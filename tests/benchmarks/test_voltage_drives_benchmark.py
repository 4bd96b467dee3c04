"""A small seeded version of the study of drives on a voltage and behind a gear."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

PROGRAM = [sys.executable, "benchmarks/voltage_drives.py", "--json", "-", "--runs", "1"]


@pytest.mark.parametrize("case", ["voltage, ke", "half the period", "gear of 70 %", "supply"])
def test_parameters_of_an_integrators_record_are_inside_their_intervals(
    root: Path, case: str
) -> None:
    done = subprocess.run(
        [*PROGRAM, "--only", case], cwd=root, capture_output=True, text=True, check=True
    )
    figures = json.loads(done.stdout)
    assert figures.pop("runs") == 1
    for name, found in figures.items():
        known = "rotor" not in name  # the loss of what turns the rotor is not declared
        assert (found["inside"] == 1.0) == known, name
        assert found["loop, relative"] < (2e-6 if known else 1e-3)
