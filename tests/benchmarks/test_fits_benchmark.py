"""The benchmark of fits says what it is run for."""

import json
import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.slow
def test_fits_are_right_where_the_law_is_and_say_so_where_it_is_not(
    root: Path, tmp_path: Path
) -> None:
    found = {}
    for name in ("white noise", "kp +1 %"):
        file = tmp_path / "fits.json"
        command = ["benchmarks/fits.py", "--runs", "6", "--only", name, "--json", str(file)]
        subprocess.run([sys.executable, *command], cwd=root, check=True)
        written = json.loads(file.read_text())
        found[name] = written["cases"][name]
        assert max(written["slopes_off"].values()) < 1e-5
    right, wrong = (found[name] for name in ("white noise", "kp +1 %"))
    for of in right.values():
        assert max(map(abs, of["bias_percent"].values())) < 0.5
        assert not of["checks_failed"]
        assert of["most_jacobians"] <= 10
    assert wrong["position"]["bias_percent"]["Fv"] > 30
    assert wrong["position"]["checks_failed"]["law's factors"] == 6
    assert abs(wrong["control"]["bias_percent"]["Fv"]) < 1
