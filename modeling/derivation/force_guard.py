"""The last look at a derivation: the force in base parameters is the declared force.

The points are others than those at which the base parameters were found, and cover the functions of
both forces in the same way.
"""

import sympy

from axisid.modeling.quantities import CANNOT, CoveringPoints, Points
from axisid.support.errors import ModelError

from .base_model import BaseModel

_FIRST_CYCLE = 1000  # beyond those of the derivation
_EXACT, _ROUNDED = 1e-30, 1e-11  # shares of the terms by which the forces may differ


def check_force(base: BaseModel, declared: sympy.Expr, reduced: sympy.Expr) -> None:
    """Compare the declared force with the force in base parameters.

    Parameters
    ----------
    base : BaseModel
    declared, reduced : sympy.Expr
        Both forces, by the friction direction.

    Raises
    ------
    ModelError
        They differ.
    """
    velocity = base.declared.coordinate.velocity
    forces = (declared, reduced)
    covering = CoveringPoints(Points(*forces, velocity=velocity), forces)
    allowed = _ROUNDED if base.rounded else _EXACT
    symbols = [p.symbol for p in base.axis.parameters]
    terms = sympy.Add.make_args(declared)
    for point in covering.cycle(_FIRST_CYCLE):
        try:
            values = [point(term)[0] for term in terms]
            given = {s: point(s) for s in covering.symbols}
            beta = [point(value) for value in base.expressions]
            force, _ = point.beside({**given, **dict(zip(symbols, beta, strict=True))})(reduced)
        except CANNOT:
            continue
        if not point.is_real:
            continue
        if abs(sum(values) - force) > allowed * sum(map(abs, values)):
            place = ", ".join(f"{s} = {float(x):.6g}" for s, (x, _) in given.items())
            raise ModelError(
                f"the force in base parameters is not the declared force where {place}. This is "
                "an error of the program: report it together with the axis.",
                code="equation",
            )
