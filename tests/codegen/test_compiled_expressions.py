"""Random expressions mean the same compiled as in the virtual machine and in SymPy.

One compilation serves many expressions at many points, among them 0, -0, large and tiny ones.
"""

import ctypes
from pathlib import Path

import numpy as np
import pytest
import sympy
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from axisid.codegen.compiler import NativeUnavailableError, find_compiler
from axisid.codegen.execute import execute
from axisid.codegen.lower import Lowering
from axisid.codegen.print_c import print_c_function, print_c_prelude, print_c_rows
from axisid.codegen.print_casadi import print_function
from axisid.codegen.program import Builder, Program
from tests.strategies.expressions import expressions

X, Y = sympy.symbols("x y", real=True)
SPECIAL = (0.0, -0.0, 1.0, -1.0, 0.3, -2.7, 1e-12, -1e-300, 5e-324, 1e8, -1e15)
POINTS = np.array([(x, y) for x in SPECIAL for y in SPECIAL])


def _is_real(expression: sympy.Expr) -> bool:
    """Constants may fold to what is neither real nor finite."""
    folded = (sympy.I, sympy.nan, sympy.zoo, sympy.oo, -sympy.oo)
    return bool(expression.free_symbols) and not expression.has(*folded)


def program_of(chosen: list[sympy.Expr]) -> Program:
    builder = Builder()
    values = {X: builder.scalar("x"), Y: builder.scalar("y")}
    lowering = Lowering(builder, values)
    builder.output("result", [[lowering(e) for e in chosen]])
    return builder.program("chosen", "A test.")


def compiled(program: Program, folder: Path) -> np.ndarray:
    """Values at all points, (points, expressions)."""
    body = f"{print_c_function(program)}\n{print_c_rows(program)}"
    source, library = folder / "chosen.c", folder / "chosen.so"
    source.write_text(f"{print_c_prelude(body)}\n{body}")
    find_compiler().compile(source, library)
    x, y = (np.ascontiguousarray(column) for column in POINTS.T)
    out = np.empty((len(POINTS), sum(len(row) for row in program.outputs[0].rows)))
    pointer = ctypes.POINTER(ctypes.c_double)
    ctypes.CDLL(str(library)).chosen_rows(
        ctypes.c_ssize_t(len(POINTS)), *(a.ctypes.data_as(pointer) for a in (x, y, out))
    )
    return out


def by_machine(program: Program) -> np.ndarray:
    text = f'import casadi\n\n\n{print_function(program)}\n\nFUNCTIONS = {{"chosen": chosen}}\n'
    function = execute(text, "test")["chosen"]
    return np.array([function(*point).full().ravel() for point in POINTS])


@pytest.fixture(scope="module", autouse=True)
def _compiler() -> None:
    try:
        find_compiler()
    except NativeUnavailableError as error:
        pytest.skip(str(error))


@settings(
    max_examples=4,
    phases=[Phase.generate],
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
@given(chosen=st.lists(expressions((X, Y)), min_size=40, max_size=40))
def test_compiled_expressions_are_those_of_the_machine_and_of_sympy(
    tmp_path_factory: pytest.TempPathFactory, chosen: list[sympy.Expr]
) -> None:
    chosen = [expression for expression in chosen if _is_real(expression)] or [X]
    program = program_of(chosen)
    native = compiled(program, tmp_path_factory.mktemp("chosen"))
    virtual = by_machine(program)
    same = np.isclose(native, virtual, rtol=1e-12, atol=1e-300) | (
        np.isnan(native) & np.isnan(virtual)
    )
    assert np.all(same | (native == virtual)), [chosen[j] for j in np.unique(np.nonzero(~same)[1])]
    for j, expression in enumerate(chosen):
        if expression.has(sympy.sign, sympy.Piecewise):
            continue  # a jump is decided by the last bit of its argument
        for i in (0, 7, 40, 60, 100):
            x, y = (sympy.Rational(v) for v in POINTS[i])
            exact = expression.subs({X: x, Y: y}, simultaneous=True).evalf(40)
            value = native[i, j]
            # Where terms cancel, or a large angle is reduced, doubles keep few digits.
            if exact.is_number and exact.is_finite and np.abs(POINTS[i]).max() < 1e3:
                assert value == pytest.approx(float(exact), rel=1e-8, abs=1e-8)
