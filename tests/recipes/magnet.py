"""A drive whose force is not its gain times the control."""

from dataclasses import dataclass

import sympy

from axisid.elements import CONTROL, DRIVE_GAIN, FORCE, Drive


@dataclass(frozen=True, slots=True, kw_only=True)
class Magnet(Drive):
    """A force by the square of the current; the gain is in N/A^2."""

    @property
    def force(self) -> sympy.Expr:
        return DRIVE_GAIN * CONTROL * sympy.Abs(CONTROL)

    @property
    def inverse(self) -> sympy.Expr:
        return sympy.sign(FORCE / DRIVE_GAIN) * sympy.sqrt(sympy.Abs(FORCE / DRIVE_GAIN))
