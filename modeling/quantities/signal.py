"""A signal that a record has beside the motion: a pressure, a temperature, a supply voltage."""

from dataclasses import dataclass
from typing import Any

import sympy

from axisid.support.errors import ModelError, is_among, quoted

from .names import check_symbol
from .symbols import Symbolic
from .units import parse_unit

#: How a signal or a reference may run between the samples of a log.
BETWEEN = ("linear", "held")


class SignalSymbol(sympy.Symbol):  # type: ignore[misc]
    """The symbol of a `Signal`, by which laws and drives know that it is recorded."""

    __slots__ = ()

    def __new__(cls, name: str) -> "SignalSymbol":
        """Make a real symbol."""
        symbol: SignalSymbol = sympy.Symbol.__xnew__(cls, name, real=True)
        return symbol

    def __getnewargs_ex__(self) -> tuple[tuple[Any, ...], dict[str, Any]]:
        """For copies and pickles."""
        return (self.name,), {}


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
                f"signal {self.name!r}: between its samples it is {quoted(self.between)}; give "
                f"{' or '.join(BETWEEN)}.",
                code="axis",
            )

    @property
    def symbol(self) -> sympy.Symbol:
        """The SymPy symbol."""
        return SignalSymbol(self.name)

    @property
    def is_held(self) -> bool:
        """Whether it keeps its value until the next sample."""
        return self.between == "held"

    @property
    def rate_name(self) -> str:
        """What generated code names its rate of change."""
        return f"{self.name}_rate"


def signals_in(*values: sympy.Basic) -> frozenset[SignalSymbol]:
    """The recorded signals that expressions have in them."""
    return frozenset().union(*(value.atoms(SignalSymbol) for value in values))
