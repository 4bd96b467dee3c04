"""A motor whose force falls with the speed, and a gear that takes its share of the power."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import sympy

from axisid.modeling.declaration import DRIVE_GAIN, Drive, unit_table
from axisid.modeling.quantities import (
    CONTROL,
    DIRECTION,
    FORCE,
    VELOCITY,
    Coordinate,
    Signal,
    expression,
    extreme,
    number,
    settle,
    signals_in,
    with_numbers,
    written,
)
from axisid.support.errors import ModelError, quoted

from .figures import GearedUnits
from .formula import check_formula

#: Of a gear; a worm that holds itself passes on some tenths.
LEAST_EFFICIENCY = 0.01
_BACK_EMF = sympy.Symbol("back_emf", real=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorDrive(Drive):
    """A motor behind a gear: ``gain (control - back_emf * velocity)``, as the gear passes it on.

    Attributes
    ----------
    back_emf : float
        Control that the motion itself takes, in the control's unit over the velocity's; 0 for a
        motor whose current is controlled, or whose back-EMF is in the equation of motion.
    reach : expression
        The largest force of the motor forwards, before the gear's loss, from the velocity, as
        `VELOCITY` or the coordinate's; backwards it is as large at the opposite velocity. Infinite
        for none.
    efficiency : float
        Of the gear, 0.01 to 1. Where the motor drives, the load gets `efficiency` times its
        force; where the load drives the motor, its force over `efficiency`.
    unknown_back_emf : bool
        Whether the motor has a back-EMF that is not declared here.
    geared : GearedUnits
        Units of the figures that it was made of.

    Notes
    -----
    The gear's loss is a friction in proportion to the motor's force, and as set-valued at rest as
    Coulomb friction: a load within ``efficiency`` and its reciprocal of what balances it is held.
    The inertia that the load feels of the motor is in the equation of motion, and so on the load's
    side of the loss.
    """

    back_emf: float = 0.0
    reach: sympy.Expr = sympy.oo
    efficiency: float = 1.0
    unknown_back_emf: bool = False
    geared: GearedUnits = field(default_factory=GearedUnits)

    def __post_init__(self) -> None:
        settle(
            self,
            back_emf=number(self.back_emf, "the drive's back-EMF"),
            efficiency=checked_efficiency(self.efficiency),
            reach=checked_reach(self.reach),
        )
        Drive.__post_init__(self)  # it looks at the force
        if self.logged == "current" and self.back_emf:
            raise ModelError(
                "logged='current' is a current, and the control of a drive with a back-EMF is a "
                "voltage; give the current as the axis's force, times kt and ratio, or declare "
                "current_drive(...) with its control.",
                code="drive",
            )

    @property
    def force(self) -> sympy.Expr:
        """Force by control, velocity and friction direction."""
        scaled = CONTROL * with_numbers(self.scaled_by)
        driving = scaled - _BACK_EMF * VELOCITY if self.back_emf else scaled
        return self._behind_gear(self._within_reach(DRIVE_GAIN * driving))

    @property
    def inverse(self) -> sympy.Expr:
        """Control by the force, whatever the limits."""
        driving = FORCE
        if self.efficiency != 1:
            mean, half = self._shares
            driving = FORCE / (mean - DIRECTION * half * sympy.sign(FORCE))
        control = driving / DRIVE_GAIN
        if self.back_emf:
            control += _BACK_EMF * VELOCITY
        return control / with_numbers(self.scaled_by)

    @property
    def constants(self) -> Mapping[sympy.Symbol, float]:
        """The gain, and the back-EMF if there is one."""
        return {DRIVE_GAIN: self.gain, **({_BACK_EMF: self.back_emf} if self.back_emf else {})}

    @property
    def _shares(self) -> tuple[sympy.Expr, sympy.Expr]:
        """Mean of what a gear passes on driven back and driving, and half the difference."""
        driving, back = self.efficiency, 1 / self.efficiency
        return sympy.Float((back + driving) / 2), sympy.Float((back - driving) / 2)

    def _within_reach(self, force: sympy.Expr) -> sympy.Expr:
        if self.reach == sympy.oo:
            return force
        reach = with_numbers(self.reach)
        # What is no number and no recorded signal is the velocity, of whatever name.
        opposite = reach.xreplace({s: -s for s in reach.free_symbols - signals_in(reach)})
        return extreme(sympy.Max, [extreme(sympy.Min, [force, reach]), -opposite])

    def _behind_gear(self, force: sympy.Expr) -> sympy.Expr:
        if self.efficiency == 1:
            return force
        mean, half = self._shares
        return mean * force - DIRECTION * half * sympy.Abs(force)

    def force_text(self, coordinate: Coordinate, digits: int = 6) -> str:
        """What the force is, in words."""
        if self.is_gain:
            return f"{self.gain_text(coordinate, digits)} times the control"
        control = "the control"
        if self.back_emf:
            unit = f"{self.unit}/({coordinate.velocity_unit})"
            emf = f"{self.back_emf:.{digits}g} {unit} times {coordinate.velocity}"
            control = f"what {emf} leaves of the control"
        said = f"{self.gain_text(coordinate, digits)} times {control}"
        if self.reach != sympy.oo:
            reach = written(self.reach.xreplace(self.along(coordinate)), coordinate)
            said += f", forwards at most {reach} {coordinate.force_unit}, backwards as much at "
            said += f"-{coordinate.velocity}"
        if self.efficiency != 1:
            said += f", of which a gear of efficiency {self.efficiency:g} takes its share, by the "
            said += "direction of the power"
        return said

    def check_on(self, coordinate: Coordinate, signals: Iterable[Signal]) -> None:
        """Refuse figures that do not fit the axis, and a reach that is no force."""
        self.geared.check_on(coordinate)
        if self.reach != sympy.oo:
            units = unit_table(coordinate, signals)
            units[VELOCITY] = units[coordinate.velocity]
            del units[coordinate.symbol], units[coordinate.acceleration]
            check_formula(self.reach, "reach", units, coordinate.force_unit)

    @property
    def remark(self) -> str:
        """Where a back-EMF is that is not the drive's."""
        if not self.unknown_back_emf:
            return ""
        return (
            "the drive is without the motor's back-EMF: its braking, kt ke ratio^2/R times the "
            "velocity, is in the equation of motion, where no motion tells it from viscous friction"
        )


def checked_efficiency(value: float) -> float:
    """An efficiency, from the least that a gear has to 1.

    Raises
    ------
    ModelError
        It is none.
    """
    efficiency = number(value, "the gear's efficiency")
    if not LEAST_EFFICIENCY <= efficiency <= 1:
        raise ModelError(
            f"the gear's efficiency is {quoted(value)}; give a number from {LEAST_EFFICIENCY:g} to "
            "1, such as 0.7: the share of the motor's power that the load gets.",
            code="drive",
        )
    return efficiency


def checked_reach(value: sympy.Expr | float) -> sympy.Expr:
    """A largest force that is above 0 at rest, as far as numbers tell it.

    Raises
    ------
    ModelError
        It is none.
    """
    reach = expression(value, "the drive's reach")
    plain = with_numbers(reach)
    at_rest = plain.xreplace(dict.fromkeys(plain.free_symbols - signals_in(plain), sympy.S.Zero))
    if at_rest.is_number and at_rest.evalf().is_extended_positive is not True:
        raise ModelError(
            f"the drive's reach {reach} is {at_rest} at rest; give the largest force of the motor "
            "forwards, above 0 there.",
            code="drive",
        )
    return reach
