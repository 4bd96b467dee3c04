"""Faults of estimates and of simulated loops: terms not shown, wrong forces, what runs away."""

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
    Record,
    UsageError,
    build,
    load_axis,
    simulate,
    twin_record,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.elements import Drive, end_stop
from axisid.estimation.simulation.twin import trajectory
from axisid.modeling import Move
from tests.axes.bodies import stage, x
from tests.axes.unseen import with_bump, with_stribeck
from tests.faults.fault import Fault, Misuse
from tests.files import csv_file, text_file
from tests.unjudged import identify

_TERM = """
from dataclasses import replace

import sympy

from axisid import Parameter, load_axis
from axisid.elements import stribeck

base = load_axis("emps2015")
q = base.coordinate
P = Parameter("P", "N", nominal=10.0)
axis = replace(
    base,
    name="unseen",
    parameters=(*base.parameters, P),
    force=base.force + {term},
    experiment=replace(base.experiment, truth={{**base.experiment.truth, "P": 12.0}}),
)
"""
_SLOW = "stribeck(P, q, velocity=1e-3)"
_FAR = "P * sympy.exp(-(((q.symbol - 0.15) / 0.01) ** 2))"
_GAIN = 35.15


def _declared(folder: Path, term: str) -> Path:
    return text_file(folder / "unseen.py", _TERM.format(term=term))


def _asked(command: str, term: str, *options: object) -> Callable[[Path], list[object]]:
    """A command for an axis with a term, and a log that shows nothing of it."""

    def make(folder: Path) -> list[object]:
        csv_file(folder / "log.csv", twin_record(load_axis("emps2015")).channels())
        return [command, _declared(folder, term), "log.csv", *options]

    return make


def _finds(
    folder: Path, _: str, *, within: float = 0.01, left_out: str = "", **truth: float
) -> None:
    """Every method finds the parameters, beside what is left out."""
    written = json.loads((folder / "result.json").read_text())
    assert [*written.get("left_out", ())] == left_out.split()
    assert written["estimates"]
    for estimate in written["estimates"]:
        found = {name: p["value"] for name, p in estimate["parameters"].items()}
        for name, value in truth.items():
            assert found[name] == pytest.approx(value, rel=within), estimate["method"]


def _spoilt(change: Callable[[Record], Record]) -> Callable[[Path], list[object]]:
    """A log of the twin, changed."""

    def make(folder: Path) -> list[object]:
        csv_file(folder / "log.csv", change(twin_record(load_axis("emps2015"))).channels())
        return ["identify", "emps2015", "log.csv"]

    return make


def _rests(folder: Path, *options: object) -> list[object]:
    """Four strokes, each with a rest of a second and a half."""
    axis = build(load_axis("emps2015"))
    pieces, place = [], 0.0
    for k in range(4):
        stroke = place + trajectory((Move((-1) ** k * 0.04, 0.05 * (1 + k % 3), 0.75),), 1e-3)
        place = float(stroke[-1])
        pieces += [stroke, np.full(1500, place)]
    reference = np.concatenate(pieces)
    loop = simulate(axis, [100.2, 236.9, 24.8], reference, 1e-3)
    record = Record(
        time=loop.time, position=loop.position, reference=reference, control=loop.control
    )
    csv_file(folder / "log.csv", record.channels())
    return ["identify", "emps2015", "log.csv", "--method", "idm-iv", *options]


def _white(folder: Path) -> list[object]:
    """A reference of noise alone."""
    axis = build(load_axis("emps2015"))
    travel = float(np.ptp(twin_record(axis, position_noise=0.0).position))
    reference = np.random.default_rng(1).normal(0.0, 1e-3 * travel, 5000)
    loop = simulate(axis, [100.2, 236.9, 24.8], reference, 1e-3)
    record = Record(
        time=loop.time, position=loop.measured_position, reference=reference, control=loop.control
    )
    csv_file(folder / "log.csv", record.channels())
    return ["identify", "emps2015", "log.csv", "--method", "idm-iv"]


