"""The benchmark of friction that remembers says what it is run for."""

import json
import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.slow
def test_what_a_bristle_is_declared_by_is_found_from_swings_and_dwells(
    root: Path, tmp_path: Path
) -> None:
    file = tmp_path / "presliding.json"
    command = ["benchmarks/presliding.py", "--runs", "2", "--json", str(file)]
    subprocess.run([sys.executable, *command], cwd=root, check=True)
    found = json.loads(file.read_text())
    assert max(map(abs, found["bias_percent"].values())) < 0.05
    assert not found["checks_failed"]
    assert found["steps"] <= 10
