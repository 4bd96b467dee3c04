"""Functions of the parameters that a user writes: ``M/Fv``, checked in their units.

Text is read by a parser of its own, for arithmetic and a few functions; nothing in it is run.
"""

import ast
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

import sympy

from .errors import UsageError
from .symbols import Symbolic, expression
from .units import Unit, parse_unit

#: What may be given as a function of parameters.
FunctionLike: TypeAlias = str | sympy.Expr | Symbolic | float

_LONGEST_TEXT = 500
_LARGEST_POWER = 20
_DEEPEST = 15
_EXACT = 10**9
_ROOT, _NEAR = 12, 1e-9
_NUMBER = parse_unit("1")

_OPERATORS: dict[type[ast.AST], Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}


class _Abs(sympy.Function):  # type: ignore[misc]
    """Absolute value of a real argument; SymPy's own has no plain derivative for some."""

    def fdiff(self, argindex: int = 1) -> sympy.Expr:
        """The sign."""
        del argindex
        return _Sign(self.args[0])


class _Sign(sympy.Function):  # type: ignore[misc]
    """Sign of a real argument, with no slope."""

    def fdiff(self, argindex: int = 1) -> sympy.Expr:
        """Nowhere but at zero."""
        del argindex
        return sympy.S.Zero


_FUNCTIONS: dict[str, Callable[[Any], Any]] = {
    "sqrt": sympy.sqrt,
    "abs": _Abs,
    "exp": sympy.exp,
    "log": sympy.log,
    "sin": sympy.sin,
    "cos": sympy.cos,
    "tan": sympy.tan,
    "atan": sympy.atan,
}
_FLOATS: dict[Any, Callable[..., float]] = {
    sympy.Add: lambda *terms: math.fsum(terms),
    sympy.Mul: lambda *factors: math.prod(factors),
    sympy.Pow: operator.pow,
    sympy.sqrt: math.sqrt,
    _Abs: abs,
    _Sign: lambda x: float((x > 0) - (x < 0)),
    sympy.exp: math.exp,
    sympy.log: math.log,
    sympy.sin: math.sin,
    sympy.cos: math.cos,
    sympy.tan: math.tan,
    sympy.atan: math.atan,
}
_CANNOT = (ArithmeticError, TypeError, ValueError, RecursionError, MemoryError)


@dataclass(frozen=True, slots=True)
class ParameterFunction:
    """A function of parameters.

    Attributes
    ----------
    expression : sympy.Expr
    unit : Unit
    parameters : tuple of sympy.Symbol
        Length p; those it may depend on.
    """

    expression: sympy.Expr
    unit: Unit
    parameters: tuple[sympy.Symbol, ...]

    def at(self, values: Sequence[float]) -> tuple[float, list[float], list[list[float]]]:
        """Value, gradient (p,) and Hessian (p, p); NaN where one is no finite real number."""
        point = self._point(values)
        slopes = [sympy.diff(self.expression, p) for p in self.parameters]
        return (
            _number(self.expression, point),
            [_number(slope, point) for slope in slopes],
            [[_number(sympy.diff(s, p), point) for p in self.parameters] for s in slopes],
        )

    def value(self, values: Sequence[float]) -> float:
        """Value for parameters (p,); NaN where it is no finite real number."""
        return _number(self.expression, self._point(values))

    def _point(self, values: Sequence[float]) -> dict[sympy.Symbol, float]:
        return dict(zip(self.parameters, map(float, values), strict=True))


def parameter_function(what: FunctionLike, units: Mapping[str, str]) -> ParameterFunction:
    """Read a function of parameters and find its unit.

    Parameters
    ----------
    what : str or SymPy expression
        Of the names in `units`. Text may use + - * / ** and sqrt, abs, exp, log, sin, cos, tan,
        atan, pi.
    units : mapping of str to str
        Of the parameters.

    Raises
    ------
    UsageError
        It cannot be read, names something else, or its units do not fit.
    """
    symbols = {name: sympy.Symbol(name, real=True) for name in units}
    written = _parsed(what, symbols) if isinstance(what, str) else expression(what, "the function")
    unknown = sorted(str(s) for s in written.free_symbols if str(s) not in symbols)
    if unknown:
        raise UsageError(_no_such(unknown, symbols))
    function = written.xreplace({s: symbols[str(s)] for s in written.free_symbols})
    function = function.replace(sympy.Abs, _Abs)
    for node in sympy.preorder_traversal(function):
        if not (node.is_Symbol or node.is_Number or node.is_NumberSymbol or node.func in _FLOATS):
            raise UsageError(_cannot_be_used(type(node).__name__))
    known = {symbols[name]: parse_unit(unit) for name, unit in units.items()}
    return ParameterFunction(function, _unit(function, known), tuple(symbols.values()))


def _number(function: sympy.Expr, point: Mapping[sympy.Symbol, float]) -> float:
    """Value in floating point: exact or longer numbers could take for ever."""
    try:
        value = _float(function, dict(point))
    except _CANNOT:
        return math.nan
    return value if math.isfinite(value) else math.nan


def _float(function: sympy.Expr, known: dict[sympy.Expr, float]) -> float:
    if function not in known:
        if function.is_Number or function.is_NumberSymbol:
            value: Any = float(function)
        else:
            value = _FLOATS[function.func](*(_float(argument, known) for argument in function.args))
        if isinstance(value, complex):
            raise ValueError("it is not real")
        known[function] = value
    return known[function]


