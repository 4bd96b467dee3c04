"""Rewrite expressions: move a number into an exponent, multiply out, remove a symbol.

A multiplied-out form is not suitable for floating point: ``(x - 2)**12`` loses all its digits near
2. To remove a symbol on which an expression does not depend, the expression is therefore not
multiplied out: the dependence is tested at a few points, and the symbol is replaced by 0.
"""

import math
from collections.abc import Mapping, Set as AbstractSet

import sympy

from .dependences import depends

# A larger factor moves into the exponent. With a smaller factor, only values above 1e288 overflow.
_LARGEST = sympy.Float(2.0**64)


def joined_exponential(product: sympy.Mul) -> tuple[sympy.Expr, sympy.Expr] | None:
    """Return a product with its numerical factor moved into the exponent of its exponential.

    Parameters
    ----------
    product : sympy.Mul
        Such as ``1e-200 x exp(y)``.

    Returns
    -------
    tuple of two sympy.Expr, or None
        The other factors with the number's sign, and the new exponent. None if there is no
        exponential, or if the number is between 2**-64 and 2**64 in size and can stay.
    """
    number, *factors = product.args
    if not number.is_Float or number == 0 or 1 / _LARGEST <= abs(number) <= _LARGEST:
        return None
    power = next((factor for factor in factors if isinstance(factor, sympy.exp)), None)
    if power is None:
        return None
    factors.remove(power)
    sign = sympy.S.NegativeOne if number < 0 else sympy.S.One
    return sympy.Mul(sign, *factors), power.args[0] + sympy.log(abs(number))


_MOST_TERMS = 500


def multiplied_out(value: sympy.Expr, *, powers: bool = True) -> sympy.Expr:
    """Return an expression as a sum of products, or unchanged if it may have too many of them.

    Parameters
    ----------
    value : sympy.Expr
    powers : bool
        Whether powers of sums are multiplied out too.
    """
    if _terms(value) > _MOST_TERMS:
        return value
    return sympy.expand(value) if powers else sympy.expand_mul(value)


def _terms(value: sympy.Expr) -> int:
    """Return an upper bound on the number of terms of an expression multiplied out, at most 501."""
    most, parts = _MOST_TERMS + 1, [_terms(argument) for argument in value.args]
    if value.is_Add:
        return min(sum(parts), most)
    if value.is_Mul:
        return min(math.prod(parts), most)
    if value.is_Pow and parts[0] > 1 and value.exp.is_Number:
        times = math.ceil(abs(value.exp))
        return min(math.comb(parts[0] + times - 1, times), most)
    return max(parts, default=1)


_INFINITE = (sympy.nan, sympy.zoo, sympy.oo, -sympy.oo)
#: Numbers that are tried in place of symbols on which an expression does not depend; some of them
#: may make it infinite.
_ANYWHERE = (sympy.S.Zero, sympy.S.One, sympy.Integer(2), sympy.Integer(-3))


def without(value: sympy.Expr, symbols: AbstractSet[sympy.Symbol]) -> sympy.Expr | None:
    """Return an expression in a form without the given symbols.

    It is None if the expression depends on one of the symbols, or has no such form.
    """
    inside = value.free_symbols & symbols
    if not inside:
        return value
    if depends(value, inside):
        return None
    forms = (where(value, inside, place) for place in _ANYWHERE)
    return next((form for form in forms if form is not None), None)


def intercept(value: sympy.Expr, slopes: Mapping[sympy.Symbol, sympy.Expr]) -> sympy.Expr | None:
    """Return the value of an affine expression where the given symbols are 0.

    If the expression as written is not finite there, such as ``(p**2 + p x)/p``, which is
    ``x + p``, the value is extrapolated by the slopes from another number of the symbols. It is
    None if the expression is not finite at any number that is tried.

    Parameters
    ----------
    value : sympy.Expr
    slopes : mapping of sympy.Symbol to sympy.Expr
        Slope of the expression for each symbol in which it is affine.
    """
    for place in _ANYWHERE:
        there = where(value, slopes.keys(), place)
        if there is not None:
            return sympy.Add(there, *(-place * slope for slope in slopes.values()))
    return None


def where(
    value: sympy.Expr, symbols: AbstractSet[sympy.Symbol], place: sympy.Integer = sympy.S.Zero
) -> sympy.Expr | None:
    """Return an expression with the number `place` for all given symbols; None if not finite."""
    there = value.xreplace(dict.fromkeys(symbols, place))
    return None if there.has(*_INFINITE) else there
