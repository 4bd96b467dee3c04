"""The benchmark of fits says what it is run for."""

import json
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

study: Any = import_module("fits")


@pytest.mark.slow
def test_fits_are_right_where_the_law_is_and_say_so_where_it_is_not(
    root: Path, tmp_path: Path
) -> None:
    file = tmp_path / "fits.json"
    command = ["benchmarks/fits.py", "--runs", "2", "--only", "kp +1 %", "--json", str(file)]
    subprocess.run([sys.executable, *command], cwd=root, check=True)
    written = json.loads(file.read_text())
    assert max(written["slopes_off"].values()) < 1e-5
    right, wrong = study.figures_of("white noise", runs=6, seed=1), written["cases"]["kp +1 %"]
    for of in right.values():
        assert max(map(abs, of["bias_percent"].values())) < 0.5
        assert not of["checks_failed"]
        assert of["most_jacobians"] <= 10
    assert wrong["position"]["bias_percent"]["Fv"] > 30
    assert wrong["position"]["checks_failed"]["law's factors"] == 2
    assert abs(wrong["control"]["bias_percent"]["Fv"]) < 1
