"""Faults of what a record is asked for: terms that it does not show, forces not its own."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from axisid import EstimationError, Record, build, identify, load_axis, simulate, twin_record
from axisid.estimation.simulation.twin import trajectory
from axisid.modeling import Move
from tests.axes.unseen import with_bump, with_stribeck
from tests.faults.fault import Fault, Misuse

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
    file = folder / "unseen.py"
    file.write_text(_TERM.format(term=term))
    return file


def _asked(command: str, term: str, *options: object) -> Callable[[Path], list[object]]:
    """A command for an axis with a term, and a log that shows nothing of it."""

    def make(folder: Path) -> list[object]:
        _write(folder / "log.csv", twin_record(load_axis("emps2015")))
        return [command, _declared(folder, term), "log.csv", *options]

    return make


def _found_without(folder: Path, _out: str) -> None:
    written = json.loads((folder / "result.json").read_text())
    assert written["left_out"] == {"P": 0.0}
    (iv,) = (e for e in written["estimates"] if e["method"] == "idm-iv")
    assert abs(iv["parameters"]["M"]["value"] / 100.2 - 1) < 2e-3


def _write(file: Path, record: Record) -> None:
    columns = record.channels()
    table, names = np.column_stack(list(columns.values())), ",".join(columns)
    np.savetxt(file, table, delimiter=",", header=names, comments="")


def _spoilt(change: Callable[[Record], Record]) -> Callable[[Path], list[object]]:
    """A log of the twin, changed."""

    def make(folder: Path) -> list[object]:
        _write(folder / "log.csv", change(twin_record(load_axis("emps2015"))))
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
    _write(folder / "log.csv", record)
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
    _write(folder / "log.csv", record)
    return ["identify", "emps2015", "log.csv", "--method", "idm-iv"]


def _right_after_rests(folder: Path, _out: str) -> None:
    written = json.loads((folder / "result.json").read_text())
    (iv,) = (e for e in written["estimates"] if e["method"] == "idm-iv")
    found = [value["value"] for value in iv["parameters"].values()]
    assert np.allclose(found, [100.2, 236.9, 24.8], rtol=2e-3)


FAULTS: tuple[Fault, ...] = (
    Fault(
        name="a friction at speeds that no row has",
        make=_asked("identify", _SLOW),
        code=6,
        says=r"does not show P, .*a force of \S+ N where it acts most.*leave-out P",
    ),
    Fault(
        name="a force at a place that the axis never reaches",
        make=_asked("identify", _FAR, "--method", "idm-iv"),
        code=6,
        says=r"does not show P[,:] .*make a parameter in N about \S+ and its nominal value is 10",
    ),
    Fault(
        name="a term that no cut-off shows",
        make=_asked("sweep", _SLOW, "--from", "50", "--to", "60", "--points", "2"),
        code=6,
        says=r"no cut-off gave an estimate: .*does not show P",
    ),
    Fault(
        name="a term that is left out on request",
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
        after=_found_without,
    ),
    Fault(
        name="a term to leave out that is not there",
        make=lambda _: ["identify", "emps2015", "--leave-out", "Fs"],
        code=2,
        says=r"no parameter 'Fs' to leave out; axis 'emps2015' has M, Fv, Fc",
    ),
    Fault(
        name="a force column that is the control times 1.1",
        make=_spoilt(lambda r: replace(r, force=1.1 * _GAIN * r.control)),
        code=0,
        says=r"FAIL law: the force column is 1\.1 \+- 0\.0001 times .* which "
        r"would be 38\.66 N/V for 35\.15",
    ),
    Fault(
        name="a force column with a constant error",
        make=_spoilt(lambda r: replace(r, force=_GAIN * r.control + 3.0)),
        code=0,
        says=r"FAIL law: the force column is \+3 \+- \S+ N beside what the "
        r"drive's gain makes of the control",
    ),
    Fault(
        name="a control beyond the drive's limit",
        make=_spoilt(lambda r: replace(r, control=4 * r.control)),
        code=0,
        says=r"FAIL loop: the control is beyond the drive's limit of 10 V in "
        r"\S+ % of the samples, up to",
    ),
    Fault(
        name="a control with a constant error",
        make=_spoilt(lambda r: replace(r, control=r.control + 0.1)),
        code=0,
        says=r"with a constant of 0\.1 V off the control.*FAIL model: a constant force, "
        r"\+3\.5\d? \+- \S+ N",
    ),
    Fault(
        name="a log that rests most of the time",
        make=lambda folder: _rests(folder, "--json", "result.json"),
        code=0,
        says="Nothing that was checked speaks against these numbers|Believe these numbers",
        after=_right_after_rests,
    ),
    Fault(
        name="a reference of white noise",
        make=_white,
        code=0,
        says=r"^(?!.*(still move|jumps with the parameters)).*IDM-IV",
    ),
    Fault(
        name="rests that are kept",
        make=lambda folder: _rests(folder, "--reversals", "keep"),
        code=0,
        says=r"Do not believe .*by no twins",
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
        says=r"leave it out \(leave-out Fs\)\.",
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
