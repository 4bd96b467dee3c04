"""Numbers of a declaration: plain finite floats, whatever number type they came as; for reading."""

import math
from typing import Any

import sympy

from axisid.support.errors import ModelError, quoted

_SIMPLE, _DIGITS = 1000, 6


def settle(record: object, **values: Any) -> None:
    """Put checked values in the places of what a frozen dataclass was given."""
    for name, value in values.items():
        object.__setattr__(record, name, value)


def number(value: Any, what: str, *, finite: bool = True) -> float:
    """Return a float, or say what should have been one.

    Raises
    ------
    ModelError
        It is no number, or not finite where it must be.
    """
    try:
        result = float(value)
    except (TypeError, ValueError, OverflowError):
        result = math.nan
    if isinstance(value, (str, bytes, bool)) or math.isnan(result):
        raise ModelError(f"{what} is {quoted(value)}; give a number.", code="axis")
    if finite and math.isinf(result):
        raise ModelError(f"{what} is {quoted(value)}; give a finite number.", code="axis")
    return result


def rounded(expression: sympy.Expr) -> sympy.Expr:
    """An expression with six digits where a number is no simple fraction."""
    return expression.xreplace(
        {
            x: sympy.Float(x, _DIGITS)
            for x in expression.atoms(sympy.Rational)
            if max(abs(x.p), x.q) >= _SIMPLE
        }
    )
