"""An internal state of friction that remembers: presliding, hysteresis."""

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

#: What to give where a part may not be any number.
_GIVE = {"positive": "a positive number", "0 or more": "0 or more"}


class StateSymbol(sympy.Symbol):  # type: ignore[misc]
    """The symbol of a `State`: it carries how the state follows the motion."""

    __slots__ = ("state",)
    state: "State"

    def __new__(cls, state: "State") -> "StateSymbol":
        """Make a real symbol."""
        symbol: StateSymbol = sympy.Symbol.__xnew__(cls, state.name, real=True)
        symbol.state = state
        return symbol

    def __getnewargs_ex__(self) -> tuple[tuple[Any, ...], dict[str, Any]]:
        """For copies and pickles."""
        return (self.state,), {}

    def _hashable_content(self) -> tuple[Any, ...]:
        # SymPy also orders by it, so that a state itself cannot be there.
        state, none = self.state, sympy.S.Infinity
        limit = none if state.limit is None else state.limit
        return (*super()._hashable_content(), state.unit, state.following, limit, state.start)


@dataclass(frozen=True, slots=True, kw_only=True)
class StatePart:
    """An amount that a ready state was declared by.

    Attributes
    ----------
    what : str
        In words: ``the stiffness of LuGre friction``.
    value : sympy.Expr
    unit : str
        That it must have.
    least : {"positive", "0 or more", ""}
        What it must be; empty for any number.
    """

    what: str
    value: sympy.Expr
    unit: str
    least: Literal["positive", "0 or more", ""] = ""

    def allows(self, value: float) -> bool:
        """Return whether it may be a number."""
        return not self.least or value > 0 or (value == 0 and self.least == "0 or more")


@dataclass(frozen=True, slots=True)
class State(Symbolic):
    """Internal state of friction, with its own differential equation.

    It stands in the equation of motion as it is. No record has it, so that such an axis is
    simulated and fitted (`fit`), and has no least squares.

    Attributes
    ----------
    name, unit : str
        Symbol and coherent SI unit, e.g. ``"z", "m"``.
    following : expression or callable
        Its rate of change, in `unit` per second: of position, velocity, parameters and constants,
        of its own symbol and of other states. To write its own symbol, give a function of it:
        ``lambda z: v - s0 * Abs(v) * z / Fc``. It must vanish with the velocity: a state that
        changes at rest is none of friction's.
    limit : expression, optional
        Where the state stays while the velocity drives it on, on either side, as a slider does that
        slips; of parameters and constants. `following` is then the velocity.
    start : expression
        Where it is at the first sample of a simulation; of parameters and constants. One beyond the
        limit begins at the limit.
    description : str
        A few words for tables.
    parts : tuple of StatePart
        What a ready element is declared by, so that what is wrong is said of that and not of the
        state's equation.

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
        """Its symbol in its own equation, and in all that is derived."""
        return sympy.Symbol(self.name, real=True)

    @property
    def symbol(self) -> sympy.Symbol:
        """The SymPy symbol, by which an axis knows of it."""
        return StateSymbol(self)

    def with_replaced(self, new: Mapping[sympy.Symbol, sympy.Expr]) -> "State":
        """The same with others in place of symbols, such as numbers of parameters."""
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
        """Return its start value, which is within its limit."""
        if self.limit is None or self.start == 0:
            return expression(self.start, f"the start of {self.name!r}")
        return sympy.Max(-self.limit, sympy.Min(self.limit, self.start))

    @property
    def laws(self) -> tuple[sympy.Expr, ...]:
        """The expressions that it changes by, wherever it begins."""
        return (self.following, *(() if self.limit is None else (self.limit,)))

    @property
    def values(self) -> tuple[sympy.Expr, ...]:
        """The expressions that it is declared by."""
        return (*self.laws, self.start)


# Of an axis's force it is asked again and again.
@lru_cache(maxsize=128)
def states_in(*values: sympy.Basic) -> tuple[State, ...]:
    """The states that expressions have in them, and those that these follow, by name.

    Raises
    ------
    ModelError
        Two of different equations have one name.
    """
    found: dict[str, State] = {}
    pending = [symbol.state for value in values for symbol in value.atoms(StateSymbol)]
    while pending:
        state = pending.pop()
        if found.setdefault(state.name, state) != state:
            raise ModelError(
                f"two states of different equations are named {state.name!r}. Rename one.",
                code="equation",
            )
        inner = [s.state for value in state.values for s in value.atoms(StateSymbol)]
        pending += [each for each in inner if each.name not in found]
    return tuple(found[name] for name in sorted(found))


def at_start(value: sympy.Expr) -> sympy.Expr:
    """An expression where its states start."""
    return value.xreplace({s: s.state.first for s in value.atoms(StateSymbol)})


def with_own_symbols(value: sympy.Expr) -> sympy.Expr:
    """An expression with each state's own symbol in it, which carries no equation."""
    return value.xreplace({s: s.state.own for s in value.atoms(StateSymbol)})


def replaced_in(value: sympy.Expr, new: Mapping[sympy.Symbol, sympy.Expr]) -> sympy.Expr:
    """An expression with others in place of symbols, also in the equations of its states."""
    inside = {s: s.state.with_replaced(new).symbol for s in value.atoms(StateSymbol)}
    return value.xreplace({**new, **inside})
