"""SymPy expressions mean the same after lowering, printing and running."""

from collections.abc import Sequence

import numpy as np
import pytest
import sympy

from axisid.codegen.lowering.expressions import Lowering
from axisid.codegen.lowering.program import Builder, Program, evaluate
from axisid.codegen.printers.python import print_function
from axisid.codegen.runtime.casadi_functions import execute
from axisid.support.arrays import Array
from tests.refusals import refused
from tests.strategies.expressions import operations

X, Y = sympy.symbols("x y", real=True)


def program_of(*results: sympy.Basic) -> Program:
    builder = Builder()
    values = {X: builder.scalar("x"), Y: builder.scalar("y")}
    lowering = Lowering(builder, values)
    builder.output("result", [[lowering(e) for e in results]])
    return builder.program("f", "A test.")


def by_machine(program: Program, points: Sequence[tuple[float, float]]) -> Array:
    """Values of the emitted text in the CasADi virtual machine, (points, results)."""
    text = f'import casadi\n\n\n{print_function(program)}\n\nFUNCTIONS = {{"f": f}}\n'
    function = execute(text, "test")["f"]
    return np.array([function(*point).full().ravel() for point in points])


@pytest.mark.parametrize("number", [2 * sympy.sqrt(2), 3 * sympy.sqrt(6) / 2, sympy.root(4, 3)])
def test_numbers_that_sympy_writes_as_products_of_powers_are_lowered(number: sympy.Expr) -> None:
    """Their powers joined are the same product again."""
    ((alone, scaled),) = by_machine(program_of(number, number * X), [(3.0, 0.0)])
    assert alone == pytest.approx(float(number), rel=1e-15)
    assert scaled == pytest.approx(3.0 * float(number), rel=1e-15)


def test_common_subexpressions_are_computed_once() -> None:
    shared = sympy.sin(X * Y)
    assert program_of(shared, shared + 1).operation_count == 3


@pytest.mark.parametrize("x", [-1.0, 0.0, 2.0])
def test_the_derivative_of_a_power_is_finite_where_its_base_is_zero(x: float) -> None:
    hinge = sympy.Max(0, X)
    ((value,),) = by_machine(program_of(3 * hinge**Y / hinge), [(x, 2.5)])
    assert value == pytest.approx(3 * max(x, 0.0) ** 1.5, rel=1e-15)


test_what_cannot_be_lowered_or_written_is_named = refused(
    [
        ("generated-code", "gamma", lambda: program_of(sympy.gamma(X))),
        ("generated-code", "", lambda: program_of(sympy.Piecewise((X, X < 1)))),
        (
            "generated-code",
            "symbol z has no value",
            lambda: program_of(sympy.Symbol("z", real=True)),
        ),
        *(
            ("not-finite", "", lambda value=value: Builder().constant(value))
            for value in (float("inf"), float("-inf"), float("nan"))
        ),
    ]
)


@pytest.mark.parametrize("expression", operations(X, Y), ids=str)
def test_every_operation_has_the_value_of_the_virtual_machine(expression: sympy.Expr) -> None:
    program = program_of(expression, X)
    points = [(0.3, -0.7), (-0.0, 0.5), (0.9, 0.9), (-3.0, 2.0)]
    x, y = np.array(points).T
    (found,) = evaluate(program, {"x": x, "y": y}).values()
    assert found == pytest.approx(by_machine(program, points), rel=1e-14, abs=1e-300)


def test_what_has_no_value_is_none_without_a_warning() -> None:
    program = program_of(1 / X, sympy.log(X), sympy.sqrt(X), X**Y, sympy.exp(X))
    (found,) = evaluate(program, {"x": np.array([0.0, -8.0, 1e9]), "y": np.full(3, 1 / 3)}).values()
    assert np.array_equal(found[0], [np.inf, -np.inf, 0, 0, 1])
    assert np.array_equal(np.isnan(found[1]), [False, True, True, True, False])
    assert found[2, 4] == np.inf
