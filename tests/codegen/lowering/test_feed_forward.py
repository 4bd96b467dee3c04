"""Exported feed-forward functions compute what the virtual machine computes, in every language."""

import ctypes
import math
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy

from axisid import (
    Axis,
    Coordinate,
    Parameter,
    Signal,
    build,
    derive,
    load_axis,
    newton,
)
from axisid.codegen.lowering.feed_forward import FeedForward, feed_forward
from axisid.codegen.lowering.program import Builder, Program
from axisid.codegen.printers.c import print_c99
from axisid.codegen.printers.python import print_python
from axisid.codegen.printers.shared import comment
from axisid.codegen.printers.structured_text import print_st
from axisid.codegen.runtime.library_cache import NativeUnavailableError, find_compiler
from axisid.elements import DIRECTION, VELOCITY, Drive, coulomb, voltage_drive
from axisid.modeling.quantities import FORCE
from tests.axes.drives import braked, varying
from tests.axes.recorded import UNRECORDED, fed_law, recorded_axis
from tests.axes.simulated import AXES
from tests.codegen.lowering.test_expressions import X, Y, by_machine, program_of
from tests.codegen.structured_text import structured_text
from tests.estimation.methods.test_partially_linear import stribeck_axis
from tests.refusals import refuses
from tests.strategies.expressions import operations

Functions = dict[str, Callable[..., float]]
STRICT = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-Wmissing-prototypes"]
TRIED = {
    **{name: load_axis(name) for name in UNRECORDED},
    **AXES,
    "stribeck": stribeck_axis(),
    "braked": braked(load_axis("emps2015")),
    "geared": replace(
        load_axis("emps2015"),
        drive=voltage_drive(kt=2.0, ke=2.0, resistance=0.5, efficiency=0.8, limit=60.0),
    ),
    "varying": varying(load_axis("pendulum")),
}


def awkward() -> Axis:
    """Names that a language may take for something else."""
    q = Coordinate("LREAL", unit="rad")
    R, sel, math_, tmp0 = (Parameter(n, "N m", nominal=1.0) for n in ("R", "SEL", "math", "tmp0"))
    J = Parameter("a__b_", "kg m^2", nominal=1.0)
    under, NAN = (Parameter(n, "N m", nominal=1.0) for n in ("a_b", "NAN"))
    return newton(
        "odd__",
        title='ends a comment: */ *) """ \\',
        coordinate=q,
        parameters=(J, under, NAN, R, sel, math_, tmp0),
        inertia=J,
        resistance=(
            coulomb(R, q),
            under * sympy.cos(q.symbol) ** 2 + NAN * sympy.sin(q.symbol) ** 4,
            sel.symbol,
            math_ * q.symbol**3,
            tmp0 * sympy.tanh(q.velocity / 3) / (2 + sympy.sin(q.symbol)),
        ),
        drive=Drive(gain=-1e-7, unit="A", limit=1e9),
    )


def exported(axis: Axis, values: np.ndarray, dead_zone: float = 0.0) -> FeedForward:
    numbers = {
        p.name: (float(x), "unit, */ *) (* /* \\ ??/ \u00e9\nnext line")
        for p, x in zip(axis.parameters, values, strict=True)
    }
    about = ("of the axis */ *)", axis.title, '"""')
    return feed_forward(derive(axis), numbers, about, dead_zone)


