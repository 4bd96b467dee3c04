"""Known numbers with a unit, and signals that a record contains in addition to the motion.

The unit check uses a constant's unit; the generated code uses its number. When expressions are
rebuilt with such numbers, `Max` and `Min` are left unevaluated: SymPy would compare every pair of
arguments, and everything nested in them, each time. Declared expressions are in their final form
already.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import sympy
from sympy.functions.elementary.miscellaneous import Max, Min

from axisid.support.checks import is_among
from axisid.support.errors import ModelError
from axisid.support.wording import quoted

from .names import check_name, check_symbol, number, settle
from .symbols import Amount, Symbolic, expression
from .units import Unit, parse_unit


def extreme(kind: Any, arguments: Sequence[sympy.Expr]) -> sympy.Expr:
    """Return the largest or the smallest of expressions, unevaluated except for plain numbers.

    Parameters
    ----------
    kind : Max or Min
    arguments : sequence of sympy.Expr
        The plain numbers among the arguments are replaced by the largest or smallest of them.
    """
    numbers = [argument for argument in arguments if argument.is_Number]
    others = [argument for argument in arguments if not argument.is_Number]
    if numbers:
        others.append(kind(*numbers))
    return kind(*others, evaluate=False)


def within(value: sympy.Expr, limit: sympy.Expr) -> sympy.Expr:
    """Return a value clipped at plus and minus a limit."""
    return extreme(Max, [extreme(Min, [value, limit]), -limit])


def replaced(
    value: sympy.Basic, new: Mapping[sympy.Basic, sympy.Basic], *, evaluate: bool = True
) -> sympy.Basic:
    """Return ``value.xreplace(new)``, except that ``Max`` and ``Min`` are not evaluated.

    Parameters
    ----------
    value : sympy.Basic
    new : mapping
        The replacement of each part of the expression that is replaced.
    evaluate : bool
        Whether other functions of the new values are evaluated.
    """
    known = dict(new)

    def rebuilt(node: sympy.Basic) -> sympy.Basic:
        """Return a node with its arguments replaced; the node itself if none of them changes."""
        if node not in known:
            arguments = [rebuilt(argument) for argument in node.args]
            if all(one is other for one, other in zip(arguments, node.args, strict=True)):
                known[node] = node
            elif isinstance(node, (Max, Min)):
                known[node] = extreme(node.func, arguments)
            elif evaluate or not isinstance(node, sympy.Function):
                known[node] = node.func(*arguments)
            else:
                known[node] = node.func(*arguments, evaluate=False)
        return known[node]

    return rebuilt(value)


class ConstantSymbol(sympy.Symbol):  # type: ignore[misc]
    """Symbol of a `Constant`, with its value and unit; equal if name, value and unit are equal."""

    __slots__ = ("unit", "value")
    value: float
    unit: Unit

    def __new__(cls, name: str, value: float, unit: str) -> "ConstantSymbol":
        """Make a real symbol with the sign of its value, so that SymPy simplifies ``Abs`` of it."""
        sign: dict[str, bool] = {}
        if value > 0:
            sign = {"positive": True}
        elif value < 0:
            sign = {"negative": True}
        symbol: ConstantSymbol = sympy.Symbol.__xnew__(cls, name, real=True, **sign)
        symbol.value, symbol.unit = value, parse_unit(unit)
        return symbol

    def __getnewargs_ex__(self) -> tuple[tuple[Any, ...], dict[str, Any]]:
        """Return the arguments for copies and pickles."""
        return (self.name, self.value, self.unit.text), {}

    def _hashable_content(self) -> tuple[Any, ...]:
        """Return the values that decide equality and hash."""
        return (*super()._hashable_content(), self.value, self.unit.exponents)


@dataclass(frozen=True, slots=True)
class Constant(Symbolic):
    """A known number in an equation of motion: a pitch, a gear ratio, an inertia from a data sheet.

    A plain number may be used instead, but has no unit that could be checked.

    Attributes
    ----------
    value : float
    unit : str
        Coherent SI unit of `value`.
    name : str
        Name in messages; the number itself by default.
    """

    value: float
    unit: str
    name: str = ""

    def __post_init__(self) -> None:
        settle(self, value=number(self.value, "the value of a constant"))
        parse_unit(self.unit)
        if not is_among(self.name, ("",)):
            check_name(self.name, "a constant")

    @property
    def symbol(self) -> sympy.Symbol:
        """The SymPy symbol."""
        return ConstantSymbol(self.name or f"{self.value:.6g}", self.value, self.unit)


#: Standard acceleration of gravity.
G = Constant(9.80665, "m/s^2", "G")


def with_unit(value: Amount, unit: str, what: str) -> sympy.Expr:
    """Return an amount as an expression; a plain number becomes a constant in the given unit.

    Parameters
    ----------
    value : Amount
        A number, or an expression, which keeps its units.
    unit : str
        Unit of a plain number.
    what : str
        Description of the amount, for messages.

    Raises
    ------
    ModelError
        The amount is neither a finite number nor an expression.
    """
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return Constant(number(value, what), unit).symbol
    return expression(value, what)


def positive(value: Amount, unit: str, what: str) -> sympy.Expr:
    """Return an amount as in `with_unit`; refuse a number that is not positive.

    Raises
    ------
    ModelError
        The amount is refused by `with_unit`, or is a number that is not positive.
    """
    symbol = with_unit(value, unit, what)
    if isinstance(symbol, ConstantSymbol) and not symbol.value > 0:
        raise ModelError(f"{what} is {value!r}. Give a positive number.", code="axis")
    return symbol


@lru_cache(maxsize=128)
def with_numbers(value: sympy.Expr) -> sympy.Expr:
    """Return an expression with each constant replaced by its number."""
    return replaced(value, {c: sympy.Float(c.value) for c in value.atoms(ConstantSymbol)})


#: Ways in which a signal or a reference may run between the samples of a log.
BETWEEN = ("linear", "held")


class SignalSymbol(sympy.Symbol):  # type: ignore[misc]
    """Real symbol of a `Signal`; laws and drives recognise recorded signals by this class."""

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class Signal(Symbolic):
    """A recorded signal in the equation of motion, the drive or the control law.

    The signal is an input, like the reference. Its values are the column of the record that has the
    signal's name. It varies independently of the motion, so that a parameter times a signal can be
    distinguished from a constant force.

    Attributes
    ----------
    name, unit : str
        Symbol and coherent SI unit, e.g. ``"pressure", "Pa"``.
    between : str
        Course between the samples of a record: ``linear``, or ``held`` for an output of a
        controller that changes once per sample. A sampled law and its drive read the signal at the
        samples of the law.
    description : str
        A few words for tables.
    """

    name: str
    unit: str
    between: str = "linear"
    description: str = ""

    def __post_init__(self) -> None:
        check_symbol(self.name, "a signal")
        parse_unit(self.unit)
        if not is_among(self.between, BETWEEN):
            raise ModelError(
                f"signal {self.name!r} has between={quoted(self.between)}. Give "
                f"{' or '.join(BETWEEN)}, the course of the signal between its samples.",
                code="axis",
            )

    @property
    def symbol(self) -> sympy.Symbol:
        """The SymPy symbol."""
        return SignalSymbol(self.name, real=True)

    @property
    def is_held(self) -> bool:
        """Return whether the signal keeps its value until the next sample."""
        return self.between == "held"

    @property
    def rate_name(self) -> str:
        """Return the name of the signal's rate of change in generated code."""
        return f"{self.name}_rate"


def signals_in(*values: sympy.Basic) -> frozenset[SignalSymbol]:
    """Return the symbols of the recorded signals that occur in expressions."""
    return frozenset().union(*(value.atoms(SignalSymbol) for value in values))
