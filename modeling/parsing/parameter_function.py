"""Functions of the parameters that a user writes, such as ``M/Fv``, with their units checked.

Text is read by a separate parser, for arithmetic and a few functions; nothing in it is run.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import sympy

from axisid.modeling.quantities import (
    Symbolic,
    Unit,
    UnitReader,
    UnitsError,
    expression,
    parse_unit,
    plain_slope,
)
from axisid.support.errors import UsageError

from .expression import read_expression
from .grammar import FUNCTIONS, NODES, ConstantValues

#: Types in which a user may give a function of parameters.
FunctionLike: TypeAlias = str | sympy.Expr | Symbolic | float


@dataclass(frozen=True, slots=True)
class ParameterFunction:
    """A function of parameters, with its unit.

    Attributes
    ----------
    expression : sympy.Expr
    unit : Unit
    parameters : tuple of sympy.Symbol
        Length p; all parameters, in the order of the values at which the function is evaluated.
    """

    expression: sympy.Expr
    unit: Unit
    parameters: tuple[sympy.Symbol, ...]

    def at(self, values: Sequence[float]) -> tuple[float, list[float], list[list[float]]]:
        """Return value, gradient (p,) and Hessian (p, p) at parameter values (p,).

        An entry that is not finite and real is NaN.
        """
        number = self._floats(values).number
        slopes = [plain_slope(self.expression, p) for p in self.parameters]
        return (
            number(self.expression),
            [number(slope) for slope in slopes],
            [[number(plain_slope(s, p)) for p in self.parameters] for s in slopes],
        )

    def value(self, values: Sequence[float]) -> float:
        """Return the value at parameter values (p,); NaN if it is not finite and real."""
        return self._floats(values).number(self.expression)

    def _floats(self, values: Sequence[float]) -> ConstantValues:
        """Return an evaluator of expressions at parameter values (p,)."""
        return ConstantValues(dict(zip(self.parameters, map(float, values), strict=True)))


def parameter_function(what: FunctionLike, units: Mapping[str, str]) -> ParameterFunction:
    """Read a function of parameters and find its unit.

    Parameters
    ----------
    what : str or SymPy expression
        The function of the parameters in `units`. Text may use ``+ - * / **``, pi and `FUNCTIONS`,
        such as sqrt.
    units : mapping of str to str
        Units of all parameters, by name.

    Raises
    ------
    UsageError
        The text cannot be read, the function contains an unknown parameter or a function that is
        not permitted, or its units do not fit.
    """
    symbols = {name: sympy.Symbol(name, real=True) for name in units}
    if isinstance(what, str):
        written = read_expression(what, symbols)
    else:
        written = expression(what, "the function")
    # Use the parameters' own symbols, and permit only operations that can be evaluated.
    unknown = sorted(str(s) for s in written.free_symbols if str(s) not in symbols)
    if unknown:
        raise UsageError(
            f"there is no parameter {', '.join(unknown)}. Use the parameters {', '.join(symbols)}."
        )
    function = written.xreplace({s: symbols[str(s)] for s in written.free_symbols})
    for node in sympy.preorder_traversal(function):
        if not (node.is_Symbol or node.is_Number or node.is_NumberSymbol or node.func in NODES):
            raise UsageError(
                f"{type(node).__name__!r} cannot be used in a function of the parameters. Use "
                f"arithmetic, pi and {', '.join(FUNCTIONS)}.",
                code="formula",
            )
    by_symbol = {symbols[name]: parse_unit(unit) for name, unit in units.items()}
    try:
        unit = UnitReader(by_symbol).unit(function)
    except UnitsError as error:
        raise UsageError(str(error), code="formula") from error
    return ParameterFunction(function, unit, tuple(symbols.values()))
