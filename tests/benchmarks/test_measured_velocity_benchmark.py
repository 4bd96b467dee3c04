"""A small seeded version of the study of measured velocities, and its contract."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

PROGRAM = [
    sys.executable,
    "benchmarks/measured_velocity.py",
    "--json",
    "-",
    "--runs",
    "2",
    "--alone",
    "1",
]
RIGHT = ("white noise", "ripple", "coarse steps", "noisy encoder")


def test_right_velocities_pass_and_wrong_ones_are_named(root: Path) -> None:
    done = subprocess.run(PROGRAM, cwd=root, capture_output=True, text=True, check=True)
    figures = json.loads(done.stdout)
    assert figures["runs"] >= 2
    for kind, shares in figures["alarms"].items():
        assert set(shares.values()) == ({0.0} if kind in RIGHT else {1.0}), kind
    for label, share in figures["alone"].items():
        assert share == (0.0 if label.endswith("times 1") else 1.0), label
