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
_FUNCTIONS: dict[str, Callable[[Any], Any]] = {
    "sqrt": sympy.sqrt,
    "abs": sympy.Abs,
    "exp": sympy.exp,
    "log": sympy.log,
    "sin": sympy.sin,
    "cos": sympy.cos,
    "tan": sympy.tan,
    "atan": sympy.atan,
}
_OF_NUMBERS = (sympy.exp, sympy.log, sympy.sin, sympy.cos, sympy.tan, sympy.atan)


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
        point = dict(zip(self.parameters, map(sympy.Float, values), strict=True))
        slopes = [sympy.diff(self.expression, p) for p in self.parameters]
        return (
            _number(self.expression, point),
            [_number(slope, point) for slope in slopes],
            [[_number(sympy.diff(s, p), point) for p in self.parameters] for s in slopes],
        )


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
    known = {symbols[name]: parse_unit(unit) for name, unit in units.items()}
    return ParameterFunction(function, _unit(function, known), tuple(symbols.values()))


def _number(function: sympy.Expr, point: Mapping[sympy.Symbol, sympy.Float]) -> float:
    value = function.xreplace(point).evalf()
    return float(value) if value.is_real and value.is_finite else math.nan


def _no_such(names: list[str], symbols: Mapping[str, sympy.Symbol]) -> str:
    return f"there is no parameter {', '.join(names)}; there are {', '.join(symbols)}."


def _parsed(text: str, symbols: Mapping[str, sympy.Symbol]) -> sympy.Expr:
    if len(text) > _LONGEST_TEXT:
        raise UsageError(f"the function has {len(text)} characters; give {_LONGEST_TEXT} or fewer.")
    try:
        return _evaluated(ast.parse(text.strip(), mode="eval").body, symbols)
    except UsageError:
        raise
    except (SyntaxError, ValueError, RecursionError, MemoryError, ZeroDivisionError) as error:
        raise UsageError(f"the function {text!r} cannot be read: {error}") from error


def _evaluated(node: ast.AST, symbols: Mapping[str, sympy.Symbol]) -> sympy.Expr:
    match node:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            return expression(value, "a number")
        case ast.Name(id="pi") if "pi" not in symbols:
            return sympy.pi
        case ast.Name(id=name):
            if name not in symbols:
                raise UsageError(_no_such([name], symbols))
            return symbols[name]
        case ast.UnaryOp(op=op, operand=operand) if type(op) in _OPERATORS:
            return _OPERATORS[type(op)](_evaluated(operand, symbols))
        case ast.BinOp(left=left, op=ast.Pow(), right=right):
            power = _evaluated(right, symbols)
            if power.is_number and abs(power) > _LARGEST_POWER:
                raise UsageError(f"the power {power} is beyond {_LARGEST_POWER}.")
            return _evaluated(left, symbols) ** power
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATORS:
            return _OPERATORS[type(op)](_evaluated(left, symbols), _evaluated(right, symbols))
        case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in _FUNCTIONS:
            return _FUNCTIONS[name](_evaluated(argument, symbols))
        case _:
            raise UsageError(
                f"{ast.unparse(node)!r} cannot be used in a function of the parameters; write "
                f"numbers, parameters, + - * / **, pi and {', '.join(_FUNCTIONS)} of one argument."
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
    if isinstance(function, sympy.Abs):
        return argument
    if not isinstance(function, _OF_NUMBERS):
        raise UsageError(
            f"{function.func} cannot be used in a function of the parameters; there are "
            f"{', '.join(_FUNCTIONS)}."
        )
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
    if not function.exp.is_number:
        raise UsageError(f"{function} has no unit: {base} to a power that is not fixed.")
    return base ** Fraction(float(function.exp)).limit_denominator(100)