FAULTS: tuple[Fault, ...] = (
    Fault(
        name="a friction at speeds that no row has",
        make=_asked("identify", _SLOW),
        code=6,
        says=r"does not show P, .*a force of \S+ N where it acts most.*leave_out|leave-out",
    ),
    Fault(
        name="a force at a place that the axis never reaches",
        make=_asked("identify", _FAR, "--method", "idm-iv"),
        code=6,
        says=r"does not show P[,:] .*parameter in N is about \S+ and its nominal value is 10",
    ),
    Fault(
        name="a term that no cut-off shows",
        make=_asked("sweep", _SLOW, "--from", "50", "--to", "60", "--points", "2"),
        code=6,
        says=r"no cut-off gave an estimate: .*does not show P",
    ),
    Fault(
        name="a term that is left out on request",
        is_slow=True,
        make=_asked(
            "identify",
            _SLOW,
            "--leave-out",
            "P",
            "--method",
            "idm-iv",
            "--json",
            "result.json",
        ),
        code=0,
        says=r"left out +P = 0 N",
        after=partial(_finds, within=2e-3, left_out="P", M=100.2),
    ),
    Fault(
        name="a term to leave out that is not there",
        make=lambda _: ["identify", "emps2015", "--leave-out", "Fs"],
        code=2,
        says=r"no parameter 'Fs' to leave out. Axis 'emps2015' has M, Fv, Fc",
    ),
    Fault(
        name="a force column that is the control times 1.1",
        is_slow=True,
        make=_spoilt(lambda r: replace(r, force=1.1 * _GAIN * r.control)),
        code=0,
        says=r"FAIL law: the force column is 1\.1 \+- 0\.0001 times .*declared: 35\.15 N/V.*38\.66",
    ),
    Fault(
        name="a force column with a constant error",
        is_slow=True,
        make=_spoilt(lambda r: replace(r, force=_GAIN * r.control + 3.0)),
        code=0,
        says=r"FAIL law: the force column differs from .* by a constant of \+3 \+- \S+ N",
    ),
    Fault(
        name="a control beyond the drive's limit",
        is_slow=True,
        make=_spoilt(lambda r: replace(r, control=4 * r.control)),
        code=0,
        says=r"FAIL loop: the control exceeds the drive limit of 10 V .* % of the samples",
    ),
    Fault(
        name="a control with a constant error",
        is_slow=True,
        make=_spoilt(lambda r: replace(r, control=r.control + 0.1)),
        code=0,
        says=r"FAIL law: .*0\.1 V.*FAIL model: .*[Aa] constant force is missing: \+3\.5\d? \+- "
        r"\S+ N",
    ),
    Fault(
        name="a log that rests most of the time",
        is_slow=True,
        make=lambda folder: _rests(folder, "--json", "result.json"),
        code=0,
        says="All checks|Use with care",
        after=partial(_finds, within=2e-3, M=100.2, Fv=236.9, Fc=24.8),
    ),
    Fault(
        name="a reference of white noise",
        make=_white,
        code=0,
        says=r"^(?!.*(does not converge in|jumps with the parameters)).*IDM-IV",
    ),
    Fault(
        name="rests that are kept",
        is_slow=True,
        make=lambda folder: _rests(folder, "--reversals", "keep"),
        code=0,
        says=r"Do not use .*without simulated replicas",
    ),
)
MISUSES: tuple[Misuse, ...] = (
    Misuse(
        name="a friction that the motion does not show, in Python",
        call=lambda: identify(
            build(with_stribeck(3e-3), native=False),
            twin_record(load_axis("emps2015")),
            methods="ddm-ls",
        ),
        error=EstimationError,
        says=r"leave the parameter out \(leave_out\(axis, \"Fs\"\)\)\.",
    ),
    Misuse(
        name="a place beyond the motion without a nominal value",
        call=lambda: identify(
            build(with_bump(0.15, 0.0), native=False), twin_record(load_axis("emps2015"))
        ),
        error=EstimationError,
        says="Fb would have to be",
    ),
)


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


def _sags(folder: Path, _: str) -> None:
    """A motion of 1 um is followed, by an axis that gives way to its weight by 1 mm."""
    loop = simulate(load_axis(folder / "carriage.toml"), [6.0, 14.0, 7.0], 1e-5 * _REFERENCE, 1e-3)
    assert loop.position[-1] == pytest.approx(-6.0 * 9.80665 / (18 * 50 * 60), rel=0.2)


FAULTS += (
    Fault(
        name="an axis that rests between its strokes",
        is_slow=True,
        make=partial(_twin, moves=[*_STROKES[:4], _PAUSE, *_STROKES[4:]]),
        code=0,
        says="carriage",
        after=partial(_finds, m=6.2, b=14.0, c=7.5),
    ),
    Fault(
        name="a force that jumps with the position",
        is_slow=True,
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
        make=lambda folder: ["show", *_twin(folder, resistance='"m*G"')[1:2]],
        code=0,
        says="carriage",
        after=_sags,
    ),
)
MISUSES += (
    Misuse(
        name="Coulomb friction that drives the axis",
        call=lambda: _simulated([6.0, 14.0, -7.0]),
        error=EstimationError,
        says="the friction of axis 'carriage' drives the axis",
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
        says=r"the control law is evaluated every 0\.001 s\. .*at most 400\. Give the sampling",
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
