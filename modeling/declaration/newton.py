"""Declare an axis by a force balance."""

from collections.abc import Iterable
from typing import Any

import sympy

from axisid.modeling.quantities import (
    Coordinate,
    Parameter,
    Symbolic,
    check_coordinate,
    expression,
    listed,
    several,
)
from axisid.support.errors import ModelError

from .axis import Axis
from .energies import check_inertia


def newton(
    name: str,
    *,
    coordinate: Coordinate,
    parameters: Iterable[Parameter],
    inertia: sympy.Expr | Symbolic | float,
    resistance: Iterable[sympy.Expr | Symbolic | float],
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
        In the order of the tables.
    inertia : expression
        Mass or moment of inertia, without the coordinate in it.
    resistance : iterable of expression
        Forces that oppose a positive motion; see `axisid.modeling.declaration.elements`.
    **declaration
        The other attributes of `Axis`: drive, control, signals, columns, experiment, title.

    Raises
    ------
    ModelError
        The declaration is contradictory, or the inertia depends on the motion
        or is negative.
    """
    check_coordinate(coordinate)
    q = coordinate
    mass = expression(inertia, "the inertia")
    moving = mass.free_symbols & {q.symbol, q.velocity, q.acceleration}
    if moving:
        raise ModelError(
            f"axis {name!r}: the inertia {mass} depends on {', '.join(map(str, moving))}, so "
            "Newton's law needs a further velocity term. Declare the axis with lagrange, which "
            "derives it.",
            code="inertia-depends",
        )
    declared = listed(parameters, Parameter, "the parameters have")
    try:
        check_inertia(mass, q, declared)
    except ModelError as error:
        raise ModelError(f"axis {name!r}: {error}", code="negative-inertia") from error
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
