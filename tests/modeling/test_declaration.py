"""What a declaration may say, and how mistakes are told."""

import math
from pathlib import Path
from typing import Any

import pytest
import sympy

from axisid import (
    MEASURED_POSITION,
    REFERENCE,
    ControlLaw,
    Coordinate,
    Drive,
    Experiment,
    Memory,
    ModelError,
    Move,
    Parameter,
    lagrange,
    load_axis,
    newton,
    viscous,
)

q = Coordinate("q")
M = Parameter("M", "kg", nominal=1.0)
Fv = Parameter("Fv", "N/(m/s)")


def declare(name: str = "test", **changes: Any) -> object:
    declaration: dict[str, Any] = {
        "coordinate": q,
        "parameters": (M, Fv),
        "inertia": M,
        "resistance": (viscous(Fv, q),),
        "drive": Drive(gain=1.0),
    }
    return newton(name, **{**declaration, **changes})


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("double", "keyword of C"),
        ("lambda", "keyword of Python"),
        ("null", "reserved"),
        ("parameters", "reserved"),
        ("sin", "mathematical function"),
        ("_M", "a letter followed by"),
        ("M" * 32, "a letter followed by"),
        ("x); import os #", "a letter followed by"),
        ("", "a letter followed by"),
    ],
)
def test_names_that_text_cannot_carry_are_refused(name: str, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        Parameter(name, "kg")


def test_names_that_differ_by_case_only_are_refused() -> None:
    small = Parameter("m", "N")
    with pytest.raises(ModelError, match="but for case"):
        declare(parameters=(M, small), resistance=(small.symbol,))


def test_parameter_named_like_the_velocity_is_refused() -> None:
    with pytest.raises(ModelError, match="same name"):
        declare(parameters=(M, Parameter("dq", "N")), resistance=(q.velocity,))


def test_gain_named_like_a_parameter_is_refused() -> None:
    law = ControlLaw(name="p", period=1e-3, output=sympy.Symbol("M", real=True), gains={"M": 1.0})
    with pytest.raises(ModelError, match="same name"):
        declare(control=law)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"resistance": (sympy.Symbol("b") * q.velocity,)}, "unknown symbols b;.*Parameter"),
        ({"parameters": (M, Fv, Parameter("k", "N/m"))}, "k are declared but do not appear"),
        ({"parameters": ()}, "unknown symbols"),
        ({"inertia": M * q}, "use lagrange|Declare the axis with lagrange"),
        ({"inertia": "M"}, "the inertia is 'M'"),
        ({"resistance": ("Fv*dq",)}, "a resistance is 'Fv\\*dq'"),
        ({"inertia": True}, "the inertia is True"),
        ({"columns": {"speed": "v"}}, "the roles are time"),
        ({"experiment": Experiment(moves=(Move(1, 1, 1),), truth={"m": 1.0})}, "truth has 'm'"),
        ({"experiment": Experiment(moves=(Move(1, 1, 1),), truth={"M": math.nan})}, "truth has"),
    ],
)
def test_contradictory_declarations_are_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        declare(**changes)


def test_axis_without_inertia_is_refused() -> None:
    with pytest.raises(ModelError, match="needs an inertia"):
        lagrange(
            "flat",
            coordinate=q,
            parameters=(Fv,),
            kinetic=0,
            dissipation=Fv * q.velocity**2,
            drive=Drive(gain=1.0),
        )


@pytest.mark.parametrize(
    "make",
    [
        lambda: Parameter("M", "kg", nominal=math.inf),
        lambda: Parameter("M", "kg", nominal=-1.0, lower=0.0),
        lambda: Parameter("M", "furlong"),
        lambda: Coordinate("q", unit="mm"),
        lambda: Coordinate("do"),
        lambda: Drive(gain=0.0),
        lambda: Drive(gain=1.0, limit=-1.0),
        lambda: Drive(gain=1.0, unit="bananas"),
        lambda: Move(math.nan, 1.0, 1.0),
        lambda: Move(1.0, 0.0, 1.0),
        lambda: Experiment(moves=()),
        lambda: Experiment(moves=(Move(1, 1, 1),), position_noise=-1.0),
        lambda: ControlLaw(name="p", period=0.0, output=REFERENCE),
        lambda: ControlLaw(name="p", period=1.0, output=sympy.Symbol("kp", real=True)),
        lambda: ControlLaw(name="p", period=1.0, output=REFERENCE, gains={"kp": math.nan}),
        lambda: ControlLaw(
            name="p", period=1.0, output=REFERENCE, memory=(Memory("z", REFERENCE, REFERENCE),)
        ),
    ],
)
def test_impossible_parts_are_refused(make: Any) -> None:
    with pytest.raises(ModelError):
        make()


def test_declarations_are_frozen() -> None:
    axis = load_axis("emps")
    with pytest.raises(AttributeError):
        axis.name = "other"  # type: ignore[misc]
    with pytest.raises(TypeError):
        axis.columns["time"] = "x"  # type: ignore[index]


def test_memory_may_be_a_plain_number() -> None:
    assert Memory("z", MEASURED_POSITION, 0).start == 0  # type: ignore[arg-type]


AXIS_FILE = """
from axisid import Coordinate, Drive, Parameter, newton
x = Coordinate("x")
m = Parameter("m", "kg", nominal=1.0)
mine = newton("mine", coordinate=x, parameters=(m,), inertia=m, resistance=(),
              drive=Drive(gain=1.0))
"""


def test_axis_is_found_in_a_file_whatever_its_variable(tmp_path: Path) -> None:
    file = tmp_path / "my_axis.py"
    file.write_text(AXIS_FILE)
    assert load_axis(str(file)).name == "mine"
    assert load_axis(f"{file}:mine").name == "mine"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("import nonsense_xyz\n", "does not import: ModuleNotFoundError at line 1"),
        ("x = 1\n\n1/0\n", "ZeroDivisionError at line 3"),
        ("def f(:\n", "SyntaxError at line 1"),
        ("x = 1\n", "declares no axis"),
        (AXIS_FILE + AXIS_FILE.replace("mine", "other"), "declares mine, other"),
        ("from axisid import Parameter\n\nm = Parameter('if', 'kg')\n", "line 3: a parameter"),
        ("raise SystemExit(0)\n", "does not import: SystemExit"),
    ],
)
def test_bad_axis_files_are_explained(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "my_axis.py"
    file.write_text(text)
    with pytest.raises(ModelError, match=message):
        load_axis(str(file))


@pytest.mark.parametrize("name", ["nosuch", "nosuch.py", "emps.txt", ""])
def test_missing_axis_is_explained(name: str) -> None:
    with pytest.raises(ModelError, match="there is no axis"):
        load_axis(name)
