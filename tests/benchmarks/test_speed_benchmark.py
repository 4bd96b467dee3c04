"""The benchmark of speed keeps its contract. It is not a timed test: no figure is judged here."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from axisid.codegen.native.compiler import find_compiler
from axisid.codegen.native.errors import NativeUnavailableError

Figures = Callable[..., dict[str, Any]]
pytestmark = pytest.mark.slow


def test_every_figure_of_speed_is_of_its_unit_and_over_its_yardstick(figures: Figures) -> None:
    try:
        find_compiler()
    except NativeUnavailableError as error:
        pytest.skip(str(error))
    found = figures("speed", "--rounds", "1")
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


def test_figures_stand_beside_those_of_another_commit(root: Path, figures: Figures) -> None:
    if not shutil.which("git") or not (root / ".git").exists():
        pytest.skip("no git checkout to take another commit from")
    found = figures("speed", "--rounds", "1", "--only", "import axisid", "--against", "HEAD")
    assert set(found) == {"import numpy", "import axisid"}
    for of in found.values():
        assert 0.02 < of["against"]["lowest"] <= of["against"]["ratio"] <= of["against"]["highest"]
        assert of["against"]["highest"] < 50
