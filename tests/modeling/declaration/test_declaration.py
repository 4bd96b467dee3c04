"""What a declaration refuses, and laws as sums of products of gains."""

import math
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import sympy

from axisid import (
    Coordinate,
    Parameter,
    build,
    derive,
    load_axis,
    newton,
)
from axisid.control import REFERENCE, ControlLaw, Memory
from axisid.elements import Drive, viscous
from axisid.modeling import Experiment, Move
from axisid.modeling.declaration.control import gain
from axisid.modeling.quantities.symbols import (
    MEASURED_POSITION,
)
from tests.files import text_file
from tests.refusals import refused, refuses

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


#: Names that mean something, or that text cannot carry, and what is said of them.
NAMES = [
    ("double", "keyword of C"),
    ("lambda", "keyword of Python"),
    ("null", "reserved"),
    ("parameters", "reserved"),
    ("sin", "mathematical function"),
    ("theta1", "which is reserved for the program"),
    ("pi", "the number pi in every expression"),
    ("G", "gravity in every expression"),
    ("_M", ""),
    ("M" * 32, ""),
    ("x); import os #", ""),
    ("", ""),
]


def test_a_gain_may_be_g_but_not_pi() -> None:
    def law(name: str) -> ControlLaw:
        return ControlLaw(name="p", period=1e-3, output=gain(name), gains={name: 2.0})

    assert law("G").gains == {"G": 2.0}
    with refuses("axis", says="'pi', which is the number pi"):
        law("pi")


test_what_is_not_real_is_refused = refused(
    (
        "equation",
        r"^axis 'test': .*(is not real|no finite real value)",
        lambda factor=factor: derive(declare(resistance=(Fv * factor * q.velocity,))),
    )
    for factor in [sympy.I, sympy.sqrt(-2), (-1) ** sympy.Rational(1, 3)]
)


#: Contradictory declarations, and the code of what is said of each.
CONTRADICTIONS: list[tuple[dict[str, Any], str]] = [
    ({"resistance": (sympy.Symbol("b") * q.velocity,)}, "axis"),
    ({"parameters": (M, Fv, Parameter("k", "N/m"))}, "axis"),
    ({"parameters": ()}, "axis"),
    (
        {"parameters": (M, Parameter("m", "N")), "resistance": (Parameter("m", "N").symbol,)},
        "axis",
    ),
    (
        {
            "control": ControlLaw(
                name="p",
                period=1e-3,
                output=sympy.Symbol("M", real=True),
                gains={"M": 1.0},
            )
        },
        "axis",
    ),
    ({"inertia": M * q}, "equation"),
    ({"inertia": "M"}, "formula"),
    ({"drive": 18.0}, "axis"),
    ({"coordinate": q, "parameters": ("M",)}, "axis"),
    ({"resistance": (Fv * sympy.zoo,)}, "equation"),
    ({"title": "two\nlines"}, "axis"),
    ({"columns": {"speed": "v"}}, "axis"),
    ({"experiment": Experiment(moves=(Move(1, 1, 1),), truth={"m": 1.0})}, "twin"),
]


test_names_parts_and_declarations_that_cannot_be_are_refused = refused(
    [
        *(("axis", says, partial(Parameter, name, "kg")) for name, says in NAMES),
        *((code, "", partial(declare, **changes)) for changes, code in CONTRADICTIONS),
        ("axis", "", lambda: Parameter("M", "kg", nominal=math.inf)),
        ("axis", "", lambda: Parameter("M", "kg", nominal=-1.0, lower=0.0)),
        ("units", "", lambda: Parameter("M", "furlong")),
        ("units", "", lambda: Coordinate("q", unit="mm")),
        ("axis", "", lambda: Coordinate("do")),
        ("model", "", lambda: Drive(gain=0.0)),
        ("model", "", lambda: Drive(gain=1.0, limit=-1.0)),
        ("units", "", lambda: Drive(gain=1.0, unit="bananas")),
        ("axis", "", lambda: Move(math.nan, 1.0, 1.0)),
        ("twin", "", lambda: Move(1.0, 1.0, 1.0, dwell=-0.1)),
        ("model", "", lambda: Move(1.0, 0.0, 1.0)),
        ("model", "", lambda: Experiment(moves=())),
        ("axis", "", lambda: Experiment(moves=(Move(1, 1, 1),), truth={"M": math.nan})),
        ("model", "", lambda: Experiment(moves=(Move(1, 1, 1),), seed=-1)),
        ("model", "", lambda: Move(0.1, 1e-12, 1.0)),
        ("axis", "", lambda: Coordinate("row")),
        ("axis", "", lambda: Coordinate("known")),
        ("model", "", lambda: Experiment(moves=(Move(1, 1, 1),), position_noise=-1.0)),
        ("model", "", lambda: ControlLaw(name="p", period=0.0, output=REFERENCE)),
        (
            "model",
            "",
            lambda: ControlLaw(name="p", period=1.0, output=sympy.Symbol("kp", real=True)),
        ),
        (
            "axis",
            "",
            lambda: ControlLaw(name="p", period=1.0, output=REFERENCE, gains={"kp": math.nan}),
        ),
        (
            "model",
            "",
            lambda: ControlLaw(
                name="p",
                period=1.0,
                output=REFERENCE,
                memory=(Memory("z", REFERENCE, sympy.Symbol("w", real=True)),),
            ),
        ),
        (  # divided by a gain of zero
            "generated-code",
            "",
            lambda: build(
                declare(  # type: ignore[arg-type]
                    control=ControlLaw(
                        name="p",
                        period=1.0,
                        output=REFERENCE / sympy.Symbol("T", real=True),
                        gains={"T": 0.0},
                    )
                )
            ),
        ),
    ]
)


