"""Values of expressions at points, in many digits, each with how far rounding moves it.

What is made of analytic functions and is 0 at points that have nothing to do with each other is 0
everywhere. What has a kink or a jump may be 0 on one side and not on the other, and the edge may be
far away: it is looked for, and there are points on both sides of it.

Each number is worked out twice. The second time the decimals that were declared and the terms of
sums are off by a little, as rounding leaves them: what changes as much as it is large is nothing.
"""

import contextlib
import hashlib
import math
import random
from collections.abc import Callable, Iterable, Iterator, Mapping, Set as AbstractSet
from fractions import Fraction
from itertools import combinations
from typing import Any, TypeAlias

import sympy
from mpmath.ctx_mp import MPContext
from sympy.core.relational import Relational
from sympy.functions.elementary.miscellaneous import Max, Min

from .constants import replaced
from .symbols import DIRECTION

#: Numbers of many digits; SymPy's own context is left alone.
numbers = MPContext()
numbers.dps = 70
_POINTS, _SIDES = 3, 40  # where nothing has sides, and more where something has
_DECIMAL = 1e-14  # share by which decimals are off
_SPARE_BITS = 60  # of each number, in which the terms of sums are off
_MOST_BITS = 2**14  # in which a sum is looked at again, if it has lost a small term
_NOTHING = 30  # changes by rounding, up to which a number is nothing
_SPREAD = 5  # factors of two by which numbers in place of symbols are larger or smaller
_SECANTS = 16  # steps in which an edge is found
_BESIDE = 1e-3  # share of a symbol's value by which it is beside
_TOLD = 25  # digits by which what a function is of is told
_LARGEST = 2000  # binary digits before the point of what a function is evaluated of
#: What a value that does not exist raises.
CANNOT = (ArithmeticError, TypeError, ValueError, RecursionError, MemoryError)

#: A number, and the same number off by rounding.
Value: TypeAlias = tuple[Any, Any]

NOTHING: Value = (numbers.zero, numbers.zero)

_ANALYTIC: dict[Any, Callable[..., Any]] = {
    getattr(sympy, name): getattr(numbers, name)
    for name in "exp log sin cos tan asin acos atan sinh cosh tanh".split()
}
_KINKS = (sympy.Abs, sympy.sign, sympy.Heaviside, Max, Min, Relational)


def is_nothing(value: Value) -> bool:
    """Whether a number is what rounding left of nothing.

    Raises
    ------
    ValueError
        It is not finite.
    """
    number, moved = value
    if not (numbers.isfinite(number) and numbers.isfinite(moved)):
        raise ValueError("it is not finite")
    return bool(abs(number) <= _NOTHING * abs(number - moved))


def rounding(seed: int) -> Callable[[Any], Any]:
    """What moves numbers as rounding does, each by another share."""
    source, share = random.Random(seed), numbers.ldexp(1, _SPARE_BITS - numbers.prec)  # noqa: S311
    return lambda number: number + number * share * source.uniform(0.5, 1.5)


def off_as_decimal(number: Fraction) -> Value:
    """A declared number, which is rounded if it is not whole."""
    value = numbers.mpf(number.numerator) / number.denominator
    share = _DECIMAL if number.denominator != 1 else numbers.ldexp(1, _SPARE_BITS - numbers.prec)
    return value, value + value * share * drawn(0, "number", str(number))


def vanishes(expression: sympy.Expr) -> bool:
    """Whether an expression is 0; what has no finite value is not."""
    if expression == 0:
        return True
    try:
        points = Points(expression)
        with points.digits():
            return all(is_nothing(points.at(turn)(expression)) for turn in range(points.count))
    except CANNOT:
        return False


def depends(expression: sympy.Expr, symbols: AbstractSet[sympy.Symbol]) -> bool:
    """Whether an expression changes with symbols; what has no finite value does."""
    others = {s: sympy.Symbol(f"other {s.name}", **s.assumptions0) for s in symbols}
    return not vanishes(expression - replaced(expression, others))


def value_at(expression: sympy.Expr, point: Mapping[sympy.Symbol, Any]) -> Any:
    """The real value of an expression at a point.

    Raises
    ------
    ArithmeticError, ValueError, TypeError, RecursionError
        It has none.
    """
    given = {symbol: exactly(numbers.mpmathify(x)) for symbol, x in point.items()}
    return _real(_Values(given)(expression)[0])


