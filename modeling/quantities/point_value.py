"""Evaluate expressions at points, in many digits and with an estimate of rounding errors.

Each number is computed twice. The second time the declared decimals and the terms of sums are
changed a little, as rounding would change them. A number that is not much larger than the
difference of the two counts as zero.
"""

import hashlib
import math
import operator
import random
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from itertools import combinations
from typing import Any, TypeAlias

import sympy
from mpmath.ctx_mp import MPContext
from sympy.core.relational import Relational
from sympy.functions.elementary.miscellaneous import Max, Min

from .structural_order import structural_order
from .symbols import DIRECTION

#: Numbers with many digits; SymPy's own context is not changed.
numbers = MPContext()
numbers.dps = 70
_DECIMAL = 1e-14  # relative change of decimals
_SPARE_BITS = 60  # last binary digits of a number that rounding of the terms of sums may change
_NOTHING = 30  # changes by rounding, up to which a number counts as zero
_SPREAD, _BITS = 6, 40  # powers of two over which random numbers are spread; bits that decide it
_SECANTS = 16  # largest number of steps in which an edge is searched
_ARGUMENT_DIGITS = 25  # digits of the arguments that decide the value of an unknown function
_LARGEST = 2000  # largest number of binary digits before the point in the argument of a function
_FIRST_ROUNDED = 2**53  # whole number above which floating point rounds
#: Errors that are raised if an expression has no value.
CANNOT = (ArithmeticError, TypeError, ValueError, RecursionError, MemoryError)

#: A number, and the same number as changed by rounding.
Value: TypeAlias = tuple[Any, Any]

NOTHING: Value = (numbers.zero, numbers.zero)

_ANALYTIC: dict[Any, Callable[..., Any]] = {
    getattr(sympy, name): getattr(numbers, name)
    for name in "exp log sin cos tan asin acos atan sinh cosh tanh".split()
}


#: Comparisons of conditions.
_RELATIONS: dict[Any, Callable[[Any, Any], bool]] = {
    sympy.Gt: operator.gt,
    sympy.Ge: operator.ge,
    sympy.Lt: operator.lt,
    sympy.Le: operator.le,
    sympy.Eq: operator.eq,
    sympy.Ne: operator.ne,
}


def is_nothing(value: Value) -> bool:
    """Return whether a number is 0 up to rounding: at most 30 times its change by rounding.

    Raises
    ------
    ValueError
        The number is not finite.
    """
    number, moved = value
    if not (numbers.isfinite(number) and numbers.isfinite(moved)):
        raise ValueError("it is not finite")
    return bool(abs(number) <= _NOTHING * abs(number - moved))


def rounding(seed: int) -> Callable[[Any], Any]:
    """Return a function that changes each number by a random relative error due to rounding."""
    source, share = random.Random(seed), numbers.ldexp(1, _SPARE_BITS - numbers.prec)  # noqa: S311
    return lambda number: number + number * share * source.uniform(0.5, 1.5)


def off_as_decimal(number: Fraction) -> Value:
    """Return a declared number as a value with its change by rounding.

    A fraction changes in the 14th digit, a whole number only in the last of all digits.
    """
    value = numbers.mpf(number.numerator) / number.denominator
    share = _DECIMAL if number.denominator != 1 else numbers.ldexp(1, _SPARE_BITS - numbers.prec)
    return value, value + value * share * drawn(0, "number", str(number))


def value_at(expression: sympy.Expr, point: Mapping[sympy.Symbol, Any]) -> Any:
    """Return the real value of an expression at a point.

    Raises
    ------
    ArithmeticError, ValueError, TypeError, RecursionError
        The expression has no finite real value at the point.
    """
    given = {symbol: exactly(numbers.mpmathify(x)) for symbol, x in point.items()}
    return _real(_Values(given)(expression)[0])


def float_at(expression: sympy.Expr, point: Mapping[sympy.Symbol, Any]) -> float:
    """Return the value of an expression at a point as a float; NaN if it is not finite and real."""
    try:
        value = float(value_at(expression, point))
    except CANNOT:
        return math.nan
    return value if math.isfinite(value) else math.nan


