"""Whether an expression is 0 wherever it is looked at, by its values at points, to many digits.

What is made of analytic functions and is 0 at points that have nothing to do with each other is 0
everywhere. A function with a kink or a jump is another matter: it may be 0 on one side and not on
the other. Each such function counts as unknown, with a number of its own at each point.
"""

import hashlib
import math
import operator
from collections.abc import Callable, Mapping, Set as AbstractSet
from typing import Any

import sympy
from mpmath.ctx_mp import MPContext
from sympy.core.relational import Relational
from sympy.functions.elementary.miscellaneous import Max, Min

#: Numbers of many digits; SymPy's own context is left alone.
numbers = MPContext()
numbers.dps = 70
_POINTS = 3
_NOTHING = 1e-12  # share of what is added up, below which a sum is what rounding left of nothing
_ALIKE = 25  # digits in which two arguments of a kinked function are the same
_MOST_BITS = 2**14  # in which a sum is looked at again, if it has lost a term that small
_SPARE_BITS = 60  # of these, which rounding may spoil
_LARGEST = 2000  # binary digits before the point of what a function is evaluated of
#: What a value that does not exist raises.
CANNOT = (ArithmeticError, TypeError, ValueError, RecursionError, MemoryError)

_ANALYTIC: dict[Any, Callable[..., Any]] = {
    sympy.exp: numbers.exp,
    sympy.log: numbers.log,
    sympy.sin: numbers.sin,
    sympy.cos: numbers.cos,
    sympy.tan: numbers.tan,
    sympy.asin: numbers.asin,
    sympy.acos: numbers.acos,
    sympy.atan: numbers.atan,
    sympy.sinh: numbers.sinh,
    sympy.cosh: numbers.cosh,
    sympy.tanh: numbers.tanh,
}
#: What has a kink or a jump at 0, and its value there.
_STEPS: dict[Any, float] = {sympy.Abs: 0, sympy.sign: 0, sympy.Heaviside: 0.5}

_COMPARED: dict[Any, Callable[[Any, Any], bool]] = {
    sympy.StrictLessThan: operator.lt,
    sympy.LessThan: operator.le,
    sympy.StrictGreaterThan: operator.gt,
    sympy.GreaterThan: operator.ge,
    sympy.Eq: operator.eq,
    sympy.Ne: operator.ne,
}

_Value = tuple[Any, Any]  # a number, and the size of what was added up for it


def vanishes(expression: sympy.Expr) -> bool:
    """Whether an expression is 0; what has no finite value is not."""
    if expression == 0:
        return True
    try:
        return all(_is_nothing(_value_there(expression, turn)) for turn in range(_POINTS))
    except CANNOT:
        return False


def depends(expression: sympy.Expr, symbols: AbstractSet[sympy.Symbol]) -> bool:
    """Whether an expression changes with symbols; what has no finite value does."""
    try:
        return any(_changes(expression, symbols, turn) for turn in range(_POINTS))
    except CANNOT:
        return True


def _changes(expression: sympy.Expr, symbols: AbstractSet[sympy.Symbol], turn: int) -> bool:
    """Whether the value changes when the symbols do, one way or another, and nothing else."""
    (one, size), (other, more), span = _moved(expression, symbols, turn)
    if span <= numbers.prec:
        return not _is_nothing((one - other, size + more))
    # What changes may be much smaller than what it is added to: every digit counts.
    with numbers.workprec(min(numbers.prec + span, _MOST_BITS)):
        (one, size), (other, more), _ = _moved(expression, symbols, turn)
        rounding = numbers.ldexp(size + more, _SPARE_BITS - numbers.prec)
        return not abs(one - other) <= rounding  # it does where neither is finite


