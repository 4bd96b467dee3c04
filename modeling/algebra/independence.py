"""Whether an expression depends on a symbol, proved without rewriting what the user wrote.

Multiplying out would prove it, but what is multiplied out is no longer fit for floating point:
``(x - 2)**12`` loses all its digits near 2. So the expression is only looked at, at a few points,
and what does not depend on a symbol is taken where the symbol is 0.
"""

from collections.abc import Mapping, Set as AbstractSet

import sympy

from .point_value import depends

_INFINITE = (sympy.nan, sympy.zoo, sympy.oo, -sympy.oo)
#: Of symbols that an expression does not depend on, though it may not be finite for some of them.
_ANYWHERE = (sympy.S.Zero, sympy.S.One, sympy.Integer(2), sympy.Integer(-3))


def exact(expression: sympy.Expr) -> sympy.Expr:
    """An expression with fractions for its decimals."""
    decimals = expression.atoms(sympy.Float)
    return expression.xreplace({x: sympy.Rational(str(x)) for x in decimals})


def without(value: sympy.Expr, symbols: AbstractSet[sympy.Symbol]) -> sympy.Expr | None:
    """An expression in a form that has none of the symbols in it; None if it depends on one."""
    inside = value.free_symbols & symbols
    if not inside:
        return value
    if depends(value, inside):
        return None
    forms = (_where(value, inside, place) for place in _ANYWHERE)
    return next((form for form in forms if form is not None), None)


def where_zero(value: sympy.Expr, symbols: AbstractSet[sympy.Symbol]) -> sympy.Expr | None:
    """An expression where the symbols are 0; None if it is not finite there."""
    return _where(value, symbols, sympy.S.Zero)


def intercept(value: sympy.Expr, slopes: Mapping[sympy.Symbol, sympy.Expr]) -> sympy.Expr | None:
    """What an expression, affine in symbols with these slopes, is where they are 0.

    As (p**2 + p x)/p where p is 0, which is x + p: where that is not finite as it is written, it
    follows from another place. None if it is finite at none that was tried.
    """
    for place in _ANYWHERE:
        there = _where(value, slopes.keys(), place)
        if there is not None:
            return sympy.Add(there, *(-place * slope for slope in slopes.values()))
    return None


def _where(
    value: sympy.Expr, symbols: AbstractSet[sympy.Symbol], place: sympy.Integer
) -> sympy.Expr | None:
    there = value.xreplace(dict.fromkeys(symbols, place))
    return None if there.has(*_INFINITE) else there
