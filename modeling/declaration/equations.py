"""Declare an axis by a force balance or by its energies."""

import math
from collections.abc import Iterable, Sequence
from typing import Any

import sympy

from axisid.modeling.quantities import (
    Amount,
    Coordinate,
    Parameter,
    check_coordinate,
    expression,
    float_at,
    listed,
    signals_in,
    slope,
    vanishes,
    with_numbers,
)
from axisid.support.checks import listed as several
from axisid.support.errors import ModelError

from .axis import Axis

_PLACES = (0, 1, -1, 2, -3, 5)  # positions at which an inertia is checked
_SIZES = ((1, 1), (1, 7), (7, 1), (1, 100), (100, 1))  # values of the parameters, alternately


def newton(
    name: str,
    *,
    coordinate: Coordinate,
    parameters: Iterable[Parameter],
    inertia: Amount,
    resistance: Iterable[Amount],
    **declaration: Any,
) -> Axis:
    """Declare an axis by Newton's law: ``inertia * ddq = tau - sum of resistances``.

    Parameters
    ----------
    name : str
        The axis's name.
    coordinate : Coordinate
        The degree of freedom.
    parameters : iterable of Parameter
        Parameters to identify, in the order of the tables.
    inertia : expression
        Mass or moment of inertia, independent of the motion.
    resistance : iterable of expression
        Forces that oppose a positive motion; see `axisid.modeling.declaration.elements`.
    **declaration
        The other attributes of `Axis`: drive, control, signals, columns, experiment, title.

    Raises
    ------
    ModelError
        The declaration is contradictory, or the inertia depends on the motion or is negative.
    """
    check_coordinate(coordinate)
    q = coordinate
    mass = expression(inertia, "the inertia")
    moving = mass.free_symbols & {q.symbol, q.velocity, q.acceleration}
    if moving:
        raise ModelError(
            f"axis {name!r}: the inertia {mass} depends on {', '.join(map(str, moving))}, so the "
            "equation of motion needs a further velocity term. Declare the axis with lagrange, "
            "which derives this term.",
            code="equation",
        )
    declared = listed(parameters, Parameter, "the parameters contain")
    try:
        _check_inertia(mass, q, declared)
    except ModelError as error:
        raise ModelError(f"axis {name!r}: {error}", code="equation") from error
    opposing = [expression(term, "a resistance") for term in several(resistance)]
    axis = Axis(
        name=name,
        coordinate=q,
        parameters=declared,
        force=mass * q.acceleration + sum(opposing, sympy.S.Zero),
        **declaration,
    )
    axis.check_signals_used()
    return axis


def lagrange(
    name: str,
    *,
    coordinate: Coordinate,
    parameters: Iterable[Parameter],
    kinetic: sympy.Expr,
    potential: sympy.Expr | float = 0,
    dissipation: sympy.Expr | float = 0,
    generalised_force: Amount = 0,
    **declaration: Any,
) -> Axis:
    """Declare an axis by Lagrange's equation with a dissipation function.

    ``d/dt(dT/d dq) - dT/dq + dV/dq + dD/d dq = tau + Q``. T, V and D may have kinks, such as
    ``k Max(0, q)**2 / 2`` of a one-sided spring. If the force jumps at a kink, its value there is
    the mean of both sides.

    Parameters
    ----------
    name : str
        The axis's name.
    coordinate : Coordinate
        The degree of freedom.
    parameters : iterable of Parameter
        Parameters to identify, in the order of the tables.
    kinetic : expression
        Energy T(q, dq), J: half an inertia, which may depend on the position, times ``dq**2``.
    potential : expression
        Energy V(q), J, of the position alone.
    dissipation : expression
        D(q, dq), W: ``Fv dq**2 / 2`` is viscous friction, ``Fc Abs(dq)`` Coulomb friction.
    generalised_force : expression
        Q, any further driving force, positive along the coordinate.
    **declaration
        The other attributes of `Axis`: drive, control, signals, columns, experiment, title.

    Raises
    ------
    ModelError
        The declaration is contradictory; an energy depends on a symbol that is not allowed, or
        jumps; or the kinetic energy is negative.
    """
    check_coordinate(coordinate)
    q = coordinate
    energy = expression(kinetic, "the kinetic energy")
    stored = expression(potential, "the potential energy")
    lost = expression(dissipation, "the dissipation function")
    declared = listed(parameters, Parameter, "the parameters contain")
    try:
        momentum = _momentum(energy, q, declared)
        _check_free(
            stored,
            "potential energy",
            (q.velocity, q.acceleration),
            f"the position {q.symbol} only. Put an inertia into the kinetic energy, as in "
            f"m*{q.velocity}**2/2, and friction into the dissipation function.",
        )
        _check_free(
            lost,
            "dissipation function",
            (q.acceleration,),
            f"the position {q.symbol} and the velocity {q.velocity} only. Put an inertia into "
            f"the kinetic energy, as in m*{q.velocity}**2/2.",
        )
    except ModelError as error:
        raise ModelError(f"axis {name!r}: {error}", code="equation") from error
    force = (
        slope(momentum, q.velocity, "the momentum") * q.acceleration
        + slope(momentum, q.symbol, "the momentum") * q.velocity
        - slope(energy, q.symbol, "the kinetic energy")
        + slope(stored, q.symbol, "the potential energy")
        + slope(lost, q.velocity, "the dissipation function")
        - expression(generalised_force, "the generalised force")
    )
    axis = Axis(name=name, coordinate=q, parameters=declared, force=force, **declaration)
    axis.check_signals_used()
    return axis


