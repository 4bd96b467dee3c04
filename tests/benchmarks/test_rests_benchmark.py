"""A small seeded version of the study of axes at rest, and its contract."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

PROGRAM = [sys.executable, "benchmarks/rests.py", "--json", "-", "--axes", "6"]


def test_axes_that_rest_are_simulated_as_an_event_integrator_does(root: Path) -> None:
    done = subprocess.run(PROGRAM, cwd=root, capture_output=True, text=True, check=True)
    figures = json.loads(done.stdout)
    assert figures["axes"] == 6
    assert figures["refusals"] == 0
    assert figures["resting_share"] > 0.1
    assert figures["off_median_m"] < 1e-9
    assert figures["off_beyond_1_um"] == 0, "a count of the encoder may fall otherwise"