class _Values:
    """Real values of expressions at one point, each evaluated once.

    Parameters
    ----------
    given : mapping of sympy.Symbol to Value
        Numbers of the symbols.
    turn : int
        Number of the point; it decides the changes by rounding.

    Attributes
    ----------
    values : dict
        Values by expression.
    is_real : bool
        Whether all values so far are real.
    off : callable
        Function that changes a number as rounding does.
    """

    def __init__(self, given: Mapping[sympy.Symbol, Value], turn: int = 0) -> None:
        self.values: dict[sympy.Basic, Value] = dict(given)
        self._conditions: dict[sympy.Basic, bool] = {}
        self.off = rounding(turn)
        self.is_real = True

    def __call__(self, node: sympy.Basic) -> Value:
        """Return the value of an expression, and the value as changed by rounding."""
        if node not in self.values:
            value = self.values[node] = self._value(node)
            self.is_real = self.is_real and not isinstance(value[0], numbers.mpc)
        return self.values[node]

    def _value(self, node: sympy.Basic) -> Value:
        """Return the value of a node from the values of its arguments."""
        if not node.args:
            return self._symbol(node) if node.is_Symbol else self._number(node)
        if isinstance(node, sympy.Piecewise):
            return self(self._chosen(node))
        inner = [self(argument) for argument in node.args]
        if node.is_Add:
            return numbers.fsum(v for v, _ in inner), numbers.fsum(self.off(m) for _, m in inner)
        if node.is_Mul:
            return numbers.fprod(v for v, _ in inner), numbers.fprod(m for _, m in inner)
        if node.is_Pow:
            exponents = exactly(inner[1][0]) if node.exp.is_Float else inner[1]
            return _power(inner[0][0], exponents[0]), _power(inner[0][1], exponents[1])
        if node.func in _ANALYTIC:
            return _both(lambda x: _ANALYTIC[node.func](_sane(x)), inner[0])
        if isinstance(node, (Max, Min)):
            wanted = 1 if isinstance(node, Max) else -1
            return max(inner, key=lambda value: wanted * self._real(value[0]))
        if isinstance(node, (sympy.Abs, sympy.sign, sympy.Heaviside)):
            side = self._side(inner[0])
            if isinstance(node, sympy.Abs):
                return _both(lambda x: side * x, inner[0])
            return exactly(side if isinstance(node, sympy.sign) else (1 + side) / 2)
        return self._of_several(node, inner)

    def _of_several(self, node: sympy.Basic, inner: Sequence[Value]) -> Value:
        """Return the value of atan2, or of a function that is not known (see `_opaque`)."""
        if isinstance(node, sympy.atan2) and not any(numbers.im(x) for pair in inner for x in pair):
            exact, off = zip(*inner, strict=True)
            return numbers.atan2(*map(_real, exact)), numbers.atan2(*map(_real, off))
        return self._opaque(node, [number for number, _ in inner])

    def _number(self, number: sympy.Expr) -> Value:
        """Return the value of a number; decimals are changed as by rounding in the second value."""
        return _number(number, off=True)

    def _real(self, number: Any) -> Any:
        """Return a real number; refuse a complex or infinite one, unless a subclass accepts it."""
        return _real(number)

    def _side(self, value: Value) -> Any:
        """Return the sign of a real value: -1, 0 or 1."""
        return numbers.sign(_real(value[0]))

    def _symbol(self, symbol: sympy.Symbol) -> Value:
        """Refuse a symbol without a number, unless a subclass draws one."""
        raise ValueError(f"{symbol} has no value")

    def _opaque(self, node: sympy.Basic, _inner: Iterable[Any]) -> Value:
        """Refuse a function that is not known, unless a subclass draws a number for it."""
        raise TypeError(f"{type(node).__name__} has no value")

    def _chosen(self, node: sympy.Basic) -> sympy.Basic:
        """Return the expression of the first branch of a Piecewise whose condition holds."""
        for value, condition in node.args:
            if self._holds(condition):
                return value
        raise ValueError("no condition holds")

    def _holds(self, condition: sympy.Basic) -> bool:
        """Return whether a condition holds, evaluated once."""
        if condition not in self._conditions:
            self._conditions[condition] = self._is_met(condition)
        return self._conditions[condition]

    def _is_met(self, condition: sympy.Basic) -> bool:
        """Return whether a condition holds: a comparison, or a combination of conditions."""
        if isinstance(condition, Relational):
            (left, left_off), (right, right_off) = self(condition.lhs), self(condition.rhs)
            side = self._side((left - right, left_off - right_off))
            return _RELATIONS[condition.func](side, 0)
        if condition.args:
            return bool(condition.func(*map(self._holds, condition.args)))
        return bool(condition)