def in_c(text: str, folder: Path, *names: str, arguments: int = 3) -> Functions:
    try:
        compiler = find_compiler()
    except NativeUnavailableError as error:
        pytest.skip(str(error))
    source, library = folder / "export.c", folder / "export.so"
    source.write_text(text)
    command = [*compiler.command, *STRICT, "-O2", "-shared", "-fPIC", str(source)]
    command += ["-o", str(library), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    loaded = ctypes.CDLL(str(library))
    functions: Functions = {}
    for name in names:
        function = loaded[name]
        function.restype, function.argtypes = ctypes.c_double, [ctypes.c_double] * arguments
        functions[name] = function
    return functions


def in_python(text: str, *names: str) -> Functions:
    namespace: dict[str, Callable[..., float]] = {}
    exec(compile(text, "export.py", "exec"), namespace)
    return {name: namespace[name] for name in names}


def in_st(text: str, *names: str) -> Functions:
    functions = structured_text(text)
    assert [*functions] == [name.lower() for name in names]
    return dict(zip(names, functions.values(), strict=True))


def check(axis: Axis, functions: Functions, values: np.ndarray, dead_zone: float = 0.0) -> None:
    """Compare both functions with the virtual machine, at rest too."""
    force, control = functions.values()
    machine = build(axis, native=False).functions["inverse_dynamics"]
    drive, rng = axis.drive, np.random.default_rng(3)
    motion = rng.normal(size=(40, 3))
    motion[:4, 1] = (0.0, -0.0, 0.25, -0.25)
    motion[-2:, 2] = (-1e9, 1e9)
    reached = 0
    for q, dq, ddq in motion.tolist():
        direction = float(dq > dead_zone) - float(dq < -dead_zone)
        tau = float(machine(q, dq, ddq, direction, values))
        assert force(q, dq, ddq) == pytest.approx(tau, rel=1e-12, abs=1e-12)
        given = dict(
            zip((FORCE, *axis.drive.along(axis.coordinate).values()), (tau, q, dq), strict=True)
        )
        given |= {VELOCITY: dq, DIRECTION: float(np.sign(dq))}
        wanted = float(drive.inverse.subs({**given, **drive.constants}))
        wanted = drive.path.command(wanted)
        wanted = min(max(wanted, -drive.limit), drive.limit)
        reached += abs(wanted) == drive.limit
        assert control(q, dq, ddq) == pytest.approx(wanted, rel=1e-12, abs=1e-12)
    assert math.isinf(drive.limit) or reached >= 2


@pytest.mark.slow
@pytest.mark.parametrize("name", [*TRIED, "awkward"])
@pytest.mark.parametrize("dead_zone", [0.0, 0.25])
@pytest.mark.parametrize("language", ["c", "python", "st"])
def test_force_and_control_are_those_of_the_virtual_machine(
    name: str, language: str, dead_zone: float, tmp_path: Path
) -> None:
    axis = awkward() if name == "awkward" else TRIED[name]
    values = np.random.default_rng(5).uniform(0.5, 2.0, len(axis.parameters))
    export = exported(axis, values, dead_zone)
    names = export.functions
    if language == "c":
        functions = in_c(print_c99(export), tmp_path, *names)
    elif language == "python":
        functions = in_python(print_python(export), *names)
    else:
        legal = ("odd_feedforward", "odd_control") if name == "awkward" else names
        functions = in_st(print_st(export), *legal)
    check(axis, functions, values, dead_zone)


@pytest.mark.parametrize("language", ["c", "python", "st"])
def test_recorded_signals_that_are_needed_are_arguments(language: str, tmp_path: Path) -> None:
    """The pressure in the force, the supply in the drive; not the feed of the law alone."""
    axis = recorded_axis("pressure")
    supply, feed = Signal("supply", "V"), Signal("feed", "V", "held")
    law = replace(fed_law())
    axis = replace(
        axis,
        signals=(*axis.signals, feed, supply),
        control=law,
        drive=replace(axis.drive, scaled_by=supply / 24),
    )
    values = np.array([90.0, 200.0, 20.0, -600.0, 1e-3])
    export = exported(axis, values)
    assert list(export.motion) == ["q", "dq", "ddq", "pressure", "supply"]
    read = {
        "c": lambda: in_c(print_c99(export), tmp_path, *export.functions, arguments=5),
        "python": lambda: in_python(print_python(export), *export.functions),
        "st": lambda: in_st(print_st(export), *export.functions),
    }[language]
    force, control = read().values()
    wanted = 90.0 * 2.0 + 200.0 * 0.3 + 20.0 - 600.0 + 1e-3 * 6.1e5
    assert force(0.1, 0.3, 2.0, 6.1e5, 23.0) == pytest.approx(wanted, rel=1e-13)
    made = wanted / (35.0 * 23.0 / 24)
    assert control(0.1, 0.3, 2.0, 6.1e5, 23.0) == pytest.approx(made, rel=1e-13)


def as_export(force: Program) -> FeedForward:
    """A function of x and y as if it were a feed-forward."""
    builder = Builder()
    builder.output("control", [[builder.scalar("tau")]])
    return FeedForward(
        name="f",
        about=("A test.",),
        constants=(),
        motion={"x": "m", "y": "m/s"},
        force=force,
        control=builder.program("control", ""),
    )


@pytest.mark.parametrize("expression", operations(X, Y), ids=str)
def test_every_operation_has_its_value_in_structured_text(expression: sympy.Expr) -> None:
    program = program_of(expression)
    export = as_export(program)
    function = in_st(print_st(export), *export.functions)["f_feedforward"]
    points = [(0.3, -0.7), (-0.0, 0.5), (0.9, 0.9), (-3.0, 2.0)]
    found = [function(x, y) for x, y in points]
    assert found == pytest.approx(by_machine(program, points)[:, 0], rel=1e-13, abs=1e-13)


def test_nothing_is_needed_but_the_language() -> None:
    export = exported(awkward(), np.ones(7))
    c, python, st = print_c99(export), print_python(export), print_st(export)
    assert [line for line in c.splitlines() if line.startswith("#")] == ["#include <math.h>"]
    needed = [line for line in python.splitlines() if line.startswith(("import", "from"))]
    assert needed == ["import math"]
    assert "\nimport" not in print_python(exported(load_axis("emps"), np.ones(4)))
    assert all(text.isascii() for text in (c, python, st))


def test_what_is_no_number_or_no_speed_is_refused() -> None:
    model = derive(load_axis("emps"))
    numbers = {p.name: (1.0, "") for p in model.axis.parameters}
    with refuses("export", says="-1"):
        feed_forward(model, numbers, dead_zone=-1.0)
    with refuses("export", says="nan"):
        feed_forward(model, numbers, dead_zone=math.nan)
    with refuses("export", says="Fv is inf"):
        feed_forward(model, {**numbers, "Fv": (math.inf, "")})


def test_a_comment_never_ends_early() -> None:
    for text in ("*/*", "(*)*)", "/*/", "**/", "??/", "a\\"):
        made = comment(text)
        assert not any(mark in made for mark in ("*/", "/*", "(*", "*)", "??", "\\"))
        assert made.replace(" ", "") == text.replace("\\", "/")

    assert comment("Pendelprüfstand, façade, 5 Ω") == "Pendelprufstand, facade, 5 ?"
