"""Known numbers with a unit: the unit check sees the unit, the generated code the number."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import sympy

from axisid.support.errors import ModelError, is_among

from .kinks import replaced
from .names import check_name
from .numbers import number, settle
from .symbols import Symbolic, expression
from .units import Unit, parse_unit


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


def with_unit(value: sympy.Expr | Symbolic | float, unit: str, what: str) -> sympy.Expr:
    """What an element is told: a plain number takes the unit of its place; others have theirs."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return Constant(number(value, what), unit).symbol
    return expression(value, what)


def positive(value: sympy.Expr | Symbolic | float, unit: str, what: str) -> sympy.Expr:
    """The same where a number must be positive.

    Raises
    ------
    ModelError
        It is a number, and is not.
    """
    symbol = with_unit(value, unit, what)
    if isinstance(symbol, ConstantSymbol) and not symbol.value > 0:
        raise ModelError(f"{what} is {value!r}; give a positive number.", code="axis")
    return symbol


@lru_cache(maxsize=128)
def with_numbers(value: sympy.Expr) -> sympy.Expr:
    """The expression with each constant's number in its place."""
    return replaced(value, {c: sympy.Float(c.value) for c in value.atoms(ConstantSymbol)})


def named_constants(value: sympy.Expr) -> tuple[Constant, ...]:
    """The constants of an expression that have a name of their own, by name."""
    found = {
        symbol.name: Constant(symbol.value, symbol.unit.text, symbol.name)
        for symbol in value.atoms(ConstantSymbol)
        if symbol.name.isidentifier()
    }
    return tuple(found[name] for name in sorted(found))
