"""Declare an axis by its energies."""

from collections.abc import Iterable
from typing import Any

import sympy

from axisid.modeling.algebra import slope
from axisid.modeling.quantities import (
    Coordinate,
    Parameter,
    Symbolic,
    check_coordinate,
    expression,
    listed,
)
from axisid.support.errors import ModelError

from .axis import Axis
from .energies import check_dissipation, check_kinetic, check_potential


def lagrange(
    name: str,
    *,
    coordinate: Coordinate,
    parameters: Iterable[Parameter],
    kinetic: sympy.Expr,
    potential: sympy.Expr | float = 0,
    dissipation: sympy.Expr | float = 0,
    generalised_force: sympy.Expr | Symbolic | float = 0,
    **declaration: Any,
) -> Axis:
    """Declare an axis by Lagrange's equation with a dissipation function.

    ``d/dt(dT/d dq) - dT/dq + dV/dq + dD/d dq = tau + Q``. T, V and D may have kinks, such as
    ``k Max(0, q)**2 / 2`` of a one-sided spring; where the force jumps at one, it has the mean of
    both sides there.

    Parameters
    ----------
    name : str
        The axis's name.
    coordinate : Coordinate
        The degree of freedom.
    parameters : iterable of Parameter
        In the order of the tables.
    kinetic : expression
        Energy T(q, dq), J: half an inertia, which may depend on the position, times ``dq**2``.
    potential : expression
        Energy V(q), J, of the position alone.
    dissipation : expression
        D(q, dq), W: ``Fv dq**2 / 2`` is viscous friction, ``Fc Abs(dq)`` Coulomb friction.
    generalised_force : expression
        Q, whatever else drives the axis, positive along the coordinate.
    **declaration
        The other attributes of `Axis`: drive, control, signals, columns, experiment, title.

    Raises
    ------
    ModelError
        The declaration is contradictory, an energy depends on what it must not, jumps, or is
        negative where it is kinetic.
    """
    check_coordinate(coordinate)
    q = coordinate
    energy = expression(kinetic, "the kinetic energy")
    stored = expression(potential, "the potential energy")
    lost = expression(dissipation, "the dissipation function")
    declared = listed(parameters, Parameter, "the parameters have")
    try:
        check_kinetic(energy, q, declared)
        check_potential(stored, q)
        check_dissipation(lost, q)
    except ModelError as error:
        raise ModelError(f"axis {name!r}: {error}", code="energy-depends") from error
    momentum = slope(energy, q.velocity, "the kinetic energy")
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
