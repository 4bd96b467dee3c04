"""Faults of the equation of motion: what was refused though right, and what came out wrong."""

import json
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from axisid import (
    Axis,
    ModelError,
    build,
    derive,
    identify,
    load_axis,
    twin_record,
)
from tests.faults.fault import Fault, Misuse

AXIS = """\
import sympy
from sympy import Abs, Heaviside, Piecewise, sign
from axisid import Coordinate, Parameter, newton
from axisid.elements import Drive, stribeck, viscous

q = Coordinate("q", unit="rad")
J, F, b = Parameter("J", "kg m^2"), Parameter("F", "N m"), Parameter("b", "N m/(rad/s)")
c = Parameter("c", "N m/(rad/s)")
Fg, H = Parameter("Fg", "N m"), Parameter("H", "N m")
Q, DQ, B, C = q.symbol, q.velocity, b.symbol, c.symbol
axis = newton(
    "mine",
    coordinate=q,
    parameters=(J, {parameters}),
    inertia=J,
    resistance=({terms},),
    drive=Drive(gain=1.0{drive}),
)
"""
TOML = """\
name = "mine"
coordinate = {{ name = "x", unit = "m" }}
drive = {{ gain = 1.0 }}
parameters.m = {{ unit = "kg", nominal = 1.0 }}
parameters.b = {{ unit = "N/(m/s)" }}

[newton]
inertia = "m"
resistance = ["b*dx", "{load}"]
"""
Make = Callable[[Path], list[object]]


def _generate(terms: str, parameters: str, drive: str = "") -> Make:
    def make(folder: Path) -> list[object]:
        text = AXIS.format(terms=terms, parameters=parameters, drive=drive)
        (folder / "mine.py").write_text(text)
        return ["generate", "mine.py", "--output", "out"]

    return make


def _shown(load: str) -> Make:
    def make(folder: Path) -> list[object]:
        (folder / "mine.toml").write_text(TOML.format(load=load))
        return ["show", "mine.toml"]

    return make


def _force(*motion: float, wanted: float) -> Callable[[Path, str], None]:
    """The force of the generated axis at a motion, its parameters 1."""

    def after(folder: Path, _: str) -> None:
        axis = load_axis(str(folder / "mine.py"))
        made = build(axis, native=False)
        values = np.ones(len(made.parameters))
        direction = math.copysign(1.0, motion[1])
        (got,) = made.evaluate("inverse_dynamics", *motion, direction, values)
        assert math.isclose(got[0, 0], wanted, rel_tol=1e-9), got

    return after


def _columns(*wanted: str) -> Callable[[Path, str], None]:
    def after(folder: Path, _: str) -> None:
        manifest = json.loads((folder / "out" / "mine" / "manifest.json").read_text())
        assert [p["name"] for p in manifest["parameters"]] == list(wanted)

    return after


def _python(folder: Path) -> list[object]:
    axis = load_axis("emps2015")
    result = identify(axis, twin_record(axis), methods=["idm-ls"])
    (folder / "result.json").write_text(json.dumps(result.to_dict()))
    return ["export", "result.json", "--axis", "emps2015", "--to", "python"]


def _takes_numpy(_: Path, out: str) -> None:
    functions: dict[str, Callable[..., float]] = {}
    exec(compile(out, "export.py", "exec"), functions)
    force = functions["emps2015_feedforward"]
    wanted = force(0.0, 0.2, 1.0)
    assert force(np.float64(0.0), np.float64(0.2), np.float64(1.0)) == wanted
    assert list(force(np.zeros(2), np.array([0.2, 0.2]), 1.0)) == [wanted, wanted]
    assert force(0.0, math.inf, 0.0) == math.inf


def _misuse(resistance: str) -> Callable[[], object]:
    def call() -> Axis:
        namespace: dict[str, Axis] = {}
        text = AXIS.format(terms=resistance, parameters="F, b", drive="")
        exec(compile(text, "mine.py", "exec"), namespace)
        return derive(namespace["axis"]).axis

    return call