def _moved(
    expression: sympy.Expr, symbols: AbstractSet[sympy.Symbol], turn: int
) -> tuple[_Value, _Value, int]:
    """Values before and after the symbols change, and the span of their sums."""
    here, there = _Values(turn), _Values(turn)
    for symbol in symbols:
        there.values[symbol] = here.unknown("other", str(symbol))
    return here(expression), there(expression), max(here.span, there.span)


def vanishes_where(expression: sympy.Expr, inside: sympy.Expr, variable: sympy.Symbol) -> bool:
    """Whether an expression is 0 where another, affine in a variable, is 0."""
    try:
        for turn in range(_POINTS):
            start, there = _Values(turn), _Values(turn)
            start.values[variable] = (numbers.zero, numbers.zero)
            place = -start(inside)[0] / start(inside.diff(variable))[0]
            there.values[variable] = (place, abs(place))
            if not _is_nothing(there(expression)):
                return False
    except CANNOT:
        return False
    return True


def value_at(expression: sympy.Expr, point: Mapping[sympy.Symbol, Any]) -> Any:
    """The real value of an expression at a point.

    Raises
    ------
    ArithmeticError, ValueError, TypeError, RecursionError
        It has none.
    """
    values = _ActualValues(0)
    values.values.update({s: _exactly(numbers.mpmathify(x)) for s, x in point.items()})
    return values.real(expression)


def float_at(expression: sympy.Expr, point: Mapping[sympy.Symbol, Any]) -> float:
    """The same as a float; NaN where it has none."""
    try:
        value = float(value_at(expression, point))
    except CANNOT:
        return math.nan
    return value if math.isfinite(value) else math.nan


def _value_there(expression: sympy.Expr, turn: int) -> _Value:
    """The value at a point, in as many digits as what stands in it needs.

    At such points ``log(1 + exp(x - 3000))`` is the logarithm of 1 to any usual number of digits.
    """
    values = _Values(turn)
    found = values(expression)
    if values.span <= numbers.prec:
        return found
    with numbers.workprec(min(numbers.prec + values.span, _MOST_BITS)):
        return _Values(turn)(expression)


def _is_nothing(value: _Value) -> bool:
    number, size = value
    if not (numbers.isfinite(number) and numbers.isfinite(size)):
        raise ValueError("it is not finite")
    return bool(abs(number) <= _NOTHING * size)


class _Values:
    """Values at one of several points.

    Attributes
    ----------
    span : int
        Binary digits between the largest and the smallest term of a sum.
    """

    def __init__(self, turn: int) -> None:
        self.values: dict[sympy.Basic, _Value] = {}
        self.span = 0
        self._turn = turn

    def __call__(self, node: sympy.Basic) -> _Value:
        if node not in self.values:
            self.values[node] = self._value(node)
        return self.values[node]

    def _value(self, node: sympy.Basic) -> _Value:
        if node.is_Symbol:
            return self.unknown("symbol", str(node))
        if node in (sympy.true, sympy.false):
            return _exactly(numbers.mpf(bool(node)))
        if not node.args:
            return _exactly(numbers.mpmathify(sympy.N(node, numbers.dps)))
        inner = [self(argument) for argument in node.args]
        if node.is_Add:
            sizes = [numbers.mag(v) for v, _ in inner if v and numbers.isfinite(v)]
            self.span = max([self.span, max(sizes) - min(sizes)] if sizes else [self.span])
            return numbers.fsum(v for v, _ in inner), numbers.fsum(s for _, s in inner)
        if node.is_Mul:
            return numbers.fprod(v for v, _ in inner), numbers.fprod(s for _, s in inner)
        if node.is_Pow:
            return _power(*inner)
        if node.func in _ANALYTIC:
            return _exactly(_ANALYTIC[node.func](_sane(inner[0][0])))
        if node.func in _STEPS:
            return self._stepped(node.func, inner[0])
        return self._opaque(node, inner)

    def _stepped(self, kind: Any, argument: _Value) -> _Value:
        if _is_nothing(argument):
            return numbers.mpf(_STEPS[kind]), numbers.one
        number, turned = argument[0], numbers.re(argument[0]) < 0
        size, _ = self.unknown(kind.__name__, _text(-number if turned else number))
        if turned and kind is sympy.sign:
            return -size, size
        return _exactly(1 - size if turned and kind is sympy.Heaviside else size)

    def _opaque(self, node: sympy.Basic, inner: list[_Value]) -> _Value:
        values = [number for number, _ in inner]
        if isinstance(node, (Max, Min)):
            size = numbers.fsum(s for _, s in inner)
            if all(_is_nothing((value - values[0], size)) for value in values):
                return inner[0]
            return self.unknown(type(node).__name__, *sorted(set(map(_text, values))))
        return self.unknown(type(node).__name__, *map(_text, values))

    def unknown(self, *about: str) -> _Value:
        """A number of its own for what has a name, between 1/2 and 3/2."""
        text = "\n".join((str(self._turn), *about))
        digest = hashlib.sha256(text.encode()).digest()
        return _exactly(numbers.mpf(int.from_bytes(digest, "big")) / 2 ** (8 * len(digest)) + 0.5)


