"""Whether an expression depends on a symbol, proved without rewriting what the user wrote.

Multiplying out proves it, but what is multiplied out is no longer fit for floating point:
``(x - 2)**12`` loses all its digits near 2. So that is only looked at, and what does not depend on
a symbol is taken where the symbol is 0.
"""

from collections.abc import Set as AbstractSet

import sympy

_INFINITE = (sympy.nan, sympy.zoo, sympy.oo, -sympy.oo)


def exact(expression: sympy.Expr) -> sympy.Expr:
    """An expression with fractions for its decimals."""
    decimals = expression.atoms(sympy.Float)
    return expression.xreplace({x: sympy.Rational(str(x)) for x in decimals})


def vanishes(value: sympy.Expr) -> bool:
    """Whether an expression is 0 once it is multiplied out."""
    return bool(value == 0 or sympy.expand(exact(value)) == 0)


def without(value: sympy.Expr, symbols: AbstractSet[sympy.Symbol]) -> sympy.Expr | None:
    """An expression in a form that has none of the symbols in it; None if it depends on one."""
    inside = value.free_symbols & symbols
    if not inside:
        return value
    expanded = sympy.expand(exact(value))
    if expanded.free_symbols & inside:
        return None
    there = where_zero(value, inside)
    return expanded if there is None else there


def where_zero(value: sympy.Expr, symbols: AbstractSet[sympy.Symbol]) -> sympy.Expr | None:
    """An expression where the symbols are 0; None if it is not finite there."""
    there = value.xreplace(dict.fromkeys(symbols, sympy.S.Zero))
    return None if there.has(*_INFINITE) else there
