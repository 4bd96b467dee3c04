"""The equations of an axis's internal states, each checked, and the axis at rest.

At rest the equation of motion gives, term by term, the forces from which a motion starts and to
which it returns.
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
    """Return the terms of the equation of motion, each with its force at rest; NaN without a value.

    Parameters
    ----------
    axis : Axis
    parameters : sequence of float
        Length p, finite.
    position : float
    recorded : sequence of float
        The recorded signals, in the axis's order.
    """
    point = motion_point(axis, parameters, (position, 0.0), recorded)
    return tuple(
        (str(term), float_at(with_numbers(at_start(term)), point))
        for term in sympy.Add.make_args(axis.force)
    )


def motion_point(
    axis: Axis, parameters: Sequence[float], motion: tuple[float, float], recorded: Sequence[float]
) -> dict[sympy.Symbol, float]:
    """Return numbers for the symbols of a force without acceleration."""
    q = axis.coordinate
    symbols = (*(p.symbol for p in axis.parameters), *axis.signal_symbols)
    named = dict(zip(symbols, (*parameters, *recorded), strict=True))
    return {**named, q.symbol: motion[0], q.velocity: motion[1], q.acceleration: 0.0}


@dataclass(frozen=True, slots=True, kw_only=True)
class StateEquation:
    """Equation of a state in one friction direction.

    Attributes
    ----------
    symbol : sympy.Symbol
    rate : sympy.Expr
        Its rate of change, except at its limit.
    limit : sympy.Expr or None
        Value at which it stays while the velocity drives it further.
    start : sympy.Expr
        Its start, as a function of the parameters.
    """

    symbol: sympy.Symbol
    rate: sympy.Expr
    limit: sympy.Expr | None
    start: sympy.Expr


def state_equations(axis: Axis) -> tuple[StateEquation, ...]:
    """Return the equations of an axis's states, by name.

    Raises
    ------
    ModelError
        A state changes at rest, or depends on a symbol that is not allowed; or the axis has a
        property with which a loop with states cannot be simulated.
    """
    if not axis.states:
        return ()
    law, response = axis.control, axis.response
    names = ", ".join(state.name for state in axis.states)
    beside = {
        "a continuous control law": law is not None and law.continuous,
        "recorded signals": bool(axis.signals),
        "a drive whose force changes between the samples of the law": response is not None
        and not response.is_held,
    }
    if found := [what for what, there in beside.items() if there]:
        raise ModelError(
            f"axis {axis.name!r}: the friction has internal states ({names}), and the axis has "
            f"{found[0]}. This combination cannot be simulated. Declare the axis without one of "
            "the two.",
            code="equation",
        )
    return tuple(_equation(axis, state) for state in axis.states)


def state_limits(axis: Axis) -> tuple[tuple[StatePart, Callable[[Sequence[float]], float]], ...]:
    """Return the declared amounts of states that have a range, as functions of parameters (p,).

    A value that is not a real number is NaN.
    """
    if not axis.states:  # evaluated at each simulation, and symbols are slow to make
        return ()
    places = {p.symbol: place for place, p in enumerate(axis.parameters)}

    def value_of(expression: sympy.Expr, values: Sequence[float]) -> float:
        given = {symbol: sympy.Float(values[places[symbol]]) for symbol in expression.free_symbols}
        found = expression.xreplace(given)
        return float(found) if found.is_real else math.nan

    parts = [part for state in axis.states for part in state.parts if part.least]
    return tuple((part, partial(value_of, with_numbers(part.value))) for part in parts)


def in_direction(value: sympy.Expr, velocity: sympy.Symbol) -> sympy.Expr:
    """Return an expression in one friction direction, where ``Abs(dq)`` is smooth too."""

    def along(node: sympy.Expr) -> sympy.Expr:
        factor, power = node.args[0].as_independent(velocity, as_Add=False)
        return sympy.Abs(factor) * DIRECTION * velocity if power == velocity else node

    value = value.replace(
        lambda node: isinstance(node, (sympy.sign, sympy.Heaviside, sympy.Piecewise)),
        lambda node: directed(node, velocity),
    )
    return value.replace(lambda node: isinstance(node, sympy.Abs), along)


def _equation(axis: Axis, state: State) -> StateEquation:
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
            f"has a limit and the rate {state.following}. The rate of a state with a limit must be "
            f"the velocity {q.velocity}",
        ),
        before=f"axis {axis.name!r}: the state {state.name} ",
        code="equation",
    )
    first = with_own_symbols(with_numbers(state.first))
    return StateEquation(symbol=state.own, rate=rate, limit=limit, start=first)


def _check_symbols(axis: Axis, state: State, value: sympy.Expr, allowed: set[sympy.Symbol]) -> None:
    if unknown := sorted(map(str, value.free_symbols - allowed)):
        raise ModelError(
            f"axis {axis.name!r}: the state {state.name} is declared by {value}, which contains "
            f"{', '.join(unknown)}. Use only {', '.join(sorted(map(str, allowed)))}.",
            code="equation",
        )
