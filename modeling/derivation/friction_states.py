"""Equations of the internal states of an axis, and the forces on the axis at rest.

The forces at rest are computed term by term from the equation of motion.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import sympy

from axisid.modeling.declaration import Axis
from axisid.modeling.quantities import (
    DIRECTION,
    State,
    StatePart,
    at_start,
    float_at,
    vanishes,
    with_numbers,
    with_own_symbols,
)
from axisid.support.checks import refuse
from axisid.support.errors import ModelError

from .inverse import directed


def forces_at_rest(
    axis: Axis, parameters: Sequence[float], position: float, recorded: Sequence[float]
) -> tuple[tuple[str, float], ...]:
    """Return each term of the equation of motion, as text, with its force at rest, N or N m.

    The internal states are at their start values. A force without a finite real value is NaN.

    Parameters
    ----------
    axis : Axis
    parameters : sequence of float
        Length p, finite.
    position : float
        Position of the axis, m or rad.
    recorded : sequence of float
        Values of the recorded signals, in the axis's order.
    """
    point = motion_point(axis, parameters, (position, 0.0), recorded)
    return tuple(
        (str(term), float_at(with_numbers(at_start(term)), point))
        for term in sympy.Add.make_args(axis.force)
    )


def motion_point(
    axis: Axis, parameters: Sequence[float], motion: tuple[float, float], recorded: Sequence[float]
) -> dict[sympy.Symbol, float]:
    """Return the numbers of an axis's symbols in a motion with zero acceleration, by symbol.

    Parameters
    ----------
    axis : Axis
    parameters : sequence of float
        Length p.
    motion : (float, float)
        Position and velocity, SI.
    recorded : sequence of float
        Values of the recorded signals, in the axis's order.
    """
    q = axis.coordinate
    symbols = (*(p.symbol for p in axis.parameters), *axis.signal_symbols)
    named = dict(zip(symbols, (*parameters, *recorded), strict=True))
    return {**named, q.symbol: motion[0], q.velocity: motion[1], q.acceleration: 0.0}


@dataclass(frozen=True, slots=True, kw_only=True)
class StateEquation:
    """Differential equation of an internal state, with the friction direction for ``sign(dq)``.

    Attributes
    ----------
    symbol : sympy.Symbol
    rate : sympy.Expr
        Rate of change of the state while it is within its limit.
    limit : sympy.Expr or None
        Largest absolute value, at which the state stays while the velocity drives it further; None
        for no limit.
    start : sympy.Expr
        Value at the start, as a function of the parameters.
    """

    symbol: sympy.Symbol
    rate: sympy.Expr
    limit: sympy.Expr | None
    start: sympy.Expr


def state_equations(axis: Axis) -> tuple[StateEquation, ...]:
    """Return the equations of an axis's internal states, in the order of their names.

    Raises
    ------
    ModelError
        A state changes at rest, or depends on a symbol that is not allowed; or the axis has a
        property that cannot be simulated together with states.
    """
    if not axis.states:
        return ()
    law, response = axis.control, axis.response
    names = ", ".join(state.name for state in axis.states)
    unsupported = {
        "a continuous control law": law is not None and law.continuous,
        "recorded signals": bool(axis.signals),
        "a drive whose force changes between the samples of the law": response is not None
        and not response.is_held,
    }
    found = [what for what, is_declared in unsupported.items() if is_declared]
    if found:
        raise ModelError(
            f"axis {axis.name!r}: the friction has internal states ({names}), and the axis has "
            f"{found[0]}. This combination cannot be simulated. Declare the axis without one of "
            "the two.",
            code="equation",
        )
    return tuple(_equation(axis, state) for state in axis.states)


def state_limits(axis: Axis) -> tuple[tuple[StatePart, Callable[[Sequence[float]], float]], ...]:
    """Return the quantities in the equations of states that have a permitted range.

    Each comes with a function that returns its value from parameters (p,). The value is NaN if it
    is not a real number.
    """
    if not axis.states:  # called for each simulation, and symbols are slow to make
        return ()
    places = {p.symbol: place for place, p in enumerate(axis.parameters)}

    def value_of(expression: sympy.Expr, values: Sequence[float]) -> float:
        """Return the value of an expression for parameters (p,)."""
        given = {symbol: sympy.Float(values[places[symbol]]) for symbol in expression.free_symbols}
        found = expression.xreplace(given)
        return float(found) if found.is_real else math.nan

    parts = [part for state in axis.states for part in state.parts if part.least]
    return tuple((part, partial(value_of, with_numbers(part.value))) for part in parts)


def in_direction(value: sympy.Expr, velocity: sympy.Symbol) -> sympy.Expr:
    """Return an expression with ``sign(dq)`` and ``Abs(dq)`` written by the friction direction.

    ``Abs(a dq)`` becomes ``|a| direction dq``, which is smooth at a fixed direction.
    """

    def without_abs(node: sympy.Expr) -> sympy.Expr:
        """Return an absolute value of a multiple of the velocity, written by the direction."""
        factor, power = node.args[0].as_independent(velocity, as_Add=False)
        return sympy.Abs(factor) * DIRECTION * velocity if power == velocity else node

    value = value.replace(
        lambda node: isinstance(node, (sympy.sign, sympy.Heaviside, sympy.Piecewise)),
        lambda node: directed(node, velocity),
    )
    return value.replace(lambda node: isinstance(node, sympy.Abs), without_abs)


def _equation(axis: Axis, state: State) -> StateEquation:
    """Return the equation of one state, checked.

    Raises
    ------
    ModelError
        The state changes at rest, depends on a symbol that is not allowed, or has a limit although
        its rate is not the velocity.
    """
    q = axis.coordinate
    rate, *others = (with_own_symbols(with_numbers(value)) for value in state.values)
    parameters = {p.symbol for p in axis.parameters}
    states = {each.own for each in axis.states}
    _check_symbols(axis, state, rate, {q.symbol, q.velocity} | parameters | states)
    for value in others:
        _check_symbols(axis, state, value, parameters)
    rate = in_direction(rate, q.velocity)
    limit = None if state.limit is None else others[0]
    refuse(
        ModelError,
        (
            not vanishes(rate.xreplace({q.velocity: sympy.S.Zero})),
            f"changes at rest with the rate {state.following}. Declare a rate that is 0 if the "
            f"velocity {q.velocity} is 0",
        ),
        (
            limit is not None and rate != q.velocity,
            f"has a limit and the rate {state.following}. Declare the velocity {q.velocity} as the "
            "rate of a state with a limit",
        ),
        before=f"axis {axis.name!r}: the state {state.name} ",
        code="equation",
    )
    first = with_own_symbols(with_numbers(state.first))
    return StateEquation(symbol=state.own, rate=rate, limit=limit, start=first)


def _check_symbols(axis: Axis, state: State, value: sympy.Expr, allowed: set[sympy.Symbol]) -> None:
    """Refuse an expression of a state that contains a symbol outside `allowed`."""
    if unknown := sorted(map(str, value.free_symbols - allowed)):
        raise ModelError(
            f"axis {axis.name!r}: the state {state.name} is declared by {value}, which contains "
            f"{', '.join(unknown)}. Use only {', '.join(sorted(map(str, allowed)))}.",
            code="equation",
        )
