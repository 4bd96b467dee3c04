"""Faults of simulated loops: what cannot be followed, and right models that once were not."""

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from axisid import (
    Coordinate,
    Drive,
    EstimationError,
    Parameter,
    UsageError,
    build,
    cascade_pd,
    coulomb,
    end_stop,
    newton,
    simulate,
    viscous,
)
from axisid.codegen import GeneratedAxis
from tests.faults.fault import Fault, Misuse

# A carriage under a cascade, with resistances of its own; its experiment is a twin.
_AXIS = """
name = "carriage"
coordinate = {{ name = "x", unit = "m" }}

[parameters]
m = {{ unit = "kg", nominal = 5, lower = 0 }}
b = {{ unit = "N/(m/s)", lower = 0 }}
c = {{ unit = "N", lower = 0 }}
{parameters}

[newton]
inertia = "m"
resistance = ["b*dx", "c*sign(dx)", {resistance}]

[drive]
gain = 18.0
unit = "A"

[control]
law = "cascade_pd"
kp = 50.0
kv = 60.0
period = 1e-3

[experiment]
moves = {moves}
truth = {{ m = 6.2, b = 14.0, c = {c}{truth} }}
"""
_MOVE = "{{ distance = {}, speed = {}, acceleration = 4.0 }}"
_STROKES = [_MOVE.format(d, v) for v in (0.1, 0.2, 0.4) for d in (0.08, -0.08)]
_PAUSE = _MOVE.format(3e-9, 1e-9)  # of 3 s


def _twin(
    folder: Path,
    *,
    resistance: str = "",
    parameters: str = "",
    truth: str = "",
    c: float = 7.5,
    moves: list[str] = _STROKES,
) -> list[object]:
    text = _AXIS.format(
        resistance=resistance,
        parameters=parameters,
        truth=f", {truth}" if truth else "",
        c=c,
        moves=f"[{', '.join(moves)}]",
    )
    (folder / "carriage.toml").write_text(text)
    return ["identify", "carriage.toml", "--json", "result.json"]


def _finds(folder: Path, _: str, *, methods: int = 4, **truth: float) -> None:
    """Every method finds the parameters within 1 %."""
    estimates = json.loads((folder / "result.json").read_text())["estimates"]
    assert len(estimates) == methods
    for estimate in estimates:
        found = {name: p["value"] for name, p in estimate["parameters"].items()}
        for name, value in truth.items():
            assert found[name] == pytest.approx(value, rel=0.01), estimate["method"]