class DrawnPoint(_Values):
    """Values of expressions at a point at which the symbols have random numbers.

    Parameters
    ----------
    points : Points
        Source of the numbers.
    turn : int
        Number of the point; each point has other numbers.
    placed : mapping of sympy.Basic to Value
        Given numbers of symbols, or of whole expressions.
    decimals : bool
        Whether declared decimals are changed as by rounding, in the second value of each number.
    """

    def __init__(
        self,
        points: "Points",
        turn: int,
        placed: Mapping[sympy.Basic, Value] | None = None,
        *,
        decimals: bool = True,
    ) -> None:
        super().__init__({**points.given, **(placed or {})}, turn)
        self._points, self.turn, self._decimals = points, turn, decimals

    def drawn(self, *about: str) -> Any:
        """Return a random number between 1/2 and 3/2 for the named object."""
        return drawn(self.turn, *about)

    def beside(self, values: Mapping[sympy.Basic, Value]) -> "DrawnPoint":
        """Return the same point with other numbers of the symbols.

        Unknown functions keep the same numbers for the same arguments.
        """
        return DrawnPoint(self._points, self.turn, values, decimals=self._decimals)

    def again(self, *, decimals: bool) -> "DrawnPoint":
        """Return the same point with the same numbers of the symbols, and no other values yet."""
        symbols = {node: value for node, value in self.values.items() if node.is_Symbol}
        return DrawnPoint(self._points, self.turn, symbols, decimals=decimals)

    def _number(self, number: sympy.Expr) -> Value:
        """Return the value of a number; its decimals are changed only if the point does so."""
        return _number(number, off=self._decimals)

    def _symbol(self, symbol: sympy.Symbol) -> Value:
        """Return a random number for a symbol; the sign of the velocity for the direction."""
        if symbol == DIRECTION and self._points.velocity is not None:
            return exactly(self._side(self(self._points.velocity)))
        return exactly(self._points.generic(symbol, self.turn))

    def _real(self, number: Any) -> Any:
        """Return the real part, because a value that is not real here may be real elsewhere."""
        return numbers.re(number)

    def _side(self, value: Value) -> Any:
        """Return the sign of the real part of a value; 0 if the value is 0 up to rounding."""
        return numbers.zero if is_nothing(value) else numbers.sign(numbers.re(value[0]))

    def _opaque(self, node: sympy.Basic, _inner: Iterable[Any]) -> Value:
        """Return a random number for a function, the same for equal arguments."""
        return exactly(
            self.drawn(
                type(node).__name__,
                *(str(numbers.nstr(number, _ARGUMENT_DIGITS)) for number in _inner),
            )
        )


