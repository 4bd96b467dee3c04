"""A small seeded version of the calibration study, and its contract."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

PROGRAM = [sys.executable, "benchmarks/calibration.py", "--json", "-", "--runs", "80"]


def test_intervals_hold_the_truth_as_often_as_they_say(root: Path) -> None:
    done = subprocess.run(PROGRAM, cwd=root, capture_output=True, text=True, check=True)
    figures = json.loads(done.stdout)
    assert figures.pop("runs") == 80
    assert set(figures) == {"white_iid", "white_hac", "coloured_iid", "coloured_hac"}
    # 80 runs tell a share of 95 % to about 2.4 % (one standard deviation), of 60 % to 5.5 %.
    for share in figures["white_hac"].values():
        assert share >= 0.87
    for share in figures["coloured_hac"].values():
        assert share >= 0.87
    for share in figures["coloured_iid"].values():
        assert share <= 0.78