class _ActualValues(_Values):
    """Real values, where symbols have numbers; functions with kinks have the values of a side."""

    def real(self, node: sympy.Basic) -> Any:
        return _real(self(node)[0])

    def unknown(self, *about: str) -> _Value:
        raise ValueError(f"{about[-1]} has no value")

    def _value(self, node: sympy.Basic) -> _Value:
        if isinstance(node, (sympy.Piecewise, sympy.ITE)):
            return self(self._chosen(node))
        return super()._value(node)

    def _stepped(self, kind: Any, argument: _Value) -> _Value:
        number = _real(argument[0])
        if kind is sympy.Abs:
            return _exactly(abs(number))
        sign = numbers.sign(number)
        return _exactly(sign if kind is sympy.sign else (1 + sign) / 2)

    def _opaque(self, node: sympy.Basic, inner: list[_Value]) -> _Value:
        reals = [_real(number) for number, _ in inner]
        if isinstance(node, (Max, Min)):
            return _exactly(max(reals) if isinstance(node, Max) else min(reals))
        if isinstance(node, sympy.atan2):
            return _exactly(numbers.atan2(*reals))
        raise TypeError(f"{type(node).__name__} has no value")

    def _chosen(self, node: sympy.Basic) -> sympy.Basic:
        if isinstance(node, sympy.ITE):
            return node.args[1] if self._holds(node.args[0]) else node.args[2]
        for value, condition in node.args:
            if self._holds(condition):
                return value
        raise ValueError("no condition holds")

    def _holds(self, condition: sympy.Basic) -> bool:
        if condition in (sympy.true, sympy.false):
            return bool(condition)
        if isinstance(condition, Relational):
            apart = self.real(condition.lhs) - self.real(condition.rhs)
            return _COMPARED[condition.func](apart, 0)
        held = [self._holds(argument) for argument in condition.args]
        if isinstance(condition, sympy.ITE):
            return held[1] if held[0] else held[2]
        return bool(condition.func(*held))


def _real(number: Any) -> Any:
    if not numbers.isfinite(number) or numbers.im(number):
        raise ValueError("it is not real")
    return numbers.re(number)


def _exactly(number: Any) -> _Value:
    return number, abs(number)


def _text(number: Any) -> str:
    return str(numbers.nstr(number, _ALIKE))


def _sane(number: Any) -> Any:
    if number and numbers.mag(number) > _LARGEST:
        raise OverflowError("it is too large")
    return number


def _power(base: _Value, exponent: _Value) -> _Value:
    power = exponent[0]
    if base[0]:
        _sane(power * numbers.mag(base[0]))
    number = numbers.power(base[0], power)
    if numbers.isint(power) and power > 0:
        return number, numbers.power(base[1], power)
    return _exactly(number)