class Points:
    """Numbered points at which expressions are evaluated, independent of the symbols' names.

    Parameters
    ----------
    *expressions : sympy.Expr
        Expressions to evaluate.
    velocity : sympy.Symbol, optional
        Symbol whose sign is the friction direction.
    given : mapping of sympy.Symbol to Value, optional
        Symbols that have the same numbers at all points.

    Attributes
    ----------
    places : dict of sympy.Symbol to int
        A number for each symbol, which depends on where the symbol occurs and not on its name.
    """

    def __init__(
        self,
        *expressions: sympy.Expr,
        velocity: sympy.Symbol | None = None,
        given: Mapping[sympy.Symbol, Value] | None = None,
    ) -> None:
        self.given: Mapping[sympy.Symbol, Value] = given or {}
        self.velocity = velocity
        first = (DIRECTION,) if velocity is None else (DIRECTION, velocity)
        self.places = structural_order(expressions, first)
        if velocity is not None:
            self.places.setdefault(velocity, len(self.places))

    def generic(self, symbol: sympy.Symbol, turn: int) -> Any:
        """Return a random number of moderate size for a symbol at point `turn`.

        It is negative at every fourth point, of random sign at every fourth point, and positive at
        the others. A symbol that is declared positive always has a positive number.
        """
        about = str(self.places.setdefault(symbol, len(self.places)))
        share = drawn(turn, "symbol", about)
        bits = int(numbers.ldexp(share, _BITS))
        size = numbers.ldexp(share, bits % _SPREAD - _SPREAD // 2)
        turned = turn % 4 == 1 or (turn % 4 == 3 and bits // _SPREAD % 2)
        return -size if turned and not symbol.is_positive else size

    def at(self, turn: int, *, decimals: bool = True) -> DrawnPoint:
        """Return point number `turn`, at which all free symbols have numbers of moderate size."""
        return DrawnPoint(self, turn, decimals=decimals)


def deciding(kink: sympy.Basic) -> Iterator[sympy.Expr]:
    """Yield the expressions whose signs decide on which side of a kink a motion is.

    Parameters
    ----------
    kink : sympy.Basic
        A function with a kink or step, such as ``Abs``, ``Max`` or ``sign``, or a comparison.
    """
    arguments = list(kink.args[:1])
    if isinstance(kink, (Max, Min)):
        arguments = [a - b for a, b in combinations(kink.args, 2)]
    elif isinstance(kink, Relational):
        arguments = [kink.lhs - kink.rhs]
    for argument in arguments:
        yield from (x for x in sympy.Mul.make_args(argument) if x.free_symbols)


def zero(value: Callable[[Any], Any], start: Any) -> Any:
    """Return a zero of a function near `start`, by secants."""
    return numbers.findroot(value, (start, start + 1), maxsteps=_SECANTS, verify=False)


def _number(node: sympy.Expr, *, off: bool) -> Value:
    """Return the value of a number; a decimal is changed as by rounding if `off`."""
    return _known_number(node, off and is_decimal(node), numbers.prec)


def is_decimal(number: sympy.Expr) -> bool:
    """Return whether a number is a decimal, so that its products are rounded.

    A float that is a whole number below 2**53 does not count as a decimal.
    """
    if not number.is_Float:
        return False
    is_whole = sympy.Integer(int(number)) - number == 0
    return not (is_whole and abs(number) < _FIRST_ROUNDED)


@lru_cache(maxsize=4096)
def _known_number(node: sympy.Expr, off: bool, _digits: int) -> Value:
    """Return the value of a number, and the value as changed by rounding if `off`."""
    if node.is_Float:
        number = numbers.mpf(str(node))
        share = _DECIMAL * drawn(0, "decimal", str(node)) if off else numbers.zero
        return number, number + number * share
    if node.is_Rational:
        return exactly(numbers.mpf(node.p) / node.q)
    return exactly(numbers.mpmathify(sympy.N(node, numbers.dps)))


def _real(number: Any) -> Any:
    """Return a finite real number; raise ValueError for any other number."""
    if not numbers.isfinite(number) or numbers.im(number):
        raise ValueError("it is not real")
    return numbers.re(number)


def exactly(number: Any) -> Value:
    """Return a number as a `Value` that rounding does not change."""
    return number, number


def _both(function: Callable[[Any], Any], value: Value) -> Value:
    """Return a function of both numbers of a value."""
    return function(value[0]), function(value[1])


def drawn(turn: int, *about: str) -> Any:
    """Return a random number between 1/2 and 3/2, always the same for equal arguments.

    Parameters
    ----------
    turn : int
        Number of the point.
    *about : str
        Names of the object and of the purpose for which the number is drawn.
    """
    digest = hashlib.sha256("\n".join((str(turn), *about)).encode()).digest()
    return numbers.mpf(int.from_bytes(digest, "big")) / 2 ** (8 * len(digest)) + 0.5


def _sane(number: Any) -> Any:
    """Return the argument of a function; raise OverflowError if it is too large to evaluate."""
    if number and numbers.mag(number) > _LARGEST:
        raise OverflowError("it is too large")
    return number


def _power(base: Any, exponent: Any) -> Any:
    """Return a power of numbers; raise OverflowError if it is too large."""
    if base:
        _sane(exponent * numbers.mag(base))
    return numbers.power(base, exponent)
