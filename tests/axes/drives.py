"""Drives whose force is no gain alone."""

from dataclasses import dataclass, replace

import sympy

from axisid import Axis
from axisid.elements import Drive
from axisid.modeling.quantities import FORCE

BRAKE = 40.0  # N/(m/s)


@dataclass(frozen=True, slots=True, kw_only=True)
class BrakedDrive(Drive):
    """A voltage-driven motor: its own motion takes from the force."""

    velocity: sympy.Symbol
    brake: float = BRAKE

    @property
    def force(self) -> sympy.Expr:
        return Drive.force.fget(self) - self.brake * self.velocity  # type: ignore[attr-defined]

    @property
    def inverse(self) -> sympy.Expr:
        inverse: sympy.Expr = Drive.inverse.fget(self)  # type: ignore[attr-defined]
        return inverse.subs(FORCE, FORCE + self.brake * self.velocity)


def braked(
    axis: Axis, *, scale: float = 1.0, relative_sd: float = 0.0, brake: float = BRAKE
) -> Axis:
    """The axis with a braked drive of `scale` times its gain."""
    drive = BrakedDrive(
        gain=scale * axis.drive.gain,
        unit=axis.drive.unit,
        limit=axis.drive.limit,
        relative_sd=relative_sd,
        velocity=axis.coordinate.velocity,
        brake=brake,
    )
    return replace(axis, drive=drive)


@dataclass(frozen=True, slots=True, kw_only=True)
class Varying(Drive):
    """A motor whose force constant depends on the position."""

    position: sympy.Symbol
    share: float = 0.3  # of the gain, per unit of position

    @property
    def force(self) -> sympy.Expr:
        gain_force: sympy.Expr = Drive.force.fget(self)  # type: ignore[attr-defined]
        return gain_force * (1 + self.share * sympy.sin(self.position))

    @property
    def inverse(self) -> sympy.Expr:
        inverse: sympy.Expr = Drive.inverse.fget(self)  # type: ignore[attr-defined]
        return inverse / (1 + self.share * sympy.sin(self.position))


def varying(axis: Axis) -> Axis:
    """The axis with a drive of the same gain at position 0 only."""
    given = axis.drive
    drive = Varying(
        gain=given.gain, unit=given.unit, limit=given.limit, position=axis.coordinate.symbol
    )
    return replace(axis, drive=drive)