_WROTE = "files written"
FAULTS: tuple[Fault, ...] = (
    Fault(
        name="power of a difference multiplied out",
        make=_generate("F*((Q - 2)/0.1)**12", "F"),
        code=0,
        says=_WROTE,
        after=_force(2.05, 0.0, 0.0, wanted=0.5**12),
    ),
    Fault(
        name="power of a difference multiplied out, with a direction",
        make=_generate("F*(Q - 10)**3*(1 + sign(DQ))**2/4", "F"),
        code=0,
        says=_WROTE,
        after=_force(10.0001, 1.0, 0.0, wanted=(10.0001 - 10) ** 3),
    ),
    Fault(
        name="root of a difference multiplied out",
        make=_generate("F*sympy.sqrt((Q - 100)**2 + 1e-14)", "F"),
        code=0,
        says=_WROTE,
        after=_force(100.0, 0.0, 0.0, wanted=1e-7),
    ),
    Fault(
        name="narrow exponential over a profile",
        make=_generate(
            "stribeck(F, q, velocity=0.01), viscous(b, q)",
            "F, b",
            ", profile=1 + 0.05*sympy.cos(2*sympy.pi*Q/0.03)",
        ),
        code=0,
        says=_WROTE,
        after=_force(0.015, 0.27, 0.0, wanted=0.27 / 0.95),
    ),
    Fault(
        name="number taken out of an exponent",
        make=_generate("F*sympy.exp((Q - 10000.0)*1.5), viscous(b, q)", "F, b"),
        code=0,
        says=_WROTE,
        after=_force(10000.2, 9999.0, 0.0, wanted=9999.0 + math.exp((10000.2 - 10000) * 1.5)),
    ),
    Fault(
        name="number taken out of an exponent, too large for a float",
        make=_shown("2*exp((10000.0 - x)*1.5)"),
        code=0,
        says="mine",
    ),
    Fault(
        name="number too small for a float",
        make=_shown("(x*1e-17)**20"),
        code=4,
        says=r"a number in it is too small for a float",
    ),
    Fault(
        name="parameters lost beside a large power",
        make=_generate("F*(Q/0.1 - 90)**8, Fg*(1 + sign(DQ))/2 - H*(1 - sign(DQ))/2", "F, Fg, H"),
        code=0,
        says=_WROTE,
        after=_columns("J", "F", "Fg", "H"),
    ),
    Fault(
        name="friction in pieces of the position",
        make=_generate("Piecewise((b*DQ, Q < 0), (c*DQ, True))", "b, c"),
        code=0,
        says=_WROTE,
        after=_columns("J", "b", "c"),
    ),
    Fault(
        name="friction in pieces of the direction",
        make=_generate("Piecewise((b*DQ, DQ < 0), (F + c*DQ, True))", "F, b, c"),
        code=0,
        says=_WROTE,
        after=_force(0.0, 2.0, 0.0, wanted=3.0),
    ),
    Fault(
        name="force that jumps with the velocity elsewhere",
        make=_generate("Piecewise((F, DQ < 1), (2*F, True))", "F"),
        code=4,
        says=r"Piecewise\(\(F, dq < 1\), \(2\*F, True\)\) jumps with the velocity; write the jump",
    ),
    *(
        Fault(
            name=f"known load of {load}",
            make=_shown(load),
            code=0,
            says=r"\(right if its plain numbers stand for",
        )
        for load in ("0.5", "1", "2", "2*sign(dx)")
    ),
    Fault(name="exported Python on arrays", make=_python, code=0, says="", after=_takes_numpy),
)
MISUSES: tuple[Misuse, ...] = (
    Misuse(
        name="friction that bends with its direction",
        call=_misuse("F*sympy.exp(sign(DQ)), b*DQ"),
        error=ModelError,
        says=r"exp\(direction\) is not linear in direction = sign\(dq\)",
    ),
)
