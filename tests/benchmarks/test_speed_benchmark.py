"""The benchmark of speed keeps its contract. It is not a timed test: no figure is judged here."""

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from axisid.codegen.native.compiler import find_compiler
from axisid.codegen.native.errors import NativeUnavailableError

pytestmark = pytest.mark.slow


def figures(root: Path, *options: str) -> dict[str, Any]:
    command = [sys.executable, "benchmarks/speed.py", "--json", "-", "--rounds", "1", *options]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def test_every_figure_of_speed_is_of_its_unit_and_over_its_yardstick(root: Path) -> None:
    try:
        find_compiler()
    except NativeUnavailableError as error:
        pytest.skip(str(error))
    found = figures(root)
    units = {"ms": (0.01, 1e5), "us": (0.1, 1e3), "kB": (0.05, 50)}
    for name, of in found.items():
        least, most = units[of["unit"]]
        assert least < of["cost"] < most, name
        if "over" in of:
            ratio = of["cost"] / found[of["yardstick"]]["cost"]
            assert of["over"]["ratio"] == pytest.approx(ratio), name
    for name in ("simulate", "simulate_batch", "identify", "--help"):
        assert 0.1 < found[name]["over"]["ratio"] < 10, name
    assert 1 < found["identify, intervals"]["over"]["ratio"] < 100  # 32 twins


def test_figures_stand_beside_those_of_another_commit(root: Path) -> None:
    if not shutil.which("git") or not (root / ".git").exists():
        pytest.skip("no git checkout to take another commit from")
    found = figures(root, "--only", "import axisid", "--against", "HEAD")
    assert set(found) == {"import numpy", "import axisid"}
    for of in found.values():
        assert 0.02 < of["against"]["lowest"] <= of["against"]["ratio"] <= of["against"]["highest"]
        assert of["against"]["highest"] < 50
