"""Faults of declarations and of the equation of motion."""

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
    load_axis,
    twin_record,
)
from tests.faults.fault import Fault, Misuse
from tests.files import csv_file
from tests.unjudged import identify

Make = Callable[[Path], list[object]]

# An inertia with friction under a cascade; its experiment is a twin.
_AXIS = """
name = "mine"
coordinate = {{ name = "q", unit = "rad" }}
drive = {{ gain = 1.0 }}
control = {{ law = "cascade_pd", kp = 40.0, kv = 100.0, period = 1e-3 }}

[parameters]
J = {{ unit = "kg m^2", nominal = 1.0 }}
{parameters}

[experiment]
moves = [{{ distance = 0.1, speed = 0.2, acceleration = 4.0 }}]
truth = {{ J = 1.0, {truth} }}

{equation}
"""
_UNITS = {"b": "N m/(rad/s)", "c": "N m", "d": "N m", "k": "N m rad/s"}

_PROGRAM = """
import functools

import sympy
from axisid import Coordinate, Parameter, newton
from axisid.elements import Drive

q = Coordinate("q", unit="rad")
J, c = Parameter("J", "kg m^2", nominal=1.0), Parameter("c", "N m")
P = [Parameter(f"p{{k}}", "1", nominal=1.0 + k) for k in range(6)]


def larger(inner, k):
    return sympy.Max(P[k].symbol, inner * (k + 1) / 2 - sympy.Rational(3 * k, 10))


force = {resistance}
used = [p for p in (J, c, *P) if p is J or p.symbol in force.free_symbols]
axis = newton(
    "mine",
    coordinate=q,
    parameters=used,
    inertia=J,
    resistance=(force,),
    drive=Drive(gain=1.0),
)
"""


def _axis(equation: str, **nominal: float) -> str:
    """The declaration, with parameters of these nominal values; those unknown are pure numbers."""
    rows = (
        f'{name} = {{ unit = "{_UNITS.get(name, "1")}", nominal = {value} }}'
        for name, value in nominal.items()
    )
    truth = ", ".join(f"{name} = {value}" for name, value in nominal.items())
    return _AXIS.format(parameters="\n".join(rows), truth=truth, equation=equation)


def _file(name: str, text: str, *arguments: object) -> Make:
    """A file of a text, and the arguments of a command that may name it."""

    def make(folder: Path) -> list[object]:
        (folder / name).write_text(text)
        return [*arguments]

    return make


def _newton(command: str, resistance: str, *options: object, **nominal: float) -> Make:
    """A command for an axis with one resistance."""
    equation = f'[newton]\ninertia = "J"\nresistance = ["{resistance}"]'
    return _file("mine.toml", _axis(equation, **nominal), command, "mine.toml", *options)


def _lagrange(kinetic: str, potential: str) -> Make:
    """An axis declared by its energies."""
    energies = f'kinetic = "{kinetic}"\npotential = "{potential}"\ndissipation = "b*dq**2/2"'
    declared = _axis(f"[lagrange]\n{energies}", b=1.0)
    return _file("mine.toml", declared, "identify", "mine.toml")


def _python(command: str, resistance: str) -> Make:
    """The same in Python, whose expressions no reader of texts has looked at."""
    return _file("mine.py", _PROGRAM.format(resistance=resistance), command, "mine.py")


def _near_a_pole(folder: Path) -> list[object]:
    """A log that comes so near to a pole of the force that no number holds its square."""
    arguments = _newton("identify", "c*cosh(1/q**0.5)", "log.csv", "--method", "idm-ls", c=1.0)
    time = 1e-3 * np.arange(3000)
    position = 5e-6 + 0.1 * (1 - np.cos(4 * time)) / 2
    columns = {"time": time, "position": position, "control": np.cos(4 * time)}
    csv_file(folder / "log.csv", columns, "%.12g")
    return arguments(folder)


_PAGE = "Inverse regressor"
_SUMS = "c*(p0 + p1 + p2)**8*q + d*(p3 + p4)**12*q**3"

#: What once took minutes, and is shown.
_LONG = (
    Fault(
        name="Max in Max, six deep",
        is_slow=True,
        make=_python("show", "c * functools.reduce(larger, range(6), q.symbol)"),
        code=0,
        says=_PAGE,
    ),
    Fault(
        name="powers of sums of parameters",
        is_slow=True,
        make=_newton("show", _SUMS, c=1.0, d=1.0, **{f"p{k}": 1.0 + k for k in range(5)}),
        code=0,
        says=_PAGE,
    ),
    Fault(
        name="a logarithm of a broken power",
        make=_newton("show", "c*log(cosh(q**(1/3)))", c=1.0),
        code=0,
        says=_PAGE,
    ),
    Fault(
        name="a power of many terms, whose loop diverges",
        is_slow=True,
        make=_newton("identify", "c*(q + p + r + s)**20", c=1.0, p=1.0, r=1.0, s=1.0),
        code=6,
        says="diverges",
    ),
)

