"""Random expressions mean the same compiled, in the virtual machine, in Python and in mathematics.

One compilation serves many expressions at many points, random ones and 0, -0, large and tiny ones.
"""

import contextlib
import ctypes
from pathlib import Path

import numpy as np
import pytest
import sympy
from hypothesis import HealthCheck, Phase, given, settings, strategies as st
from numpy.typing import NDArray

from axisid.codegen.lowering.program import Program
from axisid.codegen.printers.c import print_c_function, print_c_prelude, print_c_rows
from axisid.codegen.printers.python import print_python
from axisid.codegen.printers.structured_text import print_st
from axisid.codegen.runtime.library_cache import find_compiler
from tests.codegen.lowering.test_expressions import X, Y, by_machine, program_of
from tests.codegen.lowering.test_feed_forward import as_export, in_python, in_st
from tests.codegen.oracle import Oracle, UndecidedError
from tests.strategies.expressions import FLOATS, SPECIAL, expressions, operations

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("c_compiler")]

GRID = [(x, y) for x in SPECIAL for y in SPECIAL]
Points = list[tuple[float, float]]
Array = NDArray[np.float64]


def compiled(program: Program, points: Points, folder: Path) -> Array:
    """Values of the compiled C, (points, expressions)."""
    body = f"{print_c_function(program)}\n{print_c_rows(program)}"
    source, library = folder / "chosen.c", folder / "chosen.so"
    source.write_text(f"{print_c_prelude(body)}\n{body}")
    find_compiler().compile(source, library, 120.0)
    built = ctypes.CDLL(str(library))
    x, y = np.array(points).T.copy()
    out = np.empty((len(points), sum(len(row) for row in program.outputs[0].rows)))
    pointer = ctypes.POINTER(ctypes.c_double)
    built.f_rows(ctypes.c_ssize_t(len(points)), *(a.ctypes.data_as(pointer) for a in (x, y, out)))
    return out


def by_export(language: str, chosen: list[sympy.Expr], points: Points) -> Array:
    """Values of the exported text."""
    write, read = {"python": (print_python, in_python), "st": (print_st, in_st)}[language]
    out = np.empty((len(points), len(chosen)))
    for j, expression in enumerate(chosen):
        export = as_export(program_of(expression))
        function = read(write(export), *export.functions)["f_feedforward"]
        out[:, j] = [function(*point) for point in points]
    return out


def exact(chosen: list[sympy.Expr], points: Points) -> tuple[Array, Array]:
    """Values to sixty digits and their bounds; NaN at jumps and beyond what a double holds."""
    values, errors = np.full((2, len(points), len(chosen)), np.nan)
    for i, (x, y) in enumerate(points):
        oracle = Oracle({X: x, Y: y})
        for j, expression in enumerate(chosen):
            with contextlib.suppress(UndecidedError):
                value = oracle(expression)
                values[i, j], errors[i, j] = float(value.exact), float(value.error)
    return values, errors


@settings(
    max_examples=4,
    phases=[Phase.generate],
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
@given(
    chosen=st.lists(expressions((X, Y)), min_size=40, max_size=40),
    points=st.lists(st.tuples(FLOATS, FLOATS), min_size=60, max_size=60),
)
def test_compiled_expressions_are_those_of_the_machine_of_python_and_of_mathematics(
    tmp_path_factory: pytest.TempPathFactory, chosen: list[sympy.Expr], points: Points
) -> None:
    chosen, points = [*operations(X, Y), *chosen], [*GRID, *points]
    program = program_of(*chosen)
    native = compiled(program, points, tmp_path_factory.mktemp("chosen"))
    virtual = by_machine(program, points)
    same = np.isclose(native, virtual, rtol=1e-12, atol=1e-300, equal_nan=True)
    assert np.all(same), [chosen[j] for j in np.unique(np.nonzero(~same)[1])]
    python, text = (by_export(language, chosen, points) for language in ("python", "st"))
    expected, errors = exact(chosen, points)
    # Half a thousandth of a double's spacing is lost where the exact value is read as a double.
    allowed = errors + 1e-15 * np.abs(expected)
    for values in (native, virtual, python):
        wrong = np.abs(values - expected) > allowed
        assert not np.any(wrong), [
            (chosen[j], points[i], values[i, j], expected[i, j]) for i, j in np.argwhere(wrong)
        ]
    decided = np.isfinite(expected)
    # What the standard has no function for is made of others, which lose a digit or overflow.
    plain = decided & (np.abs(points).max(axis=1) <= 30)[:, None]
    allowed += 1e-11 * (1 + np.abs(expected))
    assert np.all(np.abs(text - expected)[plain] <= allowed[plain])
    assert np.all(np.isfinite(native[decided]))
    assert np.all(np.isfinite(python[decided]))
    assert np.mean(decided) > 0.8
