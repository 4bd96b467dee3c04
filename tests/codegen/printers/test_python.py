"""Exported Python has the values of compiled C for every number there is, and for arrays."""

import math
from itertools import product

import numpy as np
import pytest
import sympy
from numpy.typing import NDArray

from axisid import Coordinate, Parameter, load_axis
from axisid.codegen.printers.c import print_c99
from axisid.codegen.printers.python import print_python
from tests.axes.bodies import rotor
from tests.codegen.lowering.test_expressions import X, Y, by_machine, program_of
from tests.codegen.lowering.test_feed_forward import as_export, exported, in_c, in_python
from tests.strategies.expressions import operations

Array = NDArray[np.float64]

SPECIAL = (
    *(0.0, -0.0, math.nan, math.inf, -math.inf, 5e-324, -5e-324, 2.2250738585072014e-308),
    *(1.7976931348623157e308, -1.7976931348623157e308, 1.0, -1.0, 0.5, -0.5, 2.0, 3.0, -3.0),
    *(709.782712893384, 709.7827128933841, -745.2, 710.4758600739439, 710.475860073944, 1e9),
)
POWERS = [sign * 2.0**k for k in range(-1074, 1024) for sign in (1, -1)]
GRID = [
    *product(SPECIAL, SPECIAL),
    *product(POWERS[::97], SPECIAL),
    *product(SPECIAL, POWERS[::97]),
]
# What the strategies keep within where it is defined is here on its own.
BARE = [
    *(f(X) for f in (sympy.exp, sympy.log, sympy.sin, sympy.cos, sympy.tan, sympy.asin)),
    *(f(X) for f in (sympy.acos, sympy.atan, sympy.sinh, sympy.cosh, sympy.tanh, sympy.sqrt)),
    *(
        X**Y,
        X / Y,
        1 / X,
        X**-3,
        X**7,
        X**-7,
        X ** sympy.Rational(1, 3),
        X**-2.5,
        sympy.atan2(X, Y),
    ),
    *(X / (Y - Y / 3 - 2 * Y / 3 + X), sympy.exp(X) / sympy.exp(Y), sympy.exp(X) - sympy.exp(Y)),
]
CHOSEN = [*BARE, *operations(X, Y)]
# The virtual machine's sign of what is no number is none; of two zeros it may choose another.
UNLIKE = (sympy.sign, sympy.Min, sympy.Max)


def alike(a: Array, b: Array, *, zeros: bool = True) -> NDArray[np.bool_]:
    """Whether numbers are equal to the last bit but one, infinite or none where others are."""
    with np.errstate(invalid="ignore"):
        near = (a == b) | (np.abs(a - b) <= 4e-16 * np.abs(b) + 5e-324) & np.isfinite(a - b)
    near |= np.isnan(a) & np.isnan(b)
    return near & ((a != 0) | (b != 0) | (np.signbit(a) == np.signbit(b)) | (not zeros))


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> list[Array]:
    """Values of every expression at every point by the C that is exported."""
    texts, names = [], []
    for i, expression in enumerate(CHOSEN):
        export = as_export(program_of(expression))
        text = print_c99(export)
        for name in export.functions:
            text = text.replace(name, f"{name}{i}_")
        texts.append(text.replace("f_feedforward_", f"f{i}_"))
        names.append(f"{export.functions[0]}{i}_")
    lines = "\n".join(texts).splitlines()
    functions = in_c("\n".join([*lines, ""]), tmp_path_factory.mktemp("c"), *names, arguments=2)
    return [np.array([functions[name](x, y) for x, y in points()]) for name in names]


def points() -> list[tuple[float, float]]:
    return [*GRID, *((x, 0.7) for x in POWERS)]


@pytest.mark.slow
@pytest.mark.parametrize("index", range(len(CHOSEN)), ids=lambda i: str(CHOSEN[i]))
def test_python_has_the_values_of_c_for_every_size_of_number(
    compiled: list[Array], index: int
) -> None:
    program = program_of(CHOSEN[index])
    export = as_export(program)
    function = in_python(print_python(export), *export.functions)["f_feedforward"]
    tried = np.array(points())
    numbers = np.array([function(x, y) for x, y in tried.tolist()])
    wrong = ~alike(numbers, compiled[index])
    assert not np.any(wrong), (tried[wrong][:5], numbers[wrong][:5], compiled[index][wrong][:5])
    assert np.array_equal(function(*tried.T), numbers, equal_nan=True)
    virtual = by_machine(program, tried)[:, 0]
    known = (
        ~np.isnan(tried).any(axis=1) if CHOSEN[index].has(*UNLIKE) else np.full(len(tried), True)
    )
    wrong = known & ~alike(numbers, virtual, zeros=False)
    assert not np.any(wrong), (tried[wrong][:5], numbers[wrong][:5], virtual[wrong][:5])


def test_numbers_and_arrays_of_numpy_are_taken_as_they_come() -> None:
    export = exported(load_axis("emps"), np.array([95.0, 203.0, 20.0, -3.0]))
    force, control = in_python(print_python(export), *export.functions).values()
    wanted = force(0.0, 2.0, -1.0)
    assert type(wanted) is float
    for kind in (np.float64, np.float32, np.int64, np.int8, np.longdouble, int):
        made = force(kind(0), kind(2), kind(-1))
        assert type(made) is float
        assert made == wanted
    speeds = np.array([[-1.0, 0.0, 2.0], [3.0, -0.0, math.nan]])
    each = [[force(0.0, v, -1.0) for v in row] for row in speeds.tolist()]
    assert np.array_equal(force(0, speeds, np.float32(-1)), each, equal_nan=True)
    assert np.array_equal(force(np.zeros(3), [-1, 0, 2], [-1.0]), each[0])
    assert np.array_equal(control(0, speeds[0], -1), [control(0, v, -1) for v in speeds[0]])
    assert force(np.array(0.0), np.array(2), np.array(-1.0)) == wanted
    assert force(np.zeros(0), 1.0, 1.0).shape == (0,)


@pytest.mark.parametrize(
    "name", ["any", "hasattr", "numpy", "math", "number", "function", "motion"]
)
def test_a_parameter_may_bear_any_name_that_the_text_uses(name: str) -> None:
    x, F = Coordinate("a", unit="rad"), Parameter(name, "N m")
    resistance = F * sympy.exp(x.symbol) / (2 + sympy.cos(x.symbol))
    axis = rotor(resistance, coordinate=x, parameters=(F,), name="named")
    export = exported(axis, np.array([1.0, 3.0]))
    force = in_python(print_python(export), *export.functions)["named_feedforward"]
    wanted = 3 * math.exp(0.3) / (2 + math.cos(0.3)) + 2
    assert force(0.3, 0.0, 2.0) == pytest.approx(wanted, rel=1e-15)
    assert force([0.3], 0.0, 2.0) == pytest.approx([wanted], rel=1e-15)
