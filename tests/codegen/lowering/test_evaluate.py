"""Programs run as they are have the values of the virtual machine, and of C where that has none."""

import numpy as np
import pytest
import sympy

from axisid.codegen.lowering.evaluate import evaluate
from axisid.codegen.lowering.program import Builder
from tests.codegen.lowering.test_lower import X, Y, program_of, run_program
from tests.strategies.expressions import operations


@pytest.mark.parametrize("expression", operations(X, Y), ids=str)
def test_every_operation_has_the_value_of_the_virtual_machine(expression: sympy.Expr) -> None:
    program = program_of(expression, X)
    points = [(0.3, -0.7), (-0.0, 0.5), (0.9, 0.9), (-3.0, 2.0)]
    x, y = np.array(points).T
    (found,) = evaluate(program, {"x": x, "y": y}).values()
    wanted = [run_program(program, *point) for point in points]
    assert found == pytest.approx(np.array(wanted), rel=1e-14, abs=1e-300)


def test_what_has_no_value_is_none_without_a_warning() -> None:
    program = program_of(1 / X, sympy.log(X), sympy.sqrt(X), X**Y, sympy.exp(X))
    (found,) = evaluate(program, {"x": np.array([0.0, -8.0, 1e9]), "y": np.full(3, 1 / 3)}).values()
    assert np.array_equal(found[0], [np.inf, -np.inf, 0, 0, 1])
    assert np.array_equal(np.isnan(found[1]), [False, True, True, True, False])
    assert found[2, 4] == np.inf


def test_outputs_without_elements_are_empty() -> None:
    builder = Builder()
    x = builder.scalar("x")
    builder.output("some", [[x, x], [x, builder.constant(2.0)]])
    builder.output("none", [])
    found = evaluate(builder.program("f", ""), {"x": np.array([1.0, 3.0, 5.0])})
    assert found["some"].tolist() == [[1, 1, 1, 2], [3, 3, 3, 2], [5, 5, 5, 2]]
    assert found["none"].shape == (3, 0)
