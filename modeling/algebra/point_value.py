"""Values of expressions at points, in many digits, each with how far rounding moves it.

What is made of analytic functions and is 0 at points that have nothing to do with each other is 0
everywhere. What has a kink or a jump may be 0 on one side and not on the other, and the edge may be
far away: it is looked for, and there are points on both sides of it.

Each number is worked out twice. The second time there are fewer digits, and the decimals that were
declared are off by a little: what changes as much as it is large is nothing.
"""

import contextlib
import math
import operator
from collections.abc import Callable, Iterable, Iterator, Mapping, Set as AbstractSet
from fractions import Fraction
from itertools import combinations
from random import Random
from typing import Any, TypeAlias

import sympy
from mpmath.ctx_mp import MPContext
from sympy.core.relational import Relational
from sympy.functions.elementary.miscellaneous import Max, Min

from axisid.modeling.quantities import DIRECTION

#: Numbers of many digits, and of fewer; SymPy's own context is left alone.
numbers, fewer = MPContext(), MPContext()
_SPARE_BITS = 60
numbers.prec = 235
fewer.prec = numbers.prec - _SPARE_BITS
_MORE_BITS = 2**13  # in which a sum is looked at that has lost a small term
_POINTS, _SIDES = 3, 40  # where nothing has sides, and more where something has
_DECIMAL = 1e-14  # share by which decimals are off
_NOTHING = 30  # changes by rounding, up to which a number is nothing
_SECANTS = 16  # steps in which an edge is found
_BESIDE = 1e-3  # share of a symbol's value by which it is beside
_TOLD = 25  # digits by which what a function is of is told
_LARGEST = 2000  # binary digits before the point of what a function is evaluated of
#: What a value that does not exist raises.
CANNOT = (ArithmeticError, TypeError, ValueError, RecursionError, MemoryError)

#: A number, and the same number off by rounding.
Value: TypeAlias = tuple[Any, Any]

NOTHING: Value = (numbers.zero, fewer.zero)

_KINKS = (sympy.Abs, sympy.sign, sympy.Heaviside, Max, Min, Relational)
_COMPARED: dict[Any, Callable[[Any, Any], bool]] = {
    sympy.StrictLessThan: operator.lt,
    sympy.LessThan: operator.le,
    sympy.StrictGreaterThan: operator.gt,
    sympy.GreaterThan: operator.ge,
    sympy.Eq: operator.eq,
    sympy.Ne: operator.ne,
}


def _sane(number: Any) -> Any:
    if number and numbers.mag(number) > _LARGEST:
        raise OverflowError("it is too large")
    return number


def _smooth(context: Any) -> dict[Any, Callable[..., Any]]:
    """What works nodes out in numbers of a context."""

    def power(base: Any, exponent: Any) -> Any:
        if base:
            _sane(exponent * context.mag(base))
        return context.power(base, exponent)

    def of_sane(function: Callable[[Any], Any]) -> Callable[[Any], Any]:
        return lambda x: function(_sane(x))

    names = "exp log sin cos tan asin acos atan sinh cosh tanh".split()
    return {
        sympy.Add: lambda *terms: context.fsum(terms),
        sympy.Mul: lambda *factors: context.fprod(factors),
        sympy.Pow: power,
        sympy.atan2: lambda y, x: context.atan2(_real(y), _real(x)),
        **{getattr(sympy, name): of_sane(getattr(context, name)) for name in names},
    }


_FUNCTIONS = (_smooth(numbers), _smooth(fewer))


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
    return bool(abs(number) <= _NOTHING * abs(number - numbers.convert(moved)))


def exactly(number: Any) -> Value:
    """A number that nothing but its rounding moves."""
    return numbers.mpmathify(number), fewer.mpmathify(number)


def as_decimal(number: Fraction) -> Value:
    """A declared number, which is rounded if it is not whole."""
    above, below = number.numerator, number.denominator
    share = _DECIMAL * Random(str(number)).uniform(0.5, 1.5) if below != 1 else 0.0  # noqa: S311
    return numbers.mpf(above) / below, fewer.mpf(above) / below * (1 + share)


def vanishes(expression: sympy.Expr) -> bool:
    """Whether an expression is 0; what has no finite value is not."""
    if expression == 0:
        return True
    points = Points(expression)
    with points.digits(), contextlib.suppress(*CANNOT):
        return all(is_nothing(points.at(turn)(expression)) for turn in range(points.count))
    return False


def depends(expression: sympy.Expr, symbols: AbstractSet[sympy.Symbol]) -> bool:
    """Whether an expression changes with symbols; what has no finite value does."""
    return bool(dependences(expression, [symbols]))


