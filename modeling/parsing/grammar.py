"""Grammar of expressions in text, errors with their position, and bounds on numbers.

The elements of friction and load, such as ``stribeck(Fs, x, velocity=0.01)``, are the functions of
`axisid.modeling.declaration.elements` with the same arguments. A plain number as their argument has
the expected unit, whereas a number elsewhere in an expression has no unit.

Once a constant's number is substituted, SymPy evaluates parts made of numbers and constants alone,
to any size and without a bound on time. Such parts are therefore evaluated as floats first, which
overflow instead.
"""

import difflib
import inspect
import math
import operator
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Any, TypeAlias

import sympy
from sympy.functions.elementary.miscellaneous import Max, Min

from axisid.modeling.declaration import ELEMENTS
from axisid.modeling.quantities import CANNOT, ConstantSymbol, Coordinate
from axisid.support.errors import ModelError, UsageError

_SHOWN = 60  # characters around a mistake


class TextError(UsageError):
    """Error for a text that is not a permitted expression.

    Parameters
    ----------
    reason : str
        Mistake and remedy, in sentences.
    text : str
        The whole text.
    offset : int
        Offset in the text at which the mistake begins.
    code : str
        Code of the error; by default the code of the class.

    Attributes
    ----------
    reason : str
        Mistake and remedy, in sentences.
    where : str
        Position of the mistake: ``column 3``, or ``line 2, column 3`` in a text of several lines.
    pointer : str
        The line of the text with a caret below the mistake; empty for an empty line.
    """

    code = "formula"

    def __init__(self, reason: str, text: str, offset: int, *, code: str = "") -> None:
        before = text[: max(offset, 0)].split("\n")
        line, column = len(before), len(before[-1])
        whole = text.split("\n")[line - 1]
        self.where = (f"line {line}, " if "\n" in text.strip() else "") + f"column {column + 1}"
        start = max(0, column - _SHOWN // 2)
        shown = "".join(c if c.isprintable() else "?" for c in whole[start : start + _SHOWN])
        self.pointer = f"{shown}\n{' ' * (column - start)}^" if shown.strip() else ""
        super().__init__(f"{shown.strip()!r} cannot be read at {self.where}: {reason}", code=code)
        self._given = reason, text, offset
        self.reason = reason

    def __reduce__(self) -> tuple[Any, ...]:
        """Return the call that makes a copy of the error, for pickles."""
        return partial(type(self), code=self.code), self._given


def nearest(name: str, names: Collection[str]) -> str:
    """Return `` Did you mean 'NAME'?`` with the most similar name; empty without a similar name.

    Parameters
    ----------
    name : str
        The name that was written.
    names : collection of str
        Known names.
    """
    close = difflib.get_close_matches(name[:50], list(names), 1)
    return f" Did you mean {close[0]!r}?" if close else ""


#: Largest number of levels of nesting in a text.
DEEPEST = 15


@dataclass(frozen=True, slots=True)
class Function:
    """A mathematical function that an expression in text may call.

    Attributes
    ----------
    symbolic : callable
        The function for SymPy expressions.
    number : callable
        The function for floats.
    arguments : int
        Number of arguments.
    """

    symbolic: Callable[..., Any]
    number: Callable[..., float]
    arguments: int = 1


#: Mathematical functions that text may call, by name; each can be translated to generated code.
FUNCTIONS = {
    "sin": Function(sympy.sin, math.sin),
    "cos": Function(sympy.cos, math.cos),
    "tan": Function(sympy.tan, math.tan),
    "asin": Function(sympy.asin, math.asin),
    "acos": Function(sympy.acos, math.acos),
    "atan": Function(sympy.atan, math.atan),
    "atan2": Function(sympy.atan2, math.atan2, 2),
    "sinh": Function(sympy.sinh, math.sinh),
    "cosh": Function(sympy.cosh, math.cosh),
    "tanh": Function(sympy.tanh, math.tanh),
    "exp": Function(sympy.exp, math.exp),
    "log": Function(sympy.log, math.log),
    "sqrt": Function(sympy.sqrt, math.sqrt),
    "abs": Function(sympy.Abs, abs),
    "sign": Function(sympy.sign, lambda x: float((x > 0) - (x < 0))),
    "min": Function(Min, min, 2),
    "max": Function(Max, max, 2),
}

#: SymPy classes of the operations and functions that an expression may contain.
NODES = frozenset({sympy.Add, sympy.Mul, sympy.Pow, *(f.symbolic for f in FUNCTIONS.values())})


def not_allowed(piece: str, text: str, offset: int, hint: str = "") -> TextError:
    """Return the error for a piece of text that is not allowed in an expression."""
    return TextError(
        f"{piece!r} cannot be used in an expression. Write numbers, names, pi, + - * / **, "
        f"parentheses and functions such as sqrt(...){hint}.",
        text,
        offset,
    )


def nested(text: str, offset: int) -> TextError:
    """Return the error for a text that is nested too deeply."""
    return TextError(
        f"the expression is nested more than {DEEPEST} levels deep. Simplify the expression.",
        text,
        offset,
    )


#: Largest absolute value of a part of an expression that contains constants.
LARGEST = 1e100

# Operations in floating point, by SymPy class.
_FLOATS: dict[Any, Callable[..., float]] = {
    sympy.Add: lambda *terms: math.fsum(terms),
    sympy.Mul: lambda *factors: math.prod(factors),
    sympy.Pow: operator.pow,
    sympy.Heaviside: lambda x, at_0: at_0 if x == 0 else float(x > 0),  # derivatives of min and max
    **{function.symbolic: function.number for function in FUNCTIONS.values()},
}


class ConstantValues:
    """Floating-point values of expressions of constants, each evaluated once.

    Parameters
    ----------
    known : mapping of sympy.Expr to float
        Values of further symbols, such as parameters; none by default.
    """

    def __init__(self, known: Mapping[sympy.Expr, float] = MappingProxyType({})) -> None:
        """Store the known values of symbols."""
        self._found: dict[sympy.Expr, float | None] = dict(known)

    def value(self, expression: sympy.Expr) -> float | None:
        """Return the value of an expression.

        It is None if the expression contains a symbol without a value, and NaN if the value is not
        finite and real.
        """
        if expression not in self._found:
            try:
                self._found[expression] = self._evaluated(expression)
            except CANNOT:
                self._found[expression] = math.nan
        return self._found[expression]

    def number(self, expression: sympy.Expr) -> float:
        """Return the value of an expression; NaN if it has no finite real value."""
        value = self.value(expression)
        return math.nan if value is None else value

    def fits(self, node: sympy.Expr) -> bool:
        """Return whether the constant part of a node is at most 1e100 in size.

        It is the sum or the product of the terms or factors that have a value, and the whole node
        if the node is not a sum or a product. A node without constants fits.
        """
        if node.is_Symbol or not node.has(ConstantSymbol):
            return True
        parts = node.args if node.is_Add or node.is_Mul else (node,)
        values = [self.value(part) for part in parts if part.has(ConstantSymbol)]
        numbers = [value for value in values if value is not None]
        total = math.fsum if node.is_Add else math.prod
        try:
            return small(total(numbers))
        except CANNOT:
            return False

    def _evaluated(self, expression: sympy.Expr) -> float | None:
        """Return the value of an expression from the values of its arguments, as in `value`."""
        if isinstance(expression, ConstantSymbol):
            return expression.value
        if expression.is_Number or expression.is_NumberSymbol:
            return float(expression)
        if expression.is_Symbol:
            return None
        values = [self.value(part) for part in expression.args]
        if not all(value is not None for value in values):
            return None
        if expression.func not in _FLOATS:
            return math.nan
        value = _FLOATS[expression.func](*values)
        return value if not isinstance(value, complex) and math.isfinite(value) else math.nan


def small(value: float) -> bool:
    """Return whether a number is real and at most 1e100 in size."""
    return not isinstance(value, complex) and abs(value) <= LARGEST


#: Elements of friction and load that text may call, by name.
Elements: TypeAlias = Mapping[str, Callable[..., sympy.Expr]]


def elements_along(coordinate: Coordinate) -> Elements:
    """Return the elements of friction and load for one coordinate, by name."""
    return {name: partial(_element_force, name, coordinate) for name in ELEMENTS}


def _element_force(
    element: str, along: Coordinate, /, *arguments: sympy.Expr, **named: sympy.Expr
) -> sympy.Expr:
    """Return the force of an element of friction or load.

    Parameters
    ----------
    element : str
        Name of the element.
    along : Coordinate
        The coordinate of the axis, the only one that the text may name.
    *arguments, **named : sympy.Expr
        Arguments of the element, as written in the text.

    Raises
    ------
    ModelError
        The arguments do not fit the signature of the element, or the element refuses a value.
    """
    signature = inspect.signature(ELEMENTS[element])
    try:
        bound = signature.bind(*arguments, **named)
    except TypeError as error:
        bare = [each.replace(annotation=each.empty) for each in signature.parameters.values()]
        raise ModelError(
            f"{element}(...) is called incorrectly: {error}. Write "
            f"{element}{inspect.Signature(bare)}."
        ) from error
    for key, value in bound.arguments.items():
        bound.arguments[key] = _converted(element, along, key, value)
    return ELEMENTS[element](*bound.args, **bound.kwargs)


def _converted(element: str, along: Coordinate, key: str, value: sympy.Expr) -> Any:
    """Return an argument of an element in the type that the element expects.

    The symbol of the coordinate becomes the `Coordinate`, a number an int or a float. Another
    expression stays as it is.

    Raises
    ------
    ModelError
        The argument ``coordinate`` is not the coordinate's symbol.
    """
    if key == "coordinate":
        if value != along.symbol:
            raise ModelError(
                f"the coordinate of {element}(...) is {value}. Write {along.name}.",
                code="formula",
            )
        return along
    if isinstance(value, sympy.Integer):
        return int(value)
    return float(value) if value.is_Number else value
