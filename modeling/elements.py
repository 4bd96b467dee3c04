"""Forces that resist the motion, as SymPy expressions.

Each stands on the inertia's side of the force balance, so that a positive parameter opposes a
positive velocity or displacement: ``tau = inertia * ddq + sum of resistances``.
"""

import sympy

from .symbols import Coordinate, Parameter


def viscous(coefficient: Parameter, coordinate: Coordinate) -> sympy.Expr:
    """Viscous friction ``Fv dq``, N or N m."""
    return coefficient * coordinate.velocity


def coulomb(level: Parameter, coordinate: Coordinate) -> sympy.Expr:
    """Coulomb friction ``Fc sign(dq)``, set-valued at rest: the axis can stick."""
    return level * sympy.sign(coordinate.velocity)


def offset(level: Parameter) -> sympy.Expr:
    """A constant force: amplifier offset, constant gravity, unequal friction."""
    return level.symbol


def spring(stiffness: Parameter, coordinate: Coordinate, rest: float = 0.0) -> sympy.Expr:
    """Linear spring ``k (q - rest)``; `rest` in the coordinate's unit."""
    return stiffness * (coordinate.symbol - sympy.Float(rest) if rest else coordinate.symbol)
