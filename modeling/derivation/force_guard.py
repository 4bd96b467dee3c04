"""Check that the force in base parameters equals the declared force.

The forces are compared at other points than those at which the base parameters were found. These
points cover the functions of both forces in the same way.
"""

from collections.abc import Mapping
from typing import Any

import sympy

from axisid.modeling.quantities import CANNOT, CoveringPoints, DrawnPoint, Points
from axisid.support.errors import ModelError

from .base_model import BaseModel

_FIRST_CYCLE = 1000  # number of a cycle of points that the derivation does not use
_EXACT, _ROUNDED = 1e-30, 1e-11  # permitted differences of the forces, as shares of their terms
_MOST_POINTS = 40  # largest number of points that are returned


def check_force(base: BaseModel, declared: sympy.Expr, reduced: sympy.Expr) -> None:
    """Refuse base parameters whose force differs from the declared force at some point.

    Parameters
    ----------
    base : BaseModel
    declared, reduced : sympy.Expr
        The force in declared and in base parameters, with the friction direction in place of
        ``sign(dq)``.

    Raises
    ------
    ModelError
        The forces differ.
    """
    for given in differing_points(base, declared, reduced):
        values = ", ".join(f"{s} = {float(x):.6g}" for s, x in given.items())
        raise ModelError(
            f"the force in base parameters is not the declared force where {values}. This is "
            "an error of the program. Report the error together with the axis.",
            code="equation",
        )


def differing_points(
    base: BaseModel, declared: sympy.Expr, reduced: sympy.Expr
) -> list[Mapping[sympy.Symbol, Any]]:
    """Return points at which the declared force and the force in base parameters differ.

    At each point, random numbers are drawn for the motion and the declared parameters, the base
    parameters are computed from these, and both forces are compared.

    Parameters
    ----------
    base : BaseModel
    declared, reduced : sympy.Expr
        The force in declared and in base parameters, with the friction direction in place of
        ``sign(dq)``.

    Returns
    -------
    list of mapping of sympy.Symbol to number
        At most 40 points: the numbers of the motion and of the declared parameters.
    """
    velocity = base.declared.coordinate.velocity
    forces = (declared, reduced)
    points = Points(*forces, velocity=velocity)
    symbols = [p.symbol for p in base.axis.parameters]
    parameters = {p.symbol for p in (*base.declared.parameters, *base.axis.parameters)}
    covering = CoveringPoints(points, forces, moderate=parameters)
    allowed = _ROUNDED if base.rounded else _EXACT
    terms = sympy.Add.make_args(declared)
    found: list[Mapping[sympy.Symbol, Any]] = []

    def compare(point: DrawnPoint) -> None:
        """Add a point to `found` if the two forces differ there by more than rounding."""
        values = [point(term)[0] for term in terms]
        given = {s: point(s) for s in covering.symbols}
        beta = [point(value) for value in base.expressions]
        force, _ = point.beside({**given, **dict(zip(symbols, beta, strict=True))})(reduced)
        if point.is_real and abs(sum(values) - force) > allowed * sum(map(abs, values)):
            found.append({s: x for s, (x, _) in given.items()})

    for point in covering.cycle(_FIRST_CYCLE):
        try:
            compare(point)
        except CANNOT:
            continue
        if len(found) == _MOST_POINTS:
            break
    return found