def dependences(
    expression: sympy.Expr, groups: Iterable[AbstractSet[sympy.Symbol]]
) -> list[AbstractSet[sympy.Symbol]]:
    """Those of several groups of symbols with which an expression changes."""
    every = list(groups)
    left, points = every, Points(expression)
    with points.digits(), contextlib.suppress(*CANNOT):
        for turn in range(points.count):
            one, less = points.at(turn)(expression)
            others = [(g, points.beside(turn, g)(expression)) for g in left]
            left = [g for g, (x, y) in others if is_nothing((one - x, less - y))]
        return [group for group in every if group not in left]
    return every


def value_at(expression: sympy.Expr, point: Mapping[sympy.Symbol, Any]) -> Any:
    """The real value of an expression at a point.

    Raises
    ------
    ArithmeticError, ValueError, TypeError, RecursionError
        It has none.
    """
    given = {symbol: exactly(x) for symbol, x in point.items()}
    return _real(_Values(given)(expression)[0])


def float_at(expression: sympy.Expr, point: Mapping[sympy.Symbol, Any]) -> float:
    """The same as a float; NaN where it has none."""
    with contextlib.suppress(*CANNOT):
        value = float(value_at(expression, point))
        return value if math.isfinite(value) else math.nan
    return math.nan


class _Values:
    """Values of expressions, where symbols have numbers; at a point, others are drawn.

    Attributes
    ----------
    span : int
        Binary digits between the largest and the smallest term of a sum.
    """

    def __init__(
        self, given: Mapping[sympy.Symbol, Value], points: "Points | None" = None, turn: int = 0
    ) -> None:
        self._values: dict[sympy.Basic, Value] = dict(given)
        self._points, self._turn = points, turn
        self.span = 0

    def __call__(self, node: sympy.Basic) -> Value:
        if node not in self._values:
            self._values[node] = self._value(node)
        return self._values[node]

    def _value(self, node: sympy.Basic) -> Value:
        if not node.args:
            return self._symbol(node) if node.is_Symbol else _number(node)
        if isinstance(node, sympy.Piecewise):
            return self(self._chosen(node))
        inner = [self(argument) for argument in node.args]
        if isinstance(node, (Max, Min)):
            wanted = 1 if isinstance(node, Max) else -1
            return max(inner, key=lambda value: wanted * numbers.re(value[0]))
        if isinstance(node, (sympy.Abs, sympy.sign, sympy.Heaviside)):
            side = self._side(inner[0])
            if isinstance(node, sympy.Abs):
                return side * inner[0][0], side * inner[0][1]
            return exactly(side if isinstance(node, sympy.sign) else numbers.mpf(1 + side) / 2)
        if node.is_Pow and node.exp.is_Float:  # which is not off: a third is none of its decimals
            inner[1] = exactly(inner[1][0])
        if node.is_Add:
            sizes = [numbers.mag(v) for v, _ in inner if v and numbers.isfinite(v)]
            self.span = max([self.span, max(sizes) - min(sizes)] if sizes else [self.span])
        if node.func not in _FUNCTIONS[0]:
            return self._opaque(node, [number for number, _ in inner])
        one, other = (
            of[node.func](*part)
            for of, part in zip(_FUNCTIONS, zip(*inner, strict=True), strict=True)
        )
        return one, other

    def _side(self, value: Value) -> int:
        if self._points is not None and is_nothing(value):
            return 0
        return int(numbers.sign(numbers.re(value[0])))

    def _symbol(self, symbol: sympy.Symbol) -> Value:
        if self._points is None:
            raise ValueError(f"{symbol} has no value")
        if symbol == DIRECTION and self._points.velocity is not None:
            return exactly(self._side(self(self._points.velocity)))
        source = Random(f"{symbol.name} {self._turn}")  # noqa: S311
        size = source.uniform(0.5, 1.5) * 2.0 ** source.randint(-3, 2)
        turned = symbol in self._points.signed and source.random() < 0.5
        return exactly(-size if turned else size)

    def _opaque(self, node: sympy.Basic, inner: Iterable[Any]) -> Value:
        """A number for what is refused where code is generated of it."""
        if self._points is None:
            raise TypeError(f"{type(node).__name__} has no value")
        told = (type(node).__name__, *(numbers.nstr(number, _TOLD) for number in inner))
        return exactly(Random(" ".join(told)).uniform(0.5, 1.5))  # noqa: S311

    def _chosen(self, node: sympy.Piecewise) -> sympy.Basic:
        for value, condition in node.args:
            if self._holds(condition):
                return value
        raise ValueError("no condition holds")

    def _holds(self, condition: sympy.Basic) -> bool:
        if condition in (sympy.true, sympy.false):
            return bool(condition)
        if isinstance(condition, Relational):
            return _COMPARED[condition.func](self._side(self(condition.lhs - condition.rhs)), 0)
        held = [self._holds(argument) for argument in condition.args]
        if isinstance(condition, sympy.ITE):
            return held[1] if held[0] else held[2]
        return bool(condition.func(*held))


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
    signed : set of sympy.Symbol
        Those that are of either sign.
    """

    def __init__(
        self,
        *expressions: sympy.Expr,
        velocity: sympy.Symbol | None = None,
        given: Mapping[sympy.Symbol, Value] | None = None,
    ) -> None:
        self._given, self.velocity = given or {}, velocity
        kinks = {node for e in expressions for node in e.atoms(*_KINKS)}
        decisive = {x for node in kinks for x in _decisive(node)}
        if velocity is not None and any(DIRECTION in e.free_symbols for e in expressions):
            decisive.add(velocity)
        self.signed = {x for x in decisive if x.is_Symbol}
        self._edges = sorted(decisive - self.signed, key=sympy.default_sort_key)
        self.count = _SIDES + 4 * len(self._edges) if decisive else _POINTS
        self._made: dict[int, _Values] = {}
        self._placed: set[sympy.Symbol] = set()
        # At usual digits log(1 + exp(x - 3000)) would be the logarithm of 1, wherever it is seen.
        loses = all(self._loses(turn, expressions) for turn in range(_POINTS))
        self._more = _MORE_BITS if loses else 0
        self._made = {} if loses else self._made

    def _loses(self, turn: int, expressions: Iterable[sympy.Expr]) -> bool:
        """Whether the terms of a sum differ by more digits than there are."""
        values = self.at(turn)
        with contextlib.suppress(*CANNOT):
            for expression in expressions:
                values(expression)
        return bool(values.span > fewer.prec)

    @contextlib.contextmanager
    def digits(self) -> Iterator[None]:
        """In as many digits as what stands in the expressions needs."""
        with numbers.extraprec(self._more), fewer.extraprec(self._more):
            yield

    def look_closer(self) -> None:
        """Take twice as many digits."""
        self._more = 2 * self._more + numbers.prec
        self._made = {}

    def at(self, turn: int) -> _Values:
        """Values at one of the points."""
        if turn not in self._made:
            self._made = {turn: _Values({**self._given, **self._beside_edges(turn)}, self, turn)}
        return self._made[turn]

    def beside(self, turn: int, symbols: AbstractSet[sympy.Symbol]) -> _Values:
        """Values where some symbols are others than at a point."""
        sources = {s: Random(f"{turn} {s.name} other") for s in symbols}  # noqa: S311
        others = {s: exactly(source.uniform(0.5, 1.5)) for s, source in sources.items()}
        placed = {s: self.at(turn)(s) for s in self._placed}
        return _Values({**self._given, **placed, **others}, self, turn)

    def _beside_edges(self, turn: int) -> dict[sympy.Symbol, Value]:
        """Numbers of symbols on one side of two edges."""
        placed: dict[sympy.Symbol, Value] = {}
        source, size = Random(f"{turn} edges"), len(self._edges)  # noqa: S311
        sides = [(turn % size, 1 - 2 * (turn // size % 2))] if size else []
        for i, side in (*sides, *((source.randrange(size), source.choice((1, -1))) for _ in sides)):
            edge = self._edges[i]
            free = sorted(edge.free_symbols - self._given.keys() - placed.keys(), key=str)
            for symbol in source.sample(free, len(free)):

                def value(place: Any, *, edge: Any = edge, symbol: Any = symbol) -> Any:
                    there = {**self._given, **placed, symbol: exactly(place)}
                    return numbers.re(_Values(there, self, turn)(edge)[0])

                with contextlib.suppress(*CANNOT):
                    place = zero(value, numbers.mpf(source.uniform(0.5, 1.5)))
                    step = side * (abs(place) + 1) * _BESIDE * source.uniform(0.5, 1.5)
                    if value(place - step) * value(place + step) < 0:
                        placed[symbol] = exactly(place + step)
                        break
        self._placed = set(placed)
        return placed


def _decisive(kink: sympy.Basic) -> Iterator[sympy.Expr]:
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
        share = _DECIMAL * Random(str(node)).uniform(0.5, 1.5)  # noqa: S311
        return numbers.mpf(str(node)), fewer.mpf(str(node)) * (1 + share)
    if node.is_Rational:
        return numbers.mpf(node.p) / node.q, fewer.mpf(node.p) / node.q
    return exactly(sympy.N(node, numbers.dps))


def _real(number: Any) -> Any:
    if not numbers.isfinite(number) or numbers.im(number):
        raise ValueError("it is not real")
    return numbers.re(number)
