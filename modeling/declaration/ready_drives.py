"""Drives from the data sheet of a motor and its gear, and of two formulas."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import sympy

from axisid.modeling.quantities import (
    CONTROL,
    FORCE,
    VELOCITY,
    Coordinate,
    Signal,
    Symbolic,
    expression,
    parse_unit,
    with_numbers,
)
from axisid.support.errors import ModelError, refuse

from .drive import DRIVE_GAIN, Drive
from .motor import (
    KE_UNITS,
    KT_UNITS,
    RATIO_UNITS,
    Figure,
    MotorDrive,
    check_formula,
    check_others,
    figure,
    own_unit,
)
from .unit_check import unit_table


@dataclass(frozen=True, slots=True, kw_only=True)
class FormulaDrive(Drive):
    """A drive by its formulas; made by `formula_drive`.

    Attributes
    ----------
    made : expression
        The force, by `CONTROL`, the motion, recorded signals and `DRIVE_GAIN`.
    undone : expression
        The control, by `FORCE` and the same.
    """

    made: sympy.Expr
    undone: sympy.Expr

    @property
    def force(self) -> sympy.Expr:
        """Force by the control and the motion."""
        return with_numbers(self.made)

    @property
    def inverse(self) -> sympy.Expr:
        """Control by the force and the motion."""
        return with_numbers(self.undone)

    @property
    def constants(self) -> Mapping[sympy.Symbol, float]:
        """The gain, where it stands in the formulas."""
        used = self.made.free_symbols | self.undone.free_symbols
        return {DRIVE_GAIN: self.gain} if DRIVE_GAIN in used else {}

    def check_on(self, coordinate: Coordinate, signals: Iterable[Signal]) -> None:
        """Refuse formulas in other units than the axis's force and the control's."""
        force, control = coordinate.force_unit, parse_unit(self.unit)
        units = unit_table(coordinate, signals)
        units |= {general: units[own] for general, own in self.along(coordinate).items()}
        units |= {CONTROL: control, FORCE: force, DRIVE_GAIN: force / control}
        for what, value, wanted in (
            ("force", self.made, force),
            ("inverse", self.undone, control),
        ):
            check_formula(value, what, units, wanted)


def formula_drive(
    force: sympy.Expr | Symbolic,
    inverse: sympy.Expr | Symbolic | None = None,
    *,
    unit: str = "V",
    gain: float = 1.0,
    **others: Any,
) -> Drive:
    """A drive by its force as an expression, and by the control that makes a force.

    Parameters
    ----------
    force : expression
        Of `CONTROL`, the coordinate and its velocity (or `POSITION` and `VELOCITY`), constants,
        recorded signals, and `DRIVE_GAIN` for the gain if it has one.
    inverse : expression, optional
        The control of which the drive makes `FORCE`, of the same. By default what follows from a
        force that is a straight line over the control. The two are compared by numbers when the
        axis is derived.
    unit : str
        Of the control.
    gain : float
        What `DRIVE_GAIN` is.
    **others
        Of `Drive`: limit, relative_sd (of the gain), lag, delay, logged, profile.

    Returns
    -------
    FormulaDrive
        A force that depends on the motion follows it between the samples of a sampled law.

    Raises
    ------
    ModelError
        There is no inverse, and none follows.
    """
    check_others("formula_drive", others)
    made = expression(force, "the drive's force")
    undone = _solved(made) if inverse is None else expression(inverse, "the drive's inverse")
    return FormulaDrive(made=made, undone=undone, unit=unit, gain=gain, **others)


def _solved(force: sympy.Expr) -> sympy.Expr:
    """The inverse of a force that is a straight line over the control.

    Raises
    ------
    ModelError
        It is none.
    """
    slope = force.diff(CONTROL)
    if slope == 0 or slope.has(CONTROL):
        raise ModelError(
            f"the drive's force {force} is no straight line over the control, so that its inverse "
            "does not follow; give it, the control by tau.",
            code="drive",
        )
    return (FORCE - force.xreplace({CONTROL: sympy.S.Zero})) / slope


def voltage_drive(
    *,
    kt: Figure,
    resistance: Figure,
    ke: Figure | None = None,
    ratio: Figure = 1.0,
    efficiency: float = 1.0,
    inductance: Figure = 0.0,
    volts: Figure = 1.0,
    unit: str = "V",
    **others: Any,
) -> Drive:
    """A motor on a voltage or a PWM: ``tau = kt n (volts u - ke n dq) / R``, n the gear ratio.

    Parameters
    ----------
    kt : float or Constant
        Torque constant, N m/A; of a linear motor its force constant, N/A.
    resistance : float or Constant
        R, of the winding from terminal to terminal, amplifier and wires included, V/A.
    ke : float or Constant, optional
        Back-EMF constant, V/(rad/s), in SI the same as kt; of a linear motor V/(m/s). Without it
        the back-EMF is no part of the drive: its braking ``kt ke n^2 / R`` is in the viscous
        friction that is identified, or in an element `back_emf` with a parameter of its own.
    ratio : float or Constant
        n, the motor's angle over the coordinate: rad/m, or a plain number on a rotary axis;
        negative where the motor turns the other way.
    efficiency : float
        Of the gear, 0.01 to 1: where the motor drives, the load gets so much of its force; where
        the load drives the motor, it feels the motor's force over this.
    inductance : float or Constant
        L of the winding, V s/A: the current follows with a lag ``L / R``.
    volts : float or Constant
        Voltage for a control of 1: 1 for a voltage, the supply for a duty from -1 to 1.
    unit : str
        Of the control: a voltage's, or 1; another where volts is a `Constant` in V over it.
    **others
        Of `Drive`: limit, relative_sd, scaled_by (a recorded supply over its nominal value), delay,
        logged, profile.

    Returns
    -------
    MotorDrive
        Its braking follows the motion between the samples of a sampled law; with an inductance the
        motion's part is held over each sample, at its middle.

    Raises
    ------
    ModelError
        A figure is out of range or in another unit.

    References
    ----------
    [Krishnan2001]_, section 2.3.
    """
    _check_free(others, gain="kt, ratio and resistance", lag="inductance and resistance")
    check_others("voltage_drive", others)
    control, volt = parse_unit(unit), parse_unit("V")
    own = own_unit(volts)
    refuse(
        ModelError,
        (
            own is not None and not own.same_dimension(volt / control),
            f"volts is in {own}; give the voltage for a control of 1 {unit}, in {volt / control}",
        ),
        (
            own is None and not any(control.same_dimension(u) for u in (volt, parse_unit("1"))),
            f"the control of a voltage drive is in {unit}; give a voltage, unit='V', or a duty, "
            "unit='1', or volts as a Constant in V over the control's unit; of a current, "
            "current_drive(...)",
        ),
        code="drive",
    )
    motor, n = (
        figure(kt, "kt", *KT_UNITS),
        figure(ratio, "the gear ratio", *RATIO_UNITS, signed=True),
    )
    ohms, scale = figure(resistance, "the resistance", "V/A"), figure(volts, "volts")
    return MotorDrive(
        gain=motor * n * scale / ohms,
        unit=unit,
        back_emf=0.0 if ke is None else figure(ke, "ke", *KE_UNITS) * n / scale,
        efficiency=efficiency,
        unknown_back_emf=ke is None,
        lag=figure(inductance, "the inductance", "V s/A", positive=False) / ohms,
        figures=(kt, ke, ratio),
        **others,
    )


def current_drive(
    *,
    kt: Figure,
    ratio: Figure = 1.0,
    efficiency: float = 1.0,
    supply: Figure = math.inf,
    resistance: Figure | None = None,
    ke: Figure | None = None,
    reach: sympy.Expr | float | None = None,
    unit: str = "A",
    **others: Any,
) -> Drive:
    """A motor on a controlled current: ``tau = kt n u`` as far as its supply reaches.

    Parameters
    ----------
    kt, ratio, efficiency
        As of `voltage_drive`.
    supply : float or Constant
        Largest voltage at the winding, V: forwards the force is at most ``kt n (supply - ke n dq) /
        R``, backwards as much at the opposite velocity. Infinite for none.
    resistance, ke : float or Constant, optional
        As of `voltage_drive`, for the supply's limit, without which there is neither; ke is kt by
        default.
    reach : expression, optional
        In place of the last three: the largest force forwards by the velocity, such as the torque
        curve of a data sheet, of `VELOCITY` or the coordinate's; above 0 at rest.
    unit : str
        Of the control, a current's.
    **others
        Of `Drive`: limit, relative_sd, lag, delay, logged, profile.

    Returns
    -------
    MotorDrive

    Raises
    ------
    ModelError
        A figure is out of range or in another unit, or the limit is given twice or in part.

    References
    ----------
    [Krishnan2001]_, section 2.3.
    """
    _check_free(others, gain="kt and ratio")
    check_others("current_drive", others)
    if not parse_unit(unit).same_dimension(parse_unit("A")):
        raise ModelError(
            f"the control of a current drive is in {unit}; give a current, unit='A', or declare "
            "Drive(gain=..., unit=...) with the force for a control of 1.",
            code="drive",
        )
    n = figure(ratio, "the gear ratio", *RATIO_UNITS, signed=True)
    gain = figure(kt, "kt", *KT_UNITS) * n
    volts = figure(supply, "the supply", "V", finite=False)
    has_supply, has_reach = math.isfinite(volts), reach is not None
    of_supply = (has_supply, resistance is not None)
    if (has_supply and has_reach) or len({*of_supply, has_supply or ke is not None}) > 1:
        raise ModelError(
            "the force that the supply allows is given "
            + ("twice, by supply and by reach" if has_supply and has_reach else "in part")
            + "; give supply and resistance (and ke where it is not kt), or reach alone.",
            code="drive",
        )
    most = sympy.oo if reach is None else expression(reach, "the drive's reach")
    if resistance is not None:
        ohms = figure(resistance, "the resistance", "V/A")
        emf = gain if ke is None else n * figure(ke, "ke", *KE_UNITS)
        most = sympy.Float(abs(gain) / ohms * volts) - sympy.Float(gain / ohms * emf) * VELOCITY
    return MotorDrive(
        gain=gain, unit=unit, reach=most, efficiency=efficiency, figures=(kt, ke, ratio), **others
    )


def _check_free(others: dict[str, Any], **made_of: str) -> None:
    """Refuse what a drive makes of other figures."""
    for name, figures in made_of.items():
        if name in others:
            raise ModelError(
                f"the drive's {name} is that of {figures}, and given too; leave it out, or "
                "declare a Drive with it.",
                code="drive",
            )


#: The drives that ship, as TOML declarations know them.
DRIVES: Mapping[str, Callable[..., Drive]] = MappingProxyType(
    {drive.__name__: drive for drive in (voltage_drive, current_drive)}
)