def test_one_resistance_alone_is_a_list_of_one() -> None:
    axis = declare(resistance=viscous(Fv, q))
    assert axis == declare()


AXIS_FILE = """
from axisid import Coordinate, Parameter, newton
from axisid.elements import Drive
x = Coordinate("x")
m = Parameter("m", "kg", nominal=1.0)
mine = newton("mine", coordinate=x, parameters=(m,), inertia=m, resistance=(),
              drive=Drive(gain=1.0))
"""


def test_axis_is_found_in_a_file_whatever_its_variable(tmp_path: Path) -> None:
    file = text_file(tmp_path / "my_axis.py", AXIS_FILE)
    assert load_axis(str(file)).name == "mine"
    assert load_axis(f"{file}:mine").name == "mine"


@pytest.mark.parametrize(
    ("text", "code", "says"),
    [
        ("import nonsense_xyz\n", "axis-file", "ModuleNotFoundError at line 1"),
        ("x = 1\n\n1/0\n", "axis-file", "ZeroDivisionError at line 3"),
        ("def f(:\n", "axis-file", "SyntaxError at line 1"),
        ("x = 1\n", "axis-file", "declares no axis"),
        (
            AXIS_FILE + AXIS_FILE.replace("mine", "other"),
            "axis-file",
            "declares the axes mine, other",
        ),
        (
            "from axisid import Parameter\n\nm = Parameter('if', 'kg')\n",
            "axis-file",
            "line 3: a parameter",
        ),
        ("raise SystemExit(0)\n", "axis-file", "SystemExit"),
    ],
)
def test_bad_axis_files_are_explained(tmp_path: Path, text: str, code: str, says: str) -> None:
    file = text_file(tmp_path / "my_axis.py", text)
    with refuses(code, says):
        load_axis(str(file))


KP, KV, KI = (gain(name) for name in ("kp", "kv", "ki"))
ERROR = REFERENCE - MEASURED_POSITION


def law(output: sympy.Expr) -> ControlLaw:
    return ControlLaw(name="l", period=1e-3, output=output, gains={"kp": 2.0, "kv": 3.0, "ki": 5.0})


@pytest.mark.parametrize(
    ("output", "wanted"),
    [
        (KP * (ERROR - 2) ** 9, {KP: (ERROR - 2) ** 9}),
        (
            KP * (ERROR**3 + KV * (ERROR - 1) ** 5) + KI**2 * ERROR,
            {KP: ERROR**3, KP * KV: (ERROR - 1) ** 5, KI**2: ERROR},
        ),
        ((KP + KV) ** 2 * ERROR, {KP**2: ERROR, KP * KV: 2 * ERROR, KV**2: ERROR}),
        (KP * ERROR + (ERROR - 3) ** 7, {KP: ERROR, sympy.S.One: (ERROR - 3) ** 7}),
    ],
)
def test_signals_stay_as_they_were_written(
    output: sympy.Expr, wanted: dict[sympy.Expr, sympy.Expr]
) -> None:
    assert dict(law(output).terms) == wanted


def test_a_law_that_is_no_polynomial_in_its_gains_is_one_term() -> None:
    output = sympy.tanh(KP * ERROR) + KV * ERROR
    assert law(output).terms == ((sympy.S.One, output),)
