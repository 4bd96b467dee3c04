"""A small seeded version of the study of faulty logs, and its contract."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

PROGRAM = [sys.executable, "benchmarks/faults.py", "--json", "-", "--runs", "12"]


def test_no_faulty_log_gives_a_wrong_number_silently(root: Path) -> None:
    done = subprocess.run(PROGRAM, cwd=root, capture_output=True, text=True, check=True)
    figures = json.loads(done.stdout)
    assert figures["seed"] == 1
    assert figures["runs"] >= 12
    wrong = [run for run in figures["each"] if run["outcome"] in ("SILENT", "broken", "hung")]
    assert not wrong
    assert figures["outcomes"]["clean"] >= 1, "faults are put into logs that raise no alarm"
    assert set(figures["outcomes"]) <= {"refused", "told", "harmless", "clean", "alarm"}
