"""SymPy expressions mean the same after lowering, printing and running."""

import math

import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from axisid.codegen.execute import execute
from axisid.codegen.lower import Lowering
from axisid.codegen.print_casadi import print_function
from axisid.codegen.program import Builder, Program
from axisid.modeling import ModelError
from tests.strategies.expressions import expressions

X, Y = sympy.symbols("x y", real=True)
VALUES = st.one_of(
    st.sampled_from([0.0, -0.0, 1.0, -1.0, 1e-12, 30.0]), st.floats(-5, 5, allow_nan=False)
)


def program_of(*results: sympy.Basic) -> Program:
    builder = Builder()
    values = {X: builder.scalar("x"), Y: builder.scalar("y")}
    lowering = Lowering(builder, values)
    builder.output("result", [[lowering(e) for e in results]])
    return builder.program("f", "A test.")


def run_program(program: Program, x: float, y: float) -> list[float]:
    text = f'import casadi\n\n\n{print_function(program)}\n\nFUNCTIONS = {{"f": f}}\n'
    return [float(v) for v in execute(text, "test")["f"](x, y).full().ravel()]


@settings(max_examples=300)
@given(expression=expressions((X, Y)), x=VALUES, y=VALUES)
def test_generated_text_has_the_value_of_the_expression(
    expression: sympy.Expr, x: float, y: float
) -> None:
    exact = sympy.Rational(x), sympy.Rational(y)
    expected = expression.subs({X: exact[0], Y: exact[1]}, simultaneous=True).evalf(30)
    if not (expected.is_number and expected.is_finite):
        return
    (value,) = run_program(program_of(expression), x, y)
    near_jump = expression.has(sympy.sign, sympy.Piecewise)
    if near_jump and not math.isclose(value, float(expected), rel_tol=1e-9, abs_tol=1e-9):
        # A jump may be decided by the last bit of its argument; neighbours must then agree.
        shifted = [
            float(expression.subs({X: exact[0] + d, Y: exact[1] + e}).evalf(30))
            for d in (-1e-9, 0, 1e-9)
            for e in (-1e-9, 0, 1e-9)
        ]
        assert any(math.isclose(value, s, rel_tol=1e-6, abs_tol=1e-6) for s in shifted)
        return
    assert value == pytest.approx(float(expected), rel=1e-9, abs=1e-9)


def test_common_subexpressions_are_computed_once() -> None:
    shared = sympy.sin(X * Y)
    assert program_of(shared, shared + 1).operation_count == 3


def test_operations_that_no_output_needs_are_left_out() -> None:
    builder = Builder()
    x = builder.scalar("x")
    builder.apply("sin", x)
    builder.output("result", [[x]])
    assert builder.program("f", "").operation_count == 0


@pytest.mark.parametrize("expression", [X - Y, -X, X / Y, -X / Y, X - (Y - X), X**-2, X * 2 / 3])
def test_signs_and_quotients_survive_printing(expression: sympy.Expr) -> None:
    (value,) = run_program(program_of(expression), 1.75, -0.3)
    assert value == pytest.approx(float(expression.subs({X: 1.75, Y: -0.3})), rel=1e-15)


def test_unknown_node_is_named() -> None:
    with pytest.raises(ModelError, match="node gamma"):
        program_of(sympy.gamma(X))


def test_partial_piecewise_is_refused() -> None:
    with pytest.raises(ModelError, match="undefined in places"):
        program_of(sympy.Piecewise((X, X < 1)))


def test_unbound_symbol_is_named() -> None:
    with pytest.raises(ModelError, match="symbol z has no value"):
        program_of(sympy.Symbol("z", real=True))


def test_wrong_operand_count_is_an_internal_fault() -> None:
    with pytest.raises(TypeError, match="takes 2 operands"):
        Builder().apply("add", 0)
