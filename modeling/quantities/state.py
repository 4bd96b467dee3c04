"""Internal states of friction, for pre-sliding and hysteresis."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, Literal

import sympy

from axisid.support.errors import ModelError

from .constants import with_numbers
from .names import check_symbol, settle
from .symbols import Amount, Symbolic, expression
from .units import parse_unit

#: Remedy for each permitted range of a part, in messages.
_GIVE = {"positive": "a positive number", "0 or more": "0 or more"}


class StateSymbol(sympy.Symbol):  # type: ignore[misc]
    """Symbol of a `State`, with the state's differential equation."""

    __slots__ = ("state",)
    state: "State"

    def __new__(cls, state: "State") -> "StateSymbol":
        """Make a real symbol."""
        symbol: StateSymbol = sympy.Symbol.__xnew__(cls, state.name, real=True)
        symbol.state = state
        return symbol

    def __getnewargs_ex__(self) -> tuple[tuple[Any, ...], dict[str, Any]]:
        """Return the arguments for copies and pickles."""
        return (self.state,), {}

    def _hashable_content(self) -> tuple[Any, ...]:
        """Return the values that decide equality, hash and sorting order."""
        # SymPy also sorts by these values, so the state object itself cannot be one of them.
        state, none = self.state, sympy.S.Infinity
        limit = none if state.limit is None else state.limit
        return (*super()._hashable_content(), state.unit, state.following, limit, state.start)


@dataclass(frozen=True, slots=True, kw_only=True)
class StatePart:
    """Quantity in the equation of a state that a ready element declares, such as LuGre friction.

    Attributes
    ----------
    what : str
        Description: ``the stiffness of LuGre friction``.
    value : sympy.Expr
    unit : str
        Unit that the value must have.
    least : {"positive", "0 or more", ""}
        Permitted range; empty for any number.
    """

    what: str
    value: sympy.Expr
    unit: str
    least: Literal["positive", "0 or more", ""] = ""

    def allows(self, value: float) -> bool:
        """Return whether a number is in the permitted range."""
        if not self.least or value > 0:
            return True
        return value == 0 and self.least == "0 or more"


@dataclass(frozen=True, slots=True)
class State(Symbolic):
    """Internal state of friction, with its own differential equation.

    A state is used directly in the equation of motion. No record contains it, so such an axis can
    be simulated and fitted (`fit`), but not estimated by least squares.

    Attributes
    ----------
    name, unit : str
        Symbol and coherent SI unit, e.g. ``"z", "m"``.
    following : expression or callable
        Rate of change, in `unit` per second: a function of position, velocity, parameters,
        constants, the state itself and other states. To use the state itself, give a Python
        function of its symbol: ``lambda z: v - s0 * Abs(v) * z / Fc``. The rate must vanish with
        the velocity, because the state of friction does not change at rest.
    limit : expression, optional
        Largest absolute value: the state stays there while the velocity drives it further, as for a
        slipping slider; a function of parameters and constants. `following` is then the velocity.
        None for no limit.
    start : expression
        Value at the first sample of a simulation; a function of parameters and constants. A value
        beyond the limit is set to the limit.
    description : str
        A few words for tables.
    parts : tuple of StatePart
        Quantities that a ready element has in its equation. Mistakes are reported for these
        quantities, and not for the equation.

    References
    ----------
    [CanudasDeWit1995]_, [Lampaert2003]_.
    """

    name: str
    unit: str
    following: Amount | Callable[[sympy.Symbol], Amount]
    limit: Amount | None = None
    start: Amount = 0
    description: str = ""
    parts: tuple[StatePart, ...] = field(default=(), compare=False)

    def __post_init__(self) -> None:
        check_symbol(self.name, "a state")
        parse_unit(self.unit)
        rate: Any = self.following
        if callable(rate) and not isinstance(rate, (sympy.Basic, Symbolic)):
            rate = rate(self.own)
        settle(
            self,
            following=expression(rate, f"the rate of state {self.name!r}"),
            start=expression(self.start, f"the start of {self.name!r}"),
            limit=None
            if self.limit is None
            else expression(self.limit, f"the limit of {self.name!r}"),
        )
        for part in self.parts:
            value = with_numbers(part.value)
            if value.is_Number and not part.allows(float(value)):
                raise ModelError(
                    f"{part.what} is {float(value):g} {part.unit}. Give {_GIVE[part.least]}.",
                    code="equation",
                )

    @property
    def own(self) -> sympy.Symbol:
        """Return the plain symbol of the state, for its own equation and derived expressions."""
        return sympy.Symbol(self.name, real=True)

    @property
    def symbol(self) -> sympy.Symbol:
        """Return the symbol of the state with its equation, for an equation of motion."""
        return StateSymbol(self)

    def with_replaced(self, new: Mapping[sympy.Symbol, sympy.Expr]) -> "State":
        """Return the state with symbols replaced in its expressions, such as parameters."""
        rate, *limit, start = (replaced_in(value, new) for value in self.values)
        return State(
            self.name,
            self.unit,
            rate,
            limit=limit[0] if limit else None,
            start=start,
            description=self.description,
            parts=tuple(replace(p, value=p.value.xreplace(dict(new))) for p in self.parts),
        )

    @property
    def first(self) -> sympy.Expr:
        """Return the start value, clipped at the limit."""
        if self.limit is None or self.start == 0:
            return expression(self.start, f"the start of {self.name!r}")
        return sympy.Max(-self.limit, sympy.Min(self.limit, self.start))

    @property
    def laws(self) -> tuple[sympy.Expr, ...]:
        """Return the rate of change and, if the state has a limit, the limit."""
        if self.limit is None:
            return (self.following,)
        return (self.following, self.limit)

    @property
    def values(self) -> tuple[sympy.Expr, ...]:
        """Return all expressions that declare the state: rate, limit if there is one, start."""
        return (*self.laws, self.start)


# Cached, because it is called repeatedly for the force of an axis.
@lru_cache(maxsize=128)
def states_in(*values: sympy.Basic) -> tuple[State, ...]:
    """Return the states that occur in expressions, and in their equations, sorted by name.

    Raises
    ------
    ModelError
        Two states with different equations have the same name.
    """
    found: dict[str, State] = {}
    pending = [symbol.state for value in values for symbol in value.atoms(StateSymbol)]
    while pending:
        state = pending.pop()
        if found.setdefault(state.name, state) != state:
            raise ModelError(
                f"two states of different equations are named {state.name!r}. Rename one of the "
                "states.",
                code="equation",
            )
        inner = [s.state for value in state.values for s in value.atoms(StateSymbol)]
        pending += [each for each in inner if each.name not in found]
    return tuple(found[name] for name in sorted(found))


def at_start(value: sympy.Expr) -> sympy.Expr:
    """Return an expression with each state replaced by its start value."""
    return value.xreplace({s: s.state.first for s in value.atoms(StateSymbol)})


def with_own_symbols(value: sympy.Expr) -> sympy.Expr:
    """Return an expression in which the symbol of each state is its plain symbol."""
    return value.xreplace({s: s.state.own for s in value.atoms(StateSymbol)})


def replaced_in(value: sympy.Expr, new: Mapping[sympy.Symbol, sympy.Expr]) -> sympy.Expr:
    """Return an expression with symbols replaced, also inside the equations of its states."""
    inside = {s: s.state.with_replaced(new).symbol for s in value.atoms(StateSymbol)}
    return value.xreplace({**new, **inside})
