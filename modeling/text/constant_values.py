"""Values, in floating point, of what numbers and constants alone say.

SymPy works such parts out once a constant's number is put in, to any size and in no bounded time;
a float overflows instead.
"""

import math
import operator
from collections.abc import Callable, Mapping
from typing import Any

import sympy

from axisid.modeling.algebra import CANNOT
from axisid.modeling.quantities import ConstantSymbol

#: Magnitude that a part with constants in it may have.
LARGEST = 1e100

_FLOATS: dict[Any, Callable[..., float]] = {
    sympy.Add: lambda *terms: math.fsum(terms),
    sympy.Mul: lambda *factors: math.prod(factors),
    sympy.Pow: operator.pow,
}


class ConstantValues:
    """Floats of expressions, each worked out once."""

    def __init__(
        self,
        functions: Mapping[Any, Callable[..., float]],
        known: Mapping[sympy.Expr, float] | None = None,
    ) -> None:
        """Take the functions of floats by their SymPy classes, and values of symbols."""
        self._functions = {**functions, **_FLOATS}
        self._found: dict[sympy.Expr, float | None] = dict(known or {})

    def value(self, expression: sympy.Expr) -> float | None:
        """None where something unknown is in it, NaN where it is no finite real number."""
        if expression not in self._found:
            try:
                self._found[expression] = self._worked_out(expression)
            except CANNOT:
                self._found[expression] = math.nan
        return self._found[expression]

    def fits(self, node: sympy.Expr) -> bool:
        """Whether what the constants of a sum or product make, or another node, is small enough."""
        if node.is_Symbol or not node.has(ConstantSymbol):
            return True
        parts = node.args if node.is_Add or node.is_Mul else (node,)
        values = [self.value(part) for part in parts if part.has(ConstantSymbol)]
        numbers = [value for value in values if value is not None]
        total = math.fsum if node.is_Add else math.prod
        try:
            return small(total(numbers))
        except CANNOT:
            return False

    def _worked_out(self, expression: sympy.Expr) -> float | None:
        if isinstance(expression, ConstantSymbol):
            return expression.value
        if expression.is_Number or expression.is_NumberSymbol:
            return float(expression)
        if expression.is_Symbol:
            return None
        values = [self.value(part) for part in expression.args]
        if not all(value is not None for value in values):
            return None
        if expression.func not in self._functions:
            return math.nan
        value = self._functions[expression.func](*values)
        return value if not isinstance(value, complex) and math.isfinite(value) else math.nan


def small(value: float) -> bool:
    """Whether a number is real, finite and of a size that a part of an expression may have."""
    return not isinstance(value, complex) and abs(value) <= LARGEST
