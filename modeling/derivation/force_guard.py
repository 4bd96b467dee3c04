"""Final check of a derivation: the force in base parameters equals the declared force.

The points differ from those at which the base parameters were found. They cover the functions of
both forces in the same way.
"""

from collections.abc import Mapping
from typing import Any

import sympy

from axisid.modeling.quantities import CANNOT, CoveringPoints, DrawnPoint, Points
from axisid.support.errors import ModelError

from .base_model import BaseModel

_FIRST_CYCLE = 1000  # in addition to those of the derivation
_EXACT, _ROUNDED = 1e-30, 1e-11  # shares of the terms by which the forces may differ
_MOST_POINTS = 40  # at which a difference of the forces is reported


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
        place = ", ".join(f"{s} = {float(x):.6g}" for s, x in given.items())
        raise ModelError(
            f"the force in base parameters is not the declared force where {place}. This is "
            "an error of the program: report it together with the axis.",
            code="equation",
        )


def differing_points(
    base: BaseModel, declared: sympy.Expr, reduced: sympy.Expr
) -> list[Mapping[sympy.Symbol, Any]]:
    """Return points at which the declared force and the force in base parameters differ.

    At each point numbers are drawn for motion and declared parameters, the base parameters are
    computed from them, and both forces are compared. At most 40 points are returned, as numbers by
    symbol.
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

    def look(point: DrawnPoint) -> None:
        """Add a point to `found` if the two forces differ there by more than rounding."""
        values = [point(term)[0] for term in terms]
        given = {s: point(s) for s in covering.symbols}
        beta = [point(value) for value in base.expressions]
        force, _ = point.beside({**given, **dict(zip(symbols, beta, strict=True))})(reduced)
        if point.is_real and abs(sum(values) - force) > allowed * sum(map(abs, values)):
            found.append({s: x for s, (x, _) in given.items()})

    for point in covering.cycle(_FIRST_CYCLE):
        try:
            look(point)
        except CANNOT:
            continue
        if len(found) == _MOST_POINTS:
            break
    return found