_ENERGIES = tuple(
    Fault(name=name, make=_lagrange(kinetic, potential), code=4, says=says)
    for name, kinetic, potential, says in (
        (
            "a potential energy of the acceleration",
            "J*dq**2/2",
            "J*q*ddq",
            r"potential energy \S+ depends on ddq. It may depend on the position q only",
        ),
        (
            "a force in a potential energy",
            "J*dq**2/2",
            "spring(b, q)",
            "the function spring is not known",
        ),
        (
            "a potential energy of the velocity",
            "J*dq**2/2",
            "b*q*dq",
            r"potential energy \S+ depends on dq.*friction into the dissipation function",
        ),
        (
            "a kinetic energy of the acceleration",
            "J*dq*ddq/2",
            "0",
            r"kinetic energy \S+ depends on ddq. It may depend on the position q and the s",
        ),
        (
            "a negative kinetic energy",
            "-J*dq**2/2",
            "0",
            "inertia -J is negative with the nominal values, and so is the kinetic energy",
        ),
    )
)

_NAMES = tuple(
    Fault(
        name=f"a parameter called {name}",
        make=_newton("identify", f"b*dq + {name}*c*q", b=1.0, c=1.0, **{name: 3.0}),
        code=4,
        says=f"a parameter is named '{name}', which is {what} in every expression. Choose another",
    )
    for name, what in (("pi", "the number pi"), ("G", "the standard acceleration of gravity"))
)

_NO_NUMBER = (
    Fault(
        name="an arc cosine of a nominal value beyond 1",
        is_slow=True,
        make=_newton("identify", "c*max(9, acos(p))*q", c=1.0, p=2.0),
        code=6,
        says="no motion shows a change of p",
    ),
    Fault(
        name="a root that is nothing at its nominal value",
        make=_newton("identify", "c*sqrt(2 - r)*q", c=1.0, r=2.0),
        code=6,
        says="no motion distinguishes c and r at the nominal values. Declare the combination",
    ),
    Fault(
        name="an imaginary friction",
        make=_python("identify", "c * sympy.I * q.symbol"),
        code=4,
        says=r"equation of motion is not real.*\. Write a real force, without the imagin",
    ),
    Fault(
        name="a record that comes too near to a pole of the force",
        make=_near_a_pole,
        code=6,
        says=r"reaches \S+ in the columns of c, and their squares overflow\. Check these terms",
    ),
    Fault(
        name="a friction without a value at rest",
        make=_newton("identify", "k/dq", k=1.0),
        code=6,
        says="cannot be simulated: its force has no finite value at rest at q = 0 rad",
    ),
    Fault(
        name="a force beside which no drive counts",
        make=_newton("identify", "1e300*c*exp(q)", c=1.0),
        code=6,
        says=r"its force is 1e\+300 N m at rest at q = 0 rad .* See the term 1\S*c\*exp\(q\)\.",
    ),
)

FAULTS: tuple[Fault, ...] = (*_LONG, *_ENERGIES, *_NAMES, *_NO_NUMBER)


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


def _generate(terms: str, parameters: str, drive: str = "") -> Make:
    text = AXIS.format(terms=terms, parameters=parameters, drive=drive)
    return _file("mine.py", text, "generate", "mine.py", "--output", "out")


def _shown(load: str) -> Make:
    return _file("mine.toml", TOML.format(load=load), "show", "mine.toml")


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


def _exported(folder: Path) -> list[object]:
    axis = load_axis("emps2015")
    result = identify(axis, twin_record(axis), methods=["idm-ls"])
    result.save(folder / "result.json")
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
FAULTS += (
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
        says="a number in the expression is too large or too small for a float",
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
        says=r"Piecewise\(\(F, dq < 1\), \(2\*F, True\)\) jumps with the velocity",
    ),
    *(
        Fault(
            name=f"known load of {load}",
            make=_shown(load),
            code=0,
            says=r"\(correct if its plain numbers have the unit",
        )
        for load in ("0.5", "1", "2", "2*sign(dx)")
    ),
    Fault(
        name="exported Python on arrays",
        is_slow=True,
        make=_exported,
        code=0,
        says="",
        after=_takes_numpy,
    ),
)
MISUSES: tuple[Misuse, ...] = (
    Misuse(
        name="friction that bends with its direction",
        call=_misuse("F*sympy.exp(sign(DQ)), b*DQ"),
        error=ModelError,
        says=r"exp\(direction\) is not linear in direction = sign\(dq\)",
    ),
)