def float_at(expression: sympy.Expr, point: Mapping[sympy.Symbol, Any]) -> float:
    """The same as a float; NaN where it has none."""
    try:
        value = float(value_at(expression, point))
    except CANNOT:
        return math.nan
    return value if math.isfinite(value) else math.nan


class Points:
    """Points that have nothing to do with each other, by number.

    Parameters
    ----------
    *expressions : sympy.Expr
        What is evaluated.
    velocity : sympy.Symbol, optional
        The friction direction is its sign.
    given : mapping of sympy.Symbol to Value, optional
        Symbols that have the same numbers at all points.

    Attributes
    ----------
    count : int
        How many points tell of a function whether it is 0 everywhere.
    """

    def __init__(
        self,
        *expressions: sympy.Expr,
        velocity: sympy.Symbol | None = None,
        given: Mapping[sympy.Symbol, Value] | None = None,
    ) -> None:
        self.given, self.velocity = given or {}, velocity
        kinks = {node for e in expressions for node in e.atoms(*_KINKS)}
        decisive = {x for node in kinks for x in deciding(node)}
        if velocity is not None and any(DIRECTION in e.free_symbols for e in expressions):
            decisive.add(velocity)
        self.signed = {x for x in decisive if x.is_Symbol}
        edges = decisive if self.signed != decisive else ()
        self._edges = sorted(edges, key=sympy.default_sort_key)
        self.count = _SIDES + 4 * len(edges) if decisive else _POINTS
        self._bits = numbers.prec
        self._made: dict[int, _Drawn] = {}
        with contextlib.suppress(*CANNOT):
            for expression in expressions:
                self.at(0)(expression)
        if self.at(0).span > numbers.prec:
            # At usual digits log(1 + exp(x - 3000)) would be the logarithm of 1.
            self._bits = min(numbers.prec + self.at(0).span, _MOST_BITS)
            self._made = {}

    def look_closer(self) -> None:
        """Take twice as many digits."""
        self._bits *= 2
        self._made = {}

    def digits(self) -> Any:
        """In as many digits as what stands in the expressions needs."""
        return numbers.workprec(self._bits)

    def at(self, turn: int) -> "_Drawn":
        """Values at one of the points."""
        if turn not in self._made:
            made = _Drawn(self, turn)
            size = len(self._edges)
            if size:
                made.place(self._edges[turn % size], 1 - 2 * (turn // size % 2))
                other = int(1000 * made.drawn("edge"))
                made.place(self._edges[other % size], (-1) ** other)
            self._made = {turn: made}
        return self._made[turn]


class _Values:
    """Real values, where symbols have numbers.

    Attributes
    ----------
    values : dict
        By expression.
    span : int
        Binary digits between the largest and the smallest term of a sum.
    off : callable
        Moves a number as rounding does.
    """

    def __init__(self, given: Mapping[sympy.Symbol, Value], turn: int = 0) -> None:
        self.values: dict[sympy.Basic, Value] = dict(given)
        self.span = 0
        self.off = rounding(turn)

    def __call__(self, node: sympy.Basic) -> Value:
        if node not in self.values:
            self.values[node] = self._value(node)
        return self.values[node]

    def _value(self, node: sympy.Basic) -> Value:
        if not node.args:
            return self._symbol(node) if node.is_Symbol else _number(node)
        if isinstance(node, sympy.Piecewise):
            return self(self._chosen(node))
        inner = [self(argument) for argument in node.args]
        if node.is_Add:
            sizes = [numbers.mag(v) for v, _ in inner if v and numbers.isfinite(v)]
            self.span = max([self.span, max(sizes) - min(sizes)] if sizes else [self.span])
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
        return self._opaque(node, [number for number, _ in inner])

    def _real(self, number: Any) -> Any:
        return _real(number)

    def _side(self, value: Value) -> Any:
        return numbers.sign(_real(value[0]))

    def _symbol(self, symbol: sympy.Symbol) -> Value:
        raise ValueError(f"{symbol} has no value")

    def _opaque(self, node: sympy.Basic, inner: Iterable[Any]) -> Value:
        if isinstance(node, sympy.atan2):
            return exactly(numbers.atan2(*map(_real, inner)))
        raise TypeError(f"{type(node).__name__} has no value")

    def _chosen(self, node: sympy.Basic) -> sympy.Basic:
        for value, condition in node.args:
            if self._holds(condition):
                return value
        raise ValueError("no condition holds")

    def _holds(self, condition: sympy.Basic) -> bool:
        if isinstance(condition, Relational):
            return bool(condition.func(int(self._side(self(condition.lhs - condition.rhs))), 0))
        if condition.args:
            return bool(condition.func(*map(self._holds, condition.args)))
        return bool(condition)


class _Drawn(_Values):
    """Values at a point that is drawn.

    Attributes
    ----------
    placed : dict
        Symbols that are close to an edge.
    """

    def __init__(self, points: Points, turn: int) -> None:
        super().__init__(points.given, turn)
        self.placed: dict[sympy.Symbol, Value] = {}
        self._points, self._turn = points, turn

    def drawn(self, *about: str) -> Any:
        """A number of its own for what has a name, between 1/2 and 3/2."""
        return drawn(self._turn, *about)

    def _symbol(self, symbol: sympy.Symbol) -> Value:
        if symbol == DIRECTION and self._points.velocity is not None:
            return exactly(self._side(self(self._points.velocity)))
        times = int(_SPREAD * self.drawn("size", symbol.name)) - _SPREAD
        size = numbers.ldexp(self.drawn("symbol", symbol.name), times)
        turned = symbol in self._points.signed and self.drawn("turned", symbol.name) < 1
        return exactly(-size if turned else size)

    def _real(self, number: Any) -> Any:
        return numbers.re(number)  # what is not real there may be elsewhere

    def _side(self, value: Value) -> Any:
        return numbers.zero if is_nothing(value) else numbers.sign(numbers.re(value[0]))

    def _opaque(self, node: sympy.Basic, inner: Iterable[Any]) -> Value:
        return exactly(
            self.drawn(type(node).__name__, *(str(numbers.nstr(number, _TOLD)) for number in inner))
        )

    def place(self, decisive: sympy.Expr, side: int) -> None:
        """Give a symbol a number on a side of the place where a sign changes, if there is one."""
        free = decisive.free_symbols - self._points.given.keys() - self.placed.keys()
        for symbol in sorted(free, key=lambda s: self.drawn("moved", s.name)):

            def value(place: Any, *, symbol: sympy.Symbol = symbol) -> Any:
                there = _Drawn(self._points, self._turn)
                there.values |= {**self.placed, symbol: exactly(place)}
                return numbers.re(there(decisive)[0])

            with contextlib.suppress(*CANNOT):
                place = zero(value, self.drawn("symbol", symbol.name))
                step = side * (abs(place) + 1) * _BESIDE * self.drawn("beside", symbol.name)
                if value(place - step) * value(place + step) < 0:
                    self.placed[symbol] = exactly(place + step)
                    self.values = {**self._points.given, **self.placed}
                    return


def deciding(kink: sympy.Basic) -> Iterator[sympy.Expr]:
    """Expressions whose signs decide the side of a kink."""
    arguments = list(kink.args[:1])
    if isinstance(kink, (Max, Min)):
        arguments = [a - b for a, b in combinations(kink.args, 2)]
    elif isinstance(kink, Relational):
        arguments = [kink.lhs - kink.rhs]
    for argument in arguments:
        yield from (x for x in sympy.Mul.make_args(argument) if x.free_symbols)


def zero(value: Callable[[Any], Any], start: Any) -> Any:
    """Where a function is 0, by secants."""
    return numbers.findroot(value, (start, start + 1), maxsteps=_SECANTS, verify=False)


def _number(node: sympy.Expr) -> Value:
    if node.is_Float:
        number = numbers.mpf(str(node))
        return number, number + number * _DECIMAL * drawn(0, "decimal", str(node))
    if node.is_Rational:
        return exactly(numbers.mpf(node.p) / node.q)
    return exactly(numbers.mpmathify(sympy.N(node, numbers.dps)))


def _real(number: Any) -> Any:
    if not numbers.isfinite(number) or numbers.im(number):
        raise ValueError("it is not real")
    return numbers.re(number)


def exactly(number: Any) -> Value:
    """A number that rounding does not move."""
    return number, number


def _both(function: Callable[[Any], Any], value: Value) -> Value:
    return function(value[0]), function(value[1])


def drawn(turn: int, *about: str) -> Any:
    """A number between 1/2 and 3/2, another one for each turn and name."""
    digest = hashlib.sha256("\n".join((str(turn), *about)).encode()).digest()
    return numbers.mpf(int.from_bytes(digest, "big")) / 2 ** (8 * len(digest)) + 0.5


def _sane(number: Any) -> Any:
    if number and numbers.mag(number) > _LARGEST:
        raise OverflowError("it is too large")
    return number


def _power(base: Any, exponent: Any) -> Any:
    if base:
        _sane(exponent * numbers.mag(base))
    return numbers.power(base, exponent)