def _no_such(names: list[str], symbols: Mapping[str, sympy.Symbol]) -> str:
    return f"there is no parameter {', '.join(names)}; there are {', '.join(symbols)}."


def _parsed(text: str, symbols: Mapping[str, sympy.Symbol]) -> sympy.Expr:
    if len(text) > _LONGEST_TEXT:
        raise UsageError(f"the function has {len(text)} characters; give {_LONGEST_TEXT} or fewer.")
    try:
        return _evaluated(ast.parse(text.strip(), mode="eval").body, symbols, _DEEPEST)
    except UsageError:
        raise
    except (SyntaxError, *_CANNOT) as error:
        raise UsageError(f"the function {text!r} cannot be read: {error}") from error


def _evaluated(node: ast.AST, symbols: Mapping[str, sympy.Symbol], depth: int) -> sympy.Expr:
    if not depth:
        raise UsageError(f"the function is nested deeper than {_DEEPEST}; write it flatter.")

    def within(inner: ast.AST) -> sympy.Expr:
        return _evaluated(inner, symbols, depth - 1)

    match node:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            small = isinstance(value, int) and abs(value) < _EXACT
            return sympy.Integer(value) if small else sympy.Float(float(value))
        case ast.Name(id="pi") if "pi" not in symbols:
            return sympy.Float(math.pi)
        case ast.Name(id=name):
            if name not in symbols:
                raise UsageError(_no_such([name], symbols))
            return symbols[name]
        case ast.UnaryOp(op=op, operand=operand) if type(op) in _OPERATORS:
            return _OPERATORS[type(op)](within(operand))
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATORS:
            return _combined(type(op), within(left), within(right))
        case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in _FUNCTIONS:
            inner, function = within(argument), _FUNCTIONS[name]
            return _folded(_FLOATS[function], inner) if inner.is_Number else function(inner)
        case _:
            raise UsageError(_cannot_be_used(ast.unparse(node)))


def _combined(operation: type[ast.AST], left: sympy.Expr, right: sympy.Expr) -> sympy.Expr:
    if left.is_Number and right.is_Number:
        return _folded(_OPERATORS[operation], left, right)
    if operation is ast.Pow and right.is_Number and abs(float(right)) > _LARGEST_POWER:
        raise UsageError(f"the power {right} is beyond {_LARGEST_POWER}.")
    return _OPERATORS[operation](left, right)


def _folded(operation: Callable[..., Any], *numbers: sympy.Expr) -> sympy.Expr:
    """Arithmetic of numbers in floating point: exact, it could take for ever."""
    try:
        value = operation(*map(float, numbers))
    except OverflowError as error:
        raise ValueError("a number in it is too large") from error
    if isinstance(value, complex) or not math.isfinite(value):
        raise ValueError(f"a number in it is {value}")
    return (
        sympy.Integer(int(value))
        if value == int(value) and abs(value) < _EXACT
        else sympy.Float(value)
    )


def _cannot_be_used(what: str) -> str:
    return (
        f"{what!r} cannot be used in a function of the parameters; write numbers, parameters, "
        f"+ - * / **, pi and {', '.join(_FUNCTIONS)} of one argument."
    )


def _unit(function: sympy.Expr, units: Mapping[sympy.Symbol, Unit]) -> Unit:
    """Unit of a function; what has none is a number."""
    if function.is_Symbol:
        return units[function]
    parts = [_unit(argument, units) for argument in function.args]
    if function.is_number:
        return _NUMBER
    if function.is_Add:
        return _common(function, parts)
    if function.is_Mul:
        return _product(parts)
    if function.is_Pow:
        return _power(function, parts)
    return _applied(function, parts[0])


def _applied(function: sympy.Expr, argument: Unit) -> Unit:
    if isinstance(function, _Abs):
        return argument
    if not argument.same_dimension(_NUMBER):
        raise UsageError(f"{function} takes a number, not {argument}.")
    return _NUMBER


def _product(parts: list[Unit]) -> Unit:
    """The one unit there is as it was written; of several, the canonical product."""
    first, *others = [p for p in parts if not p.same_dimension(_NUMBER)] or [_NUMBER]
    for part in others:
        first = first * part
    return first


def _common(function: sympy.Expr, parts: list[Unit]) -> Unit:
    for part in parts:
        if not part.same_dimension(parts[0]):
            raise UsageError(f"{function} adds {parts[0]} and {part}; units must agree.")
    return parts[0]


def _power(function: sympy.Expr, parts: list[Unit]) -> Unit:
    base, power = parts
    if not power.same_dimension(_NUMBER):
        raise UsageError(f"the power in {function} is in {power}; give a number.")
    if base.same_dimension(_NUMBER):
        return _NUMBER
    exponent = _number(function.exp, {})
    power_of_unit = Fraction(0 if math.isnan(exponent) else exponent).limit_denominator(_ROOT)
    if math.isnan(exponent) or abs(float(power_of_unit) - exponent) > _NEAR:
        raise UsageError(
            f"{function} has no unit: {base} to a power that is no fraction with a denominator up "
            f"to {_ROOT}."
        )
    return base**power_of_unit
