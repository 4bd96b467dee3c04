"""Known numbers with a unit, and signals that a record has beside the motion.

The unit check sees a constant's unit, the generated code its number. Expressions are made again
with such numbers without asking SymPy which argument of `Max` or `Min` is the larger: it asks that
of every pair, and of all that is nested in them, each time such an expression is made again. What
was declared is in its final form already.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import sympy
from sympy.functions.elementary.miscellaneous import Max, Min

from axisid.support.errors import ModelError, is_among, quoted

from .names import check_name, check_symbol, number, settle
from .symbols import Amount, Symbolic, expression
from .units import Unit, parse_unit


def extreme(kind: Any, arguments: Sequence[sympy.Expr]) -> sympy.Expr:
    """The largest or smallest of expressions; of the numbers among them, at once."""
    numbers = [argument for argument in arguments if argument.is_Number]
    others = [argument for argument in arguments if not argument.is_Number]
    if numbers:
        others.append(kind(*numbers))
    return kind(*others, evaluate=False)


def within(value: sympy.Expr, limit: sympy.Expr) -> sympy.Expr:
    """A value clipped at plus and minus a limit."""
    return extreme(Max, [extreme(Min, [value, limit]), -limit])


def replaced(
    value: sympy.Basic, new: Mapping[sympy.Basic, sympy.Basic], *, evaluate: bool = True
) -> sympy.Basic:
    """The same as ``value.xreplace(new)``, but that ``Max`` and ``Min`` stay as they are.

    Parameters
    ----------
    value : sympy.Basic
    new : mapping
    evaluate : bool
        Whether other functions of what is new are worked out.
    """
    known = dict(new)

    def made(node: sympy.Basic) -> sympy.Basic:
        if node not in known:
            arguments = [made(argument) for argument in node.args]
            if all(one is other for one, other in zip(arguments, node.args, strict=True)):
                known[node] = node
            elif isinstance(node, (Max, Min)):
                known[node] = extreme(node.func, arguments)
            elif evaluate or not isinstance(node, sympy.Function):
                known[node] = node.func(*arguments)
            else:
                known[node] = node.func(*arguments, evaluate=False)
        return known[node]

    return made(value)


class ConstantSymbol(sympy.Symbol):  # type: ignore[misc]
    """The symbol of a `Constant`: it carries its value and unit, and is equal by all three."""

    __slots__ = ("unit", "value")
    value: float
    unit: Unit

    def __new__(cls, name: str, value: float, unit: str) -> "ConstantSymbol":
        """Make a real symbol of the value's sign, so that ``Abs`` of it needs no ``Abs``."""
        sign = {"positive": True} if value > 0 else {"negative": True} if value < 0 else {}
        symbol: ConstantSymbol = sympy.Symbol.__xnew__(cls, name, real=True, **sign)
        symbol.value, symbol.unit = value, parse_unit(unit)
        return symbol

    def __getnewargs_ex__(self) -> tuple[tuple[Any, ...], dict[str, Any]]:
        """For copies and pickles."""
        return (self.name, self.value, self.unit.text), {}

    def _hashable_content(self) -> tuple[Any, ...]:
        return (*super()._hashable_content(), self.value, self.unit.exponents)


@dataclass(frozen=True, slots=True)
class Constant(Symbolic):
    """A known number in an equation of motion: a pitch, a gear ratio, an inertia by data sheet.

    A plain number does as well, but has no unit that could be checked.

    Attributes
    ----------
    value : float
    unit : str
        Coherent SI unit of `value`.
    name : str
        For messages; the number itself by default.
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
    """Return an amount with its unit; a plain number takes the unit of its place."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return Constant(number(value, what), unit).symbol
    return expression(value, what)


def positive(value: Amount, unit: str, what: str) -> sympy.Expr:
    """The same where a number must be positive.

    Raises
    ------
    ModelError
        It is a number, and is not.
    """
    symbol = with_unit(value, unit, what)
    if isinstance(symbol, ConstantSymbol) and not symbol.value > 0:
        raise ModelError(f"{what} is {value!r}. Give a positive number.", code="axis")
    return symbol


@lru_cache(maxsize=128)
def with_numbers(value: sympy.Expr) -> sympy.Expr:
    """The expression with each constant's number in its place."""
    return replaced(value, {c: sympy.Float(c.value) for c in value.atoms(ConstantSymbol)})


#: How a signal or a reference may run between the samples of a log.
BETWEEN = ("linear", "held")


class SignalSymbol(sympy.Symbol):  # type: ignore[misc]
    """The real symbol of a `Signal`, by which laws and drives know that it is recorded."""

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class Signal(Symbolic):
    """A recorded signal that stands in the equation of motion, the drive or the control law.

    It is given, as the reference is: a column of the record with the signal's name. It varies by
    itself, so that a parameter times a signal is told apart from a constant.

    Attributes
    ----------
    name, unit : str
        Symbol and coherent SI unit, e.g. ``"pressure", "Pa"``.
    between : str
        How it runs between the samples of a record: ``linear``, or ``held`` for what a controller
        gives once a sample. A sampled law and a drive read it at the law's samples.
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
                f"signal {self.name!r}: between its samples it is {quoted(self.between)}. Give "
                f"{' or '.join(BETWEEN)}.",
                code="axis",
            )

    @property
    def symbol(self) -> sympy.Symbol:
        """The SymPy symbol."""
        return SignalSymbol(self.name, real=True)

    @property
    def is_held(self) -> bool:
        """Return whether it keeps its value until the next sample."""
        return self.between == "held"

    @property
    def rate_name(self) -> str:
        """Return the name of its rate of change in generated code."""
        return f"{self.name}_rate"


def signals_in(*values: sympy.Basic) -> frozenset[SignalSymbol]:
    """The recorded signals that expressions have in them."""
    return frozenset().union(*(value.atoms(SignalSymbol) for value in values))
