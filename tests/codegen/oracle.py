"""Values of expressions from mpmath, and how far double precision may be from them.

Every node gets its value in sixty digits and a bound on the error of a value in double precision,
from the errors of its arguments and its own rounding; where terms cancel or a large angle is
reduced the bound says how many digits are left. It knows nothing of the lowering but that this may
add and multiply in any order.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, TypeAlias

import sympy
from mpmath.ctx_mp import MPContext
from sympy.core.relational import Relational
from sympy.functions.elementary.miscellaneous import Max, Min

from axisid.modeling.quantities import joined_exponential

#: Numbers of sixty digits; SymPy's own context is left alone.
mp = MPContext()
mp.dps = 60
mpf = mp.mpf
Real: TypeAlias = Any  # an mpf

_ROUNDING = mpf(2) ** -51  # of one operation and of a function of the C library, with some to spare
_UNDERFLOW = mpf(10) ** -307
_OVERFLOW = mpf(10) ** 300
_MONOTONE: dict[type[sympy.Basic], Callable[..., Real]] = {
    sympy.exp: mp.exp,
    sympy.log: mp.log,
    sympy.tan: mp.tan,
    sympy.asin: mp.asin,
    sympy.acos: mp.acos,
    sympy.atan: mp.atan,
    sympy.sinh: mp.sinh,
    sympy.tanh: mp.tanh,
    sympy.cosh: mp.cosh,  # not monotone, but convex: it changes most towards an end
}
_WAVES = {sympy.sin: mp.sin, sympy.cos: mp.cos}


class UndecidedError(Exception):
    """The value lies at a jump, or beyond what a double holds."""


@dataclass(frozen=True, slots=True)
class ExactValue:
    """A value, and a bound on the error of the same in double precision."""

    exact: Real
    error: Real

    @property
    def ends(self) -> tuple[Real, Real, Real]:
        """The interval, and its middle."""
        return self.exact - self.error, self.exact, self.exact + self.error

    @property
    def sign(self) -> int:
        """Sign, if the error leaves no doubt."""
        if self.error and abs(self.exact) <= self.error:
            raise UndecidedError
        return int(mp.sign(self.exact))


class Oracle:
    """Evaluates expressions at one point; what they share is evaluated once."""

    def __init__(self, point: Mapping[sympy.Symbol, float]) -> None:
        self._values: dict[sympy.Basic, ExactValue] = {
            symbol: ExactValue(mpf(value), mpf(0)) for symbol, value in point.items()
        }

    def __call__(self, node: sympy.Basic) -> ExactValue:
        """Value and error of an expression.

        Raises
        ------
        UndecidedError
            The point is at a jump, or a value in between is too large for a double.
        """
        if node not in self._values:
            found = self._value(node)
            if abs(found.exact) + found.error > _OVERFLOW:
                raise UndecidedError
            self._values[node] = found
        return self._values[node]

    def _value(self, node: sympy.Basic) -> ExactValue:
        if node.is_Integer:
            return ExactValue(mpf(int(node)), mpf(0))
        if isinstance(node, sympy.Number | sympy.NumberSymbol):
            return _rounded(node._to_mpmath(mp.prec), mpf(0))
        if isinstance(node, sympy.Piecewise):
            return self(next(pair.expr for pair in node.args if self._holds(pair.cond)))
        joined = joined_exponential(node) if node.is_Mul else None
        operands = [self(argument) for argument in joined or node.args]
        if joined is not None:
            return _product([operands[0], _between(mp.exp, operands[1])])
        if node.is_Add:
            exact, error = sum(v.exact for v in operands), sum(v.error for v in operands)
            if len(operands) > 2:  # sums in between may be as large as all terms
                sizes = sum(abs(v.exact) + v.error for v in operands)
                return ExactValue(exact, error + len(operands) * _ROUNDING * sizes)
            return ExactValue(exact, error + _ROUNDING * (abs(exact) + error))
        if node.is_Mul:
            return _product(operands)
        return self._applied(node, *operands)

    def _applied(self, node: sympy.Basic, *operands: ExactValue) -> ExactValue:
        first = operands[0]
        if node.func in _MONOTONE:
            return _between(_MONOTONE[node.func], *operands)
        if node.func in _WAVES:
            return _rounded(_WAVES[node.func](first.exact), min(first.error, mpf(2)))
        if isinstance(node, sympy.Abs):
            return ExactValue(abs(first.exact), first.error)
        if isinstance(node, Max | Min):
            choose = max if isinstance(node, Max) else min
            return ExactValue(choose(v.exact for v in operands), max(v.error for v in operands))
        if isinstance(node, sympy.sign):
            return ExactValue(mpf(first.sign), mpf(0))
        if isinstance(node, sympy.Heaviside):
            return ExactValue(mpf(1 + first.sign) / 2, mpf(0))
        if isinstance(node, sympy.atan2):
            return self._angle(*operands)
        if node.is_Pow:
            return _power(*operands)
        raise NotImplementedError(type(node))

    def _angle(self, y: ExactValue, x: ExactValue) -> ExactValue:
        if x.ends[0] <= 0 and abs(y.exact) <= y.error:
            raise UndecidedError
        return _between(mp.atan2, y, x)

    def _holds(self, condition: sympy.Basic) -> bool:
        if condition in (sympy.true, sympy.false):
            return bool(condition)
        if isinstance(condition, Relational):
            left, right = (self(side) for side in condition.args)
            sign = ExactValue(left.exact - right.exact, left.error + right.error).sign
            return bool(condition.func(sign, 0))
        # All are evaluated, as in the generated code; one that is undecided may not matter there.
        held = [self._holds(argument) for argument in condition.args]
        if isinstance(condition, sympy.ITE):
            return held[1] if held[0] else held[2]
        return bool(condition.func(*held))


def _product(operands: Sequence[ExactValue]) -> ExactValue:
    exact = mp.fprod(v.exact for v in operands)
    largest = mp.fprod(abs(v.exact) + v.error for v in operands)
    error = largest - abs(exact) + len(operands) * (_ROUNDING * largest + _UNDERFLOW)
    return ExactValue(exact, error)


def _between(function: Callable[..., Real], *operands: ExactValue) -> ExactValue:
    """A function that changes most towards an end of each argument's interval."""
    try:
        exact = function(*(v.exact for v in operands))
        reached = [function(*ends) for ends in product(*(v.ends for v in operands))]
        return _rounded(exact, max(abs(r - exact) for r in reached))
    except (ValueError, TypeError, ZeroDivisionError) as error:  # beyond where it is defined
        raise UndecidedError from error


def _power(base: ExactValue, exponent: ExactValue) -> ExactValue:
    low, _, high = base.ends
    whole = exponent.error == 0 and mp.isint(exponent.exact)
    if (low < 0 and not whole) or (low <= 0 <= high and exponent.ends[0] < 0):
        raise UndecidedError
    value = _between(mp.power, base, exponent)
    # Small powers are repeated products.
    return ExactValue(value.exact, value.error + 3 * _ROUNDING * abs(value.exact) + 3 * _UNDERFLOW)


def _rounded(exact: Real, error: Real) -> ExactValue:
    exact = mpf(exact) if not isinstance(exact, mpf) else exact
    return ExactValue(exact, error + _ROUNDING * (abs(exact) + error) + _UNDERFLOW)
