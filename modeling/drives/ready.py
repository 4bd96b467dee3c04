"""Drives from the data sheet of a motor and its gear."""

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

import sympy

from axisid.modeling.declaration import Drive
from axisid.modeling.quantities import VELOCITY, expression
from axisid.support.errors import ModelError

from .figures import (
    Figure,
    GearedUnits,
    check_control,
    check_current,
    check_others,
    figure,
    gear_ratio,
)
from .motor import MotorDrive


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
    check_control(unit, volts)
    geared = GearedUnits.of(kt, ke, ratio)
    n, ohms = gear_ratio(ratio), figure(resistance, "the resistance", "V/A")
    scale = figure(volts, "volts")
    return MotorDrive(
        gain=figure(kt, "kt") * n * scale / ohms,
        unit=unit,
        back_emf=0.0 if ke is None else figure(ke, "ke") * n / scale,
        efficiency=efficiency,
        unknown_back_emf=ke is None,
        lag=figure(inductance, "the inductance", "V s/A", positive=False) / ohms,
        geared=geared,
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
    check_current(unit)
    geared = GearedUnits.of(kt, ke, ratio)
    n = gear_ratio(ratio)
    gain = figure(kt, "kt") * n
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
        emf = n * figure(kt if ke is None else ke, "kt" if ke is None else "ke")
        most = sympy.Float(abs(gain) / ohms * volts) - sympy.Float(gain / ohms * emf) * VELOCITY
    return MotorDrive(
        gain=gain, unit=unit, reach=most, efficiency=efficiency, geared=geared, **others
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
