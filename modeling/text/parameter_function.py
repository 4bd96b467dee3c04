"""Functions of the parameters that a user writes: ``M/Fv``, checked in their units.

Text is read by a parser of its own, for arithmetic and a few functions; nothing in it is run.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import sympy

from axisid.modeling.quantities import (
    Symbolic,
    Unit,
    UnitReader,
    UnitsError,
    expression,
    parse_unit,
)
from axisid.support.errors import UsageError

from .constant_values import ConstantValues
from .expression import read_expression
from .grammar import Function, Grammar

#: What may be given as a function of parameters.
FunctionLike: TypeAlias = str | sympy.Expr | Symbolic | float

_LONGEST_TEXT = 500


class _Abs(sympy.Function):  # type: ignore[misc]
    """Absolute value of a real argument; SymPy's own has no plain derivative for some."""

    def fdiff(self, argindex: int = 1) -> sympy.Expr:
        """The sign."""
        del argindex
        return _Sign(self.args[0])


class _Sign(sympy.Function):  # type: ignore[misc]
    """Sign of a real argument, with no slope."""

    def fdiff(self, argindex: int = 1) -> sympy.Expr:
        """Nowhere but at zero."""
        del argindex
        return sympy.S.Zero


_FUNCTIONS = {
    "sqrt": Function(sympy.sqrt, math.sqrt),
    "abs": Function(_Abs, abs),
    "exp": Function(sympy.exp, math.exp),
    "log": Function(sympy.log, math.log),
    "sin": Function(sympy.sin, math.sin),
    "cos": Function(sympy.cos, math.cos),
    "tan": Function(sympy.tan, math.tan),
    "atan": Function(sympy.atan, math.atan),
}
_FLOATS: dict[Any, Callable[..., float]] = {
    **{function.symbolic: function.number for function in _FUNCTIONS.values()},
    _Sign: lambda x: float((x > 0) - (x < 0)),
}
#: SymPy classes of a function.
_NODES = frozenset({*_FLOATS, sympy.Add, sympy.Mul, sympy.Pow})
_GRAMMAR = Grammar(
    what="a function of the parameters",
    names="parameter",
    functions=_FUNCTIONS,
    nodes=_NODES | {sympy.Abs},
    longest=_LONGEST_TEXT,
)


@dataclass(frozen=True, slots=True)
class ParameterFunction:
    """A function of parameters.

    Attributes
    ----------
    expression : sympy.Expr
    unit : Unit
    parameters : tuple of sympy.Symbol
        Length p; those it may depend on.
    """

    expression: sympy.Expr
    unit: Unit
    parameters: tuple[sympy.Symbol, ...]

    def at(self, values: Sequence[float]) -> tuple[float, list[float], list[list[float]]]:
        """Value, gradient (p,) and Hessian (p, p); NaN where one is no finite real number."""
        number = self._numbers(values)
        slopes = [sympy.diff(self.expression, p) for p in self.parameters]
        return (
            number(self.expression),
            [number(slope) for slope in slopes],
            [[number(sympy.diff(s, p)) for p in self.parameters] for s in slopes],
        )

    def value(self, values: Sequence[float]) -> float:
        """Value for parameters (p,); NaN where it is no finite real number."""
        return self._numbers(values)(self.expression)

    def _numbers(self, values: Sequence[float]) -> Callable[[sympy.Expr], float]:
        """What works out expressions in floating point: exact it could take for ever."""
        known = dict(zip(self.parameters, map(float, values), strict=True))
        found = ConstantValues(_FLOATS, known)

        def number(expression: sympy.Expr) -> float:
            value = found.value(expression)
            return value if value is not None and math.isfinite(value) else math.nan

        return number


def parameter_function(what: FunctionLike, units: Mapping[str, str]) -> ParameterFunction:
    """Read a function of parameters and find its unit.

    Parameters
    ----------
    what : str or SymPy expression
        Of the names in `units`. Text may use + - * / ** and sqrt, abs, exp, log, sin, cos, tan,
        atan, pi.
    units : mapping of str to str
        Of the parameters.

    Raises
    ------
    UsageError
        It cannot be read, names something else, or its units do not fit.
    """
    symbols = {name: sympy.Symbol(name, real=True) for name in units}
    if isinstance(what, str):
        written = read_expression(what, symbols, _GRAMMAR)
    else:
        written = expression(what, "the function")
    unknown = sorted(str(s) for s in written.free_symbols if str(s) not in symbols)
    if unknown:
        raise UsageError(
            f"there is no parameter {', '.join(unknown)}; there are {', '.join(symbols)}."
        )
    function = written.xreplace({s: symbols[str(s)] for s in written.free_symbols})
    function = function.replace(sympy.Abs, _Abs)
    for node in sympy.preorder_traversal(function):
        if not (node.is_Symbol or node.is_Number or node.is_NumberSymbol or node.func in _NODES):
            raise UsageError(
                f"{type(node).__name__!r} cannot be used in a function of the parameters; use "
                f"arithmetic, pi and {', '.join(_FUNCTIONS)}.",
                code="formula",
            )
    by_symbol = {symbols[name]: parse_unit(unit) for name, unit in units.items()}
    try:
        unit = UnitReader(by_symbol, absolute=(_Abs,)).unit(function)
    except UnitsError as error:
        raise UsageError(str(error), code="formula") from error
    return ParameterFunction(function, unit, tuple(symbols.values()))
