"""Whether an expression is 0 wherever it is looked at, by its values at points, to many digits.

What is made of analytic functions and is 0 at points that have nothing to do with each other is 0
everywhere. A function with a kink or a jump is another matter: it may be 0 on one side and not on
the other. Each such function counts as unknown, with a number of its own at each point.
"""

import hashlib
from collections.abc import Callable
from collections.abc import Set as AbstractSet
from typing import Any

import mpmath
import sympy
from sympy.functions.elementary.miscellaneous import Max, Min

_points = mpmath.MPContext()
_points.dps = 50
_POINTS = 3
_NOTHING = 1e-12  # share of what is added up, below which a sum is what rounding left of nothing
_ALIKE = 25  # digits in which two arguments of a kinked function are the same
_LARGEST = 2000  # binary digits before the point of what a function is evaluated of
_CANNOT = (ArithmeticError, ValueError, TypeError, RecursionError)

_ANALYTIC: dict[Any, Callable[..., Any]] = {
    sympy.exp: _points.exp,
    sympy.log: _points.log,
    sympy.sin: _points.sin,
    sympy.cos: _points.cos,
    sympy.tan: _points.tan,
    sympy.asin: _points.asin,
    sympy.acos: _points.acos,
    sympy.atan: _points.atan,
    sympy.sinh: _points.sinh,
    sympy.cosh: _points.cosh,
    sympy.tanh: _points.tanh,
}
#: What has a kink or a jump at 0, and its value there.
_STEPS: dict[Any, float] = {sympy.Abs: 0, sympy.sign: 0, sympy.Heaviside: 0.5}

_Value = tuple[Any, Any]  # a number, and the size of what was added up for it


def vanishes(expression: sympy.Expr) -> bool:
    """Whether an expression is 0; what has no finite value is not."""
    if expression == 0:
        return True
    try:
        return all(_is_nothing(_Values(turn)(expression)) for turn in range(_POINTS))
    except _CANNOT:
        return False


def depends(expression: sympy.Expr, symbols: AbstractSet[sympy.Symbol]) -> bool:
    """Whether an expression changes with symbols; what has no finite value does."""
    try:
        return any(_changes(expression, symbols, turn) for turn in range(_POINTS))
    except _CANNOT:
        return True


def _changes(expression: sympy.Expr, symbols: AbstractSet[sympy.Symbol], turn: int) -> bool:
    """Whether the value changes when the symbols do, one way or another, and nothing else."""
    here, there = _Values(turn), _Values(turn)
    for symbol in symbols:
        there.known[symbol] = here.unknown("other", str(symbol))
    (one, size), (other, more) = here(expression), there(expression)
    return not _is_nothing((one - other, size + more))


def vanishes_where(expression: sympy.Expr, inside: sympy.Expr, variable: sympy.Symbol) -> bool:
    """Whether an expression is 0 where another, affine in a variable, is 0."""
    try:
        for turn in range(_POINTS):
            start, there = _Values(turn), _Values(turn)
            start.known[variable] = (_points.zero, _points.zero)
            place = -start(inside)[0] / start(inside.diff(variable))[0]
            there.known[variable] = (place, abs(place))
            if not _is_nothing(there(expression)):
                return False
    except _CANNOT:
        return False
    return True


def _is_nothing(value: _Value) -> bool:
    number, size = value
    if not (_points.isfinite(number) and _points.isfinite(size)):
        raise ValueError("it is not finite")
    return bool(abs(number) <= _NOTHING * size)


class _Values:
    """Values at one of several points."""

    def __init__(self, turn: int) -> None:
        self.known: dict[sympy.Basic, _Value] = {}
        self._turn = turn

    def __call__(self, node: sympy.Basic) -> _Value:
        if node not in self.known:
            self.known[node] = self._value(node)
        return self.known[node]

    def _value(self, node: sympy.Basic) -> _Value:
        if node.is_Symbol:
            return self.unknown("symbol", str(node))
        if not node.args:
            return _exactly(_points.mpmathify(sympy.N(node, _points.dps)))
        inner = [self(argument) for argument in node.args]
        if node.is_Add:
            return _points.fsum(v for v, _ in inner), _points.fsum(s for _, s in inner)
        if node.is_Mul:
            return _points.fprod(v for v, _ in inner), _points.fprod(s for _, s in inner)
        if node.is_Pow:
            return _power(*inner)
        if node.func in _ANALYTIC:
            return _exactly(_ANALYTIC[node.func](_sane(inner[0][0])))
        if node.func in _STEPS:
            return self._stepped(node.func, inner[0])
        return self._opaque(node, inner)

    def _stepped(self, kind: Any, argument: _Value) -> _Value:
        if _is_nothing(argument):
            return _points.mpf(_STEPS[kind]), _points.one
        number, turned = argument[0], _points.re(argument[0]) < 0
        known, _ = self.unknown(kind.__name__, _text(-number if turned else number))
        if turned and kind is sympy.sign:
            return -known, known
        return _exactly(1 - known if turned and kind is sympy.Heaviside else known)

    def _opaque(self, node: sympy.Basic, inner: list[_Value]) -> _Value:
        numbers = [number for number, _ in inner]
        if isinstance(node, (Max, Min)):
            size = _points.fsum(s for _, s in inner)
            if all(_is_nothing((number - numbers[0], size)) for number in numbers):
                return inner[0]
            return self.unknown(type(node).__name__, *sorted(set(map(_text, numbers))))
        return self.unknown(type(node).__name__, *map(_text, numbers))

    def unknown(self, *about: str) -> _Value:
        """A number of its own for what has a name, between 1/2 and 3/2."""
        text = "\n".join((str(self._turn), *about))
        digest = hashlib.sha256(text.encode()).digest()
        return _exactly(_points.mpf(int.from_bytes(digest, "big")) / 2 ** (8 * len(digest)) + 0.5)


def _exactly(number: Any) -> _Value:
    return number, abs(number)


def _text(number: Any) -> str:
    return str(_points.nstr(number, _ALIKE))


def _sane(number: Any) -> Any:
    if number and _points.mag(number) > _LARGEST:
        raise OverflowError("it is too large")
    return number


def _power(base: _Value, exponent: _Value) -> _Value:
    power = exponent[0]
    if base[0]:
        _sane(power * _points.mag(base[0]))
    number = _points.power(base[0], power)
    if _points.isint(power) and power > 0:
        return number, _points.power(base[1], power)
    return _exactly(number)
