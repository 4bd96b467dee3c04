"""Faults of simulated loops: what cannot be followed, and right models that once were not."""

import json
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import sympy

from axisid import (
    EstimationError,
    UsageError,
    build,
    load_axis,
    simulate,
)
from axisid.codegen.artefacts.generated_axis import GeneratedAxis
from axisid.elements import Drive, end_stop
from tests.axes.bodies import stage, x
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


def _finds(folder: Path, _: str, *, methods: int = 5, **truth: float) -> None:
    """Every method finds the parameters within 1 %."""
    estimates = json.loads((folder / "result.json").read_text())["estimates"]
    assert len(estimates) == methods
    for estimate in estimates:
        found = {name: p["value"] for name, p in estimate["parameters"].items()}
        for name, value in truth.items():
            assert found[name] == pytest.approx(value, rel=0.01), estimate["method"]


def _carriage(*resistance: sympy.Expr, gain: float = 18.0) -> GeneratedAxis:
    axis = stage(*resistance, name="carriage", drive=Drive(gain=gain, unit="A"))
    bounded = (replace(p, lower=0.0) if p.name == "b" else p for p in axis.parameters)
    axis = replace(axis, parameters=tuple(bounded))
    return build(axis, native=False)


_REFERENCE = 0.05 * (1 - np.cos(np.linspace(0.0, 6.28, 500)))


def _simulated(parameters: list[float], *, period: float = 1e-3) -> object:
    return simulate(_carriage(), parameters, _REFERENCE, period)


def _other(axis: Callable[[], GeneratedAxis]) -> Callable[[], object]:
    return lambda: simulate(axis(), [6.0, 14.0, 7.0], _REFERENCE, 1e-3)


def _hanging(folder: Path) -> list[object]:
    return ["show", *_twin(folder, resistance='"m*G"')[1:2]]


def _sags(folder: Path, _: str) -> None:
    """A motion of 1 um is followed, by an axis that gives way to its weight by 1 mm."""
    loop = simulate(load_axis(folder / "carriage.toml"), [6.0, 14.0, 7.0], 1e-5 * _REFERENCE, 1e-3)
    assert loop.position[-1] == pytest.approx(-6.0 * 9.80665 / (18 * 50 * 60), rel=0.2)


FAULTS: tuple[Fault, ...] = (
    Fault(
        name="an axis that rests between its strokes",
        make=partial(_twin, moves=[*_STROKES[:4], _PAUSE, *_STROKES[4:]]),
        code=0,
        says="carriage",
        after=partial(_finds, m=6.2, b=14.0, c=7.5),
    ),
    Fault(
        name="a force that jumps with the position",
        make=partial(
            _twin,
            resistance='"F0*sign(x - 0.04)"',
            parameters='F0 = { unit = "N", lower = 0 }',
            truth="F0 = 5.0",
        ),
        code=0,
        says="carriage",
        after=partial(_finds, m=6.2, b=14.0, c=7.5, F0=5.0),
    ),
    Fault(
        name="a reference far smaller than the sag of the load",
        make=_hanging,
        code=0,
        says="carriage",
        after=_sags,
    ),
)
MISUSES: tuple[Misuse, ...] = (
    Misuse(
        name="Coulomb friction that drives the axis",
        call=lambda: _simulated([6.0, 14.0, -7.0]),
        error=EstimationError,
        says="the friction of axis 'carriage' drives it",
    ),
    Misuse(
        name="a parameter below its bound",
        call=lambda: _simulated([6.0, -14.0, 7.0]),
        error=UsageError,
        says="below its declared bound of 0",
    ),
    Misuse(
        name="a period that is far from the law's",
        call=lambda: _simulated([6.0, 14.0, 7.0], period=1.0),
        error=UsageError,
        says="the control law is evaluated every 0.001 s; give one that is at most 400 times",
    ),
    Misuse(
        name="a loop that runs away",
        call=_other(lambda: _carriage(gain=-18.0)),
        error=EstimationError,
        says="diverges: the position leaves the range at sample",
    ),
    Misuse(
        name="a contact that no step resolves",
        call=_other(lambda: _carriage(end_stop(x, lower=-1.0, upper=0.05, stiffness=1e14))),
        error=EstimationError,
        says=r"too fast to follow at sample \d+ .*a contact is too stiff",
    ),
)
