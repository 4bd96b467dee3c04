"""Expressions with numbers of six digits, for reading."""

import sympy

_SIMPLE, _DIGITS = 1000, 6


def rounded(expression: sympy.Expr) -> sympy.Expr:
    """An expression with six digits where a number is no simple fraction."""
    return expression.xreplace(
        {
            x: sympy.Float(x, _DIGITS)
            for x in expression.atoms(sympy.Rational)
            if max(abs(x.p), x.q) >= _SIMPLE
        }
    )
