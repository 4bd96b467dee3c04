"""A small seeded version of the study of recorded signals."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

PROGRAM = [sys.executable, "benchmarks/recorded_signals.py", "--json", "-", "--runs", "2"]


def test_right_signals_pass_and_wrong_ones_are_named(root: Path) -> None:
    done = subprocess.run(PROGRAM, cwd=root, capture_output=True, text=True, check=True)
    figures = json.loads(done.stdout)
    assert figures.pop("runs") == 2
    for case, share in figures.items():
        assert share == (0.0 if case.startswith("right") else 1.0), case
