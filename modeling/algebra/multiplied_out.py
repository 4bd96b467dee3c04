"""SymPy's sums of products, where they are few enough to be written down."""

import math

import sympy

_MOST_TERMS = 500


def multiplied_out(value: sympy.Expr, *, powers: bool = True) -> sympy.Expr:
    """An expression as a sum of products, or as it is where it may have too many of them.

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
    """Bound on the terms of an expression, or of one in it; it stops at one more than allowed."""
    most, parts = _MOST_TERMS + 1, [_terms(argument) for argument in value.args]
    if value.is_Add:
        return min(sum(parts), most)
    if value.is_Mul:
        return min(math.prod(parts), most)
    if value.is_Pow and parts[0] > 1 and value.exp.is_Number:
        times = math.ceil(abs(value.exp))
        return min(math.comb(parts[0] + times - 1, times), most)
    return max(parts, default=1)
