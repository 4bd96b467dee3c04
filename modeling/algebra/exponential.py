"""Exponentials as they were declared: SymPy takes a number out of the exponent.

It makes ``exp(-15000.0)*exp(1.5*v)`` of ``exp(1.5*v - 15000.0)``, at once and again with whatever
is made of it. The first factor is 0 in floating point, though near ``v = 10000`` the product is
not; other factors are infinite, or make the second one so. So whoever works in floating point puts
the number back.
"""

import sympy

# Beyond it the factor goes back. Where a smaller one stays, only values beyond 1e288 overflow.
_LARGEST = sympy.Float(2.0**64)


def joined_exponential(product: sympy.Mul) -> tuple[sympy.Expr, sympy.Expr] | None:
    """An exponential with the number that stands before it in its exponent.

    Parameters
    ----------
    product : sympy.Mul

    Returns
    -------
    tuple of two sympy.Expr, or None
        The other factors, with the number's sign, and the exponent; None where no exponential is
        among the factors, or none of the numbers is so large or small that it must go there.
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
