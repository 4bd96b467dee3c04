"""What functions of numbers are, to many digits, as fractions: the weights of an expansion.

SymPy works such numbers out by rules of its own, which may take any time; these take none.
"""

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import sympy
from mpmath.ctx_mp import MPContext
from sympy.functions.elementary.miscellaneous import Max, Min

from axisid.support.errors import ModelError

_DIGITS = 50
_HUGE = 1200  # binary digits before the point of what no longer is a number, or of its inverse

_numbers = MPContext()
_numbers.dps = _DIGITS

#: Functions of numbers by their SymPy classes.
_KNOWN: dict[Any, Callable[..., Any]] = {
    sympy.exp: _numbers.exp,
    sympy.log: _numbers.log,
    sympy.sin: _numbers.sin,
    sympy.cos: _numbers.cos,
    sympy.tan: _numbers.tan,
    sympy.asin: _numbers.asin,
    sympy.acos: _numbers.acos,
    sympy.atan: _numbers.atan,
    sympy.atan2: _numbers.atan2,
    sympy.sinh: _numbers.sinh,
    sympy.cosh: _numbers.cosh,
    sympy.tanh: _numbers.tanh,
}
_EXACT: dict[Any, Callable[..., Fraction]] = {
    Max: lambda *x: max(x),
    Min: lambda *x: min(x),
    sympy.Abs: abs,
    sympy.sign: lambda x: Fraction((x > 0) - (x < 0)),
    sympy.Heaviside: lambda x, *_: Fraction((x > 0) + (x >= 0), 2),
}


class NotRealError(ModelError):
    """A part of an expression is no finite real number, whatever the motion."""

    code = "no-real-number"


def has_value(kind: Any) -> bool:
    """Whether `value_of` has a class of functions."""
    return kind in _KNOWN or kind in _EXACT


def value_of(kind: Any, arguments: Sequence[int | Fraction]) -> Fraction:
    """A function of numbers; exact where it can be.

    Raises
    ------
    NotRealError
        It has no finite real value.
    """
    if kind in _EXACT:
        return _EXACT[kind](*arguments)
    return _fraction(_KNOWN[kind], arguments, kind.__name__)


def power_of(base: int | Fraction, exponent: int | Fraction) -> Fraction:
    """A power of numbers; exact for a whole exponent.

    Raises
    ------
    NotRealError
        It has no finite real value.
    """
    if exponent.denominator == 1 and (base or exponent >= 0):
        digits = max(base.numerator.bit_length(), base.denominator.bit_length())
        if abs(exponent.numerator) * digits <= _HUGE:
            return Fraction(base) ** exponent.numerator
    if not base and exponent > 0:
        return Fraction(0)
    return _fraction(_numbers.power, (base, exponent), "a power")


def number_symbol(number: sympy.NumberSymbol) -> Fraction:
    """pi, and its like."""
    return _as_fraction(_numbers.mpf(str(sympy.N(number, _DIGITS))))


def _fraction(
    function: Callable[..., Any], arguments: Sequence[int | Fraction], name: str
) -> Fraction:
    numbers = [_numbers.mpf(x.numerator) / x.denominator for x in arguments]
    try:
        value = function(*numbers)
    except (ArithmeticError, ValueError):
        value = None
    if not isinstance(value, _numbers.mpf) or not _numbers.isfinite(value):
        listed = ", ".join(f"{float(x):.6g}" for x in arguments)
        raise NotRealError(f"{name} of {listed} has no finite real value.")
    if value and not -_HUGE < _numbers.mag(value) < _HUGE:
        if _numbers.mag(value) > 0:
            raise NotRealError(f"{name} of {float(arguments[0]):.6g} is too large a number.")
        return Fraction(0)
    return _as_fraction(value)


def _as_fraction(value: Any) -> Fraction:
    sign, mantissa, exponent, _ = value._mpf_
    size = Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
    return -size if sign else size