def _check_free(value: sympy.Expr, what: str, symbols: Iterable[sympy.Symbol], rest: str) -> None:
    """Refuse an energy or a dissipation function that contains one of the given symbols.

    Parameters
    ----------
    value : sympy.Expr
    what : str
        Description of the function, for the message.
    symbols : iterable of sympy.Symbol
        Symbols that are not allowed.
    rest : str
        End of the message: the allowed symbols, and the remedy.

    Raises
    ------
    ModelError
        The function contains such a symbol.
    """
    inside = " and ".join(str(s) for s in symbols if s in value.free_symbols)
    if inside:
        raise ModelError(f"the {what} {value} depends on {inside}. It may depend on {rest}")


def _momentum(
    energy: sympy.Expr, coordinate: Coordinate, parameters: Sequence[Parameter]
) -> sympy.Expr:
    """Return the momentum, the derivative of a kinetic energy with respect to the velocity.

    The energy must be half an inertia times the squared velocity.

    Raises
    ------
    ModelError
        The energy contains a recorded signal or the acceleration, depends on the velocity in
        another way, or is negative.
    """
    q = coordinate
    if recorded := signals_in(energy):
        raise ModelError(
            f"the kinetic energy {energy} contains the signal {min(map(str, recorded))}. Its rate "
            "of change would cause a force, but is not recorded. Declare the axis with newton.",
            code="equation",
        )
    _check_free(
        energy,
        "kinetic energy",
        (q.acceleration,),
        f"the position {q.symbol} and the square of the velocity only, as in m*{q.velocity}**2/2. "
        "Lagrange's equation derives the acceleration from it.",
    )
    momentum = slope(energy, q.velocity, "the kinetic energy")
    inertia = slope(momentum, q.velocity, "the momentum")
    square = with_numbers(energy - inertia * q.velocity**2 / 2)
    if not vanishes(with_numbers(inertia).diff(q.velocity)) or not vanishes(square):
        raise ModelError(
            f"the kinetic energy {energy} is not proportional to the square of the velocity "
            f"{q.velocity}. Write an inertia times {q.velocity}**2/2. Write energy at rest as a "
            "potential energy, with the opposite sign."
        )
    _check_inertia(inertia, coordinate, parameters)
    return momentum


def _check_inertia(
    inertia: sympy.Expr, coordinate: Coordinate, parameters: Sequence[Parameter]
) -> None:
    """Refuse an inertia that is negative at every position at which it is checked.

    The parameters have their known or nominal values. If one of these values is 0, positive values
    of several sizes within the bounds are used instead. An inertia with recorded signals is not
    checked.

    Raises
    ------
    ModelError
        The inertia is negative.
    """
    if signals_in(inertia):
        return
    found = {p: p.nominal if p.known is None else p.known for p in parameters}
    inside = {p: value for p, value in found.items() if p.symbol in inertia.free_symbols}
    is_nominal = all(inside.values())
    points = [{p.symbol: v for p, v in inside.items()}]
    if not is_nominal:  # positive numbers of several sizes, moved into the bounds
        points = [
            {
                p.symbol: min(max(float(sizes[i % 2]), p.lower), p.upper)
                for i, p in enumerate(inside)
            }
            for sizes in _SIZES
        ]
    values = [
        float_at(with_numbers(inertia), {**point, coordinate.symbol: place})
        for point in points
        for place in _PLACES
    ]
    real = [value for value in values if not math.isnan(value)]
    if real and all(value < 0 for value in real):
        condition = "with the nominal values" if is_nominal else "if its parameters are positive"
        raise ModelError(
            f"the inertia {inertia} is negative {condition}, and so is the kinetic energy. Correct "
            "the sign of the inertia, or a nominal value."
        )
