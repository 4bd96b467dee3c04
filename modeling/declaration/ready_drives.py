"""Drives from the data sheet of a motor and its gear, and from formulas.

The force of a motor on a voltage falls with the speed, and its gear has losses. A *figure* is a
value of a data sheet: a number, or a constant whose unit is checked, including the gear.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any, TypeAlias

import sympy

from axisid.modeling.quantities import (
    CONTROL,
    DIRECTION,
    FORCE,
    VELOCITY,
    Constant,
    ConstantSymbol,
    Coordinate,
    Signal,
    Symbolic,
    Unit,
    expression,
    extreme,
    number,
    parse_unit,
    settle,
    signals_in,
    with_numbers,
    written,
)
from axisid.support.checks import refuse
from axisid.support.errors import ModelError
from axisid.support.wording import quoted

from .drive import DRIVE_GAIN, Drive
from .unit_check import check_unit, unit_table

#: Value of a data sheet: a plain number in the expected unit, or a `Constant` with its own unit.
Figure: TypeAlias = float | Constant | ConstantSymbol


#: Permitted units of the torque or force constant, the back-EMF constant and the gear ratio.
KT_UNITS, KE_UNITS, RATIO_UNITS = ("N m/A", "N/A"), ("V/(rad/s)", "V/(m/s)"), ("1", "rad/m")


def figure(
    value: Figure,
    what: str,
    *units: str,
    positive: bool = True,
    finite: bool = True,
    signed: bool = False,
) -> float:
    """Return a data-sheet figure as a number.

    A gear ratio may be negative, which means that the motor turns in the opposite direction.

    Parameters
    ----------
    value : Figure
    what : str
        Name of the figure, for messages.
    *units : str
        Permitted units of a constant; none for any unit.
    positive : bool
        Whether the number must not be 0.
    finite : bool
        Whether the number must be finite.
    signed : bool
        Whether the number may be negative.

    Raises
    ------
    ModelError
        The figure is not a number, is out of range, or is a constant in another unit.
    """
    own, found = own_unit(value), number(_number(value), what, finite=finite)
    fits = own is None or not units or any(own.same_dimension(parse_unit(u)) for u in units)
    expected = "a positive number" if positive else "a number of 0 or more"
    if signed:
        expected = "a number other than 0"
    refuse(
        ModelError,
        (not fits, f"{what} is in {own}. Give {what} in {' or '.join(units)}"),
        (
            (found < 0 and not signed) or (positive and not found),
            f"{what} is {quoted(value)}. Give {expected}",
        ),
        code="drive",
    )
    return found


def check_others(made_by: str, others: Mapping[str, Any], *made: str) -> None:
    """Refuse an argument that `Drive` does not have, or that follows from the figures.

    Parameters
    ----------
    made_by : str
        Name of the function that makes the drive.
    others : mapping
        Arguments to be passed on to `Drive`.
    *made : str
        Arguments of `Drive` that the function computes itself.

    Raises
    ------
    ModelError
        There is such an argument.
    """
    own = ("gain", "unit", "estimated", *made)
    known = [f.name for f in fields(Drive) if f.name not in own]
    if unknown := [name for name in others if name not in known]:
        raise ModelError(
            f"{made_by} has no argument {unknown[0]!r}. Use the arguments of {made_by}, or "
            f"{', '.join(known)}.",
            code="drive",
        )


def check_gear(coordinate: Coordinate, kt: Figure, ke: Figure | None, ratio: Figure) -> None:
    """Refuse units of motor figures with which the gear would count twice, or not at all.

    Plain numbers have no unit to be checked.

    Parameters
    ----------
    coordinate : Coordinate
    kt, ke, ratio : Figure
        Torque or force constant, back-EMF constant (None if it is not given), and gear ratio.

    Raises
    ------
    ModelError
        kt or ke is relative to the coordinate although a ratio is given, or relative to the motor
        although no ratio is given; or the ratio is in another unit.
    """
    is_geared, of_ratio, wanted = _number(ratio) != 1, own_unit(ratio), f"rad/{coordinate.unit}"
    is_wrong_ratio = of_ratio is not None and not of_ratio.same_dimension(parse_unit(wanted))
    for name, figure_, own in (
        ("kt", kt, coordinate.force_unit / parse_unit("A")),
        ("ke", ke, parse_unit("V") / coordinate.velocity_unit),
    ):
        unit = own_unit(figure_)
        if unit is None:
            continue
        is_own = unit.same_dimension(own)  # relative to the coordinate
        is_twice = is_own and is_geared and coordinate.unit == "m"
        if is_wrong_ratio or is_twice or not (is_own or is_geared):
            geared = f"a gear ratio in {of_ratio or 'no unit'}" if is_geared else "no gear"
            raise ModelError(
                f"{name} is in {unit}, with {geared} on a coordinate in {coordinate.unit}. Give "
                f"the motor's own {name} and ratio=... in {wanted} (motor angle divided by the "
                f"coordinate), or give {name} in {own} without a ratio.",
                code="drive",
            )


def own_unit(value: Figure | None) -> Unit | None:
    """Return the unit of a figure; None for a plain number, which has the expected unit."""
    symbol = value.symbol if isinstance(value, Constant) else value
    return symbol.unit if isinstance(symbol, ConstantSymbol) else None


def _number(value: Figure) -> float:
    """Return the number of a figure, without its unit."""
    return value.value if isinstance(value, (Constant, ConstantSymbol)) else value


def check_formula(
    value: sympy.Expr, what: str, units: Mapping[sympy.Symbol, Unit], wanted: Unit
) -> None:
    """Refuse a formula of a drive with a symbol that is not allowed, or in another unit.

    Parameters
    ----------
    value : sympy.Expr
    what : str
        Name of the formula, for messages: ``force``, ``inverse`` or ``reach``.
    units : mapping of sympy.Symbol to Unit
        Units of the allowed symbols.
    wanted : Unit
        Unit that the formula must have.

    Raises
    ------
    ModelError
        The formula has such a symbol, or is in another unit.
    """
    if unknown := sorted(map(str, value.free_symbols - set(units) - value.atoms(ConstantSymbol))):
        raise ModelError(
            f"the drive's {what} has the unknown symbols {', '.join(unknown)}. Use only the "
            "control, the motion, constants and declared signals.",
            code="drive",
        )
    is_plain = not value.atoms(ConstantSymbol)  # a formula of plain numbers may have any unit
    try:
        check_unit(value, wanted, units, f"the drive's {what} {value}", of_numbers=is_plain)
    except ModelError as error:
        raise ModelError(str(error), code="drive") from error


#: Lowest permitted efficiency of a gear; a self-locking worm gear has some tenths.
LEAST_EFFICIENCY = 0.01
_BACK_EMF = sympy.Symbol("back_emf", real=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorDrive(Drive):
    """A motor with a gear: ``gain (control - back_emf * velocity)``, reduced by the gear's loss.

    Attributes
    ----------
    back_emf : float
        Control per velocity that compensates the back-EMF, in the control's unit over the
        velocity's unit; 0 for a motor whose current is controlled, or whose back-EMF is in the
        equation of motion.
    reach : expression
        Largest forward force of the motor, before the gear's loss, as a function of the velocity,
        `VELOCITY` or that of the coordinate. The largest backward force has the same size at the
        opposite velocity. Infinite for no limit.
    efficiency : float
        Efficiency of the gear, 0.01 to 1. If the motor drives the load, the load gets `efficiency`
        times the motor's force; if the load drives the motor, the load gets the motor's force
        divided by `efficiency`.
    unknown_back_emf : bool
        Whether the motor has a back-EMF that is not declared with the drive.
    figures : (Figure, Figure or None, Figure)
        kt, ke and the gear ratio from which the drive was made; their units are checked on an axis.
        ke is None if it is not given.

    Notes
    -----
    The gear's loss is a friction proportional to the motor's force, and set-valued at rest like
    Coulomb friction: a load is held at rest if it is between `efficiency` times the motor's force
    and the motor's force divided by `efficiency`. The inertia of the motor as reflected to the load
    is in the equation of motion, and so on the load's side of the loss.
    """

    back_emf: float = 0.0
    reach: sympy.Expr = sympy.oo
    efficiency: float = 1.0
    unknown_back_emf: bool = False
    figures: tuple[Figure, Figure | None, Figure] = (1.0, None, 1.0)

    def __post_init__(self) -> None:
        settle(
            self,
            back_emf=number(self.back_emf, "the drive's back-EMF"),
            efficiency=number(self.efficiency, "the gear's efficiency"),
            reach=expression(self.reach, "the drive's reach"),
        )
        # The reach at velocity 0; it is not checked if it contains recorded signals.
        plain = with_numbers(self.reach)
        still = dict.fromkeys(plain.free_symbols - signals_in(plain), sympy.S.Zero)
        at_rest = plain.xreplace(still)
        refuse(
            ModelError,
            (
                not LEAST_EFFICIENCY <= self.efficiency <= 1,
                f"the gear's efficiency is {self.efficiency:g}. Give the share of the motor's "
                f"power that reaches the load, from {LEAST_EFFICIENCY:g} to 1, such as 0.7",
            ),
            (
                at_rest.is_number and at_rest.evalf().is_extended_positive is not True,
                f"the drive's reach {self.reach} is {at_rest} at rest. Give the largest forward "
                "force of the motor, which must be above 0 at rest",
            ),
            code="drive",
        )
        Drive.__post_init__(self)  # last, because it uses the force
        if self.logged == "current" and self.back_emf:
            raise ModelError(
                "logged='current' is a current, but the control of a drive with a back-EMF is a "
                "voltage. Record the current times kt and ratio as the force of the axis, or "
                "declare current_drive(...) with the current as control.",
                code="drive",
            )

    @property
    def force(self) -> sympy.Expr:
        """Force as a function of the control, the velocity and the friction direction."""
        scaled = CONTROL * with_numbers(self.scaled_by)
        driving = scaled - _BACK_EMF * VELOCITY if self.back_emf else scaled
        force = DRIVE_GAIN * driving
        if self.reach != sympy.oo:
            reach = with_numbers(self.reach)
            # Every symbol that is not a recorded signal is the velocity.
            opposite = reach.xreplace({s: -s for s in reach.free_symbols - signals_in(reach)})
            force = extreme(sympy.Max, [extreme(sympy.Min, [force, reach]), -opposite])
        if self.efficiency == 1:
            return force
        mean, half = self._shares
        return mean * force - DIRECTION * half * sympy.Abs(force)

    @property
    def inverse(self) -> sympy.Expr:
        """Return the control as a function of the force, ignoring the limits."""
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
        """Return the gain, and the back-EMF if there is one."""
        return {DRIVE_GAIN: self.gain, **({_BACK_EMF: self.back_emf} if self.back_emf else {})}

    @property
    def _shares(self) -> tuple[sympy.Expr, sympy.Expr]:
        """Return the mean, and half the difference, of the gear's two force factors.

        The factors are the reciprocal of the efficiency if the load drives the motor, and the
        efficiency if the motor drives the load.
        """
        driving, driven = self.efficiency, 1 / self.efficiency
        return sympy.Float((driven + driving) / 2), sympy.Float((driven - driving) / 2)

    def force_text(self, coordinate: Coordinate, digits: int = 6) -> str:
        """Return a description of the force, with its reach and the efficiency of the gear."""
        control = "the control"
        if self.back_emf:
            unit = f"{self.unit}/({coordinate.velocity_unit})"
            emf = f"{self.back_emf:.{digits}g} {unit} times {coordinate.velocity}"
            control = f"the control minus {emf}"
        text = f"{self.gain_text(coordinate, digits)} times {control}"
        if self.reach != sympy.oo:
            reach = written(self.reach.xreplace(self.along(coordinate)), coordinate)
            text += (
                f", at most {reach} {coordinate.force_unit} forwards, and the same backwards at "
                f"-{coordinate.velocity}"
            )
        if self.efficiency != 1:
            text += (
                f", reduced by a gear of efficiency {self.efficiency:g} according to the "
                "direction of the power"
            )
        return text

    def check_on(self, coordinate: Coordinate, signals: Iterable[Signal]) -> None:
        """Refuse figures whose units do not fit the axis, and a reach that is not a force."""
        check_gear(coordinate, *self.figures)
        if self.reach != sympy.oo:
            units = unit_table(coordinate, signals)
            units[VELOCITY] = units[coordinate.velocity]
            del units[coordinate.symbol], units[coordinate.acceleration]
            check_formula(self.reach, "reach", units, coordinate.force_unit)

    @property
    def remark(self) -> str:
        """Return a note on a back-EMF that is not declared with the drive; empty otherwise."""
        if not self.unknown_back_emf:
            return ""
        return (
            "the drive is declared without the motor's back-EMF: the braking force of the "
            "back-EMF, kt ke ratio^2/R times the velocity, is in the equation of motion, where it "
            "cannot be distinguished from viscous friction"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class FormulaDrive(Drive):
    """A drive declared by formulas; made by `formula_drive`.

    Attributes
    ----------
    made : expression
        The force as a function of `CONTROL`, the motion, recorded signals and `DRIVE_GAIN`.
    undone : expression
        The inverse: the control as a function of `FORCE` and the same symbols.
    """

    made: sympy.Expr
    undone: sympy.Expr

    @property
    def force(self) -> sympy.Expr:
        """Force as a function of the control and the motion."""
        return with_numbers(self.made)

    @property
    def inverse(self) -> sympy.Expr:
        """Return the control as a function of the force and the motion."""
        return with_numbers(self.undone)

    @property
    def constants(self) -> Mapping[sympy.Symbol, float]:
        """Return the gain, if it occurs in the formulas."""
        used = self.made.free_symbols | self.undone.free_symbols
        return {DRIVE_GAIN: self.gain} if DRIVE_GAIN in used else {}

    def check_on(self, coordinate: Coordinate, signals: Iterable[Signal]) -> None:
        """Refuse formulas whose units are not those of the force and of the control."""
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
    """Return a drive declared by its force, and by the control that produces a force.

    Parameters
    ----------
    force : expression
        Force, as a function of `CONTROL`, the coordinate and its velocity (or `POSITION` and
        `VELOCITY`), constants, recorded signals, and `DRIVE_GAIN` for the gain if it has one.
    inverse : expression, optional
        The control for which the drive produces `FORCE`, a function of the same symbols. By default
        it is derived from a force that is linear in the control. Force and inverse are compared
        numerically when the axis is derived.
    unit : str
        Unit of the control.
    gain : float
        Value of `DRIVE_GAIN`.
    **others
        Arguments of `Drive`: limit, relative_sd (of the gain), lag, delay, logged, profile.

    Returns
    -------
    FormulaDrive
        A force that depends on the motion follows it between the samples of a sampled law.

    Raises
    ------
    ModelError
        The inverse is neither given nor can be derived.
    """
    check_others("formula_drive", others)
    made = expression(force, "the drive's force")
    undone = _solved(made) if inverse is None else expression(inverse, "the drive's inverse")
    return FormulaDrive(made=made, undone=undone, unit=unit, gain=gain, **others)


def _solved(force: sympy.Expr) -> sympy.Expr:
    """Return the control as a function of a force that is linear in the control.

    Raises
    ------
    ModelError
        The force is not linear in the control.
    """
    slope = force.diff(CONTROL)
    if slope == 0 or slope.has(CONTROL):
        raise ModelError(
            f"the drive's force {force} is not linear in the control, so its inverse cannot be "
            "derived. Give inverse=..., the control as a function of tau.",
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
    """Return a motor on a voltage or a PWM: ``tau = kt n (volts u - ke n dq) / R``.

    Parameters
    ----------
    kt : float or Constant
        Torque constant, N m/A; for a linear motor the force constant, N/A.
    resistance : float or Constant
        R, of the winding from terminal to terminal, including amplifier and wires, V/A.
    ke : float or Constant, optional
        Back-EMF constant, V/(rad/s), in SI equal to kt; for a linear motor V/(m/s). Without ke, the
        back-EMF is no part of the drive: its braking coefficient ``kt ke n^2 / R`` is contained in
        the identified viscous friction, or in an element `back_emf` with its own parameter.
    ratio : float or Constant
        n, the motor's angle over the coordinate: rad/m, or a plain number on a rotary axis;
        negative if the motor turns in the opposite direction.
    efficiency : float
        Efficiency of the gear, 0.01 to 1: if the motor drives the load, the load gets this share of
        the motor's force; if the load drives the motor, the load gets the motor's force divided by
        the efficiency.
    inductance : float or Constant
        L of the winding, V s/A: the current follows with a lag ``L / R``.
    volts : float or Constant
        Voltage for a control of 1: 1 for a voltage, the supply voltage for a duty cycle from -1
        to 1.
    unit : str
        Unit of the control: V, or 1 for a duty cycle; any unit if `volts` is a `Constant` in V per
        this unit.
    **others
        Arguments of `Drive`: limit, relative_sd, scaled_by (a recorded supply over its nominal
        value), delay, logged, profile.

    Returns
    -------
    MotorDrive
        The braking force follows the motion between the samples of a sampled law. With an
        inductance, the part of the force that depends on the motion is held over each sample, at
        its value in the middle of the sample.

    Raises
    ------
    ModelError
        A figure is out of range or in another unit.

    References
    ----------
    [Krishnan2001]_, section 2.3.
    """
    check_others("voltage_drive", others, "lag")
    control, volt = parse_unit(unit), parse_unit("V")
    own = own_unit(volts)
    refuse(
        ModelError,
        (
            own is not None and not own.same_dimension(volt / control),
            f"volts is in {own}. Give volts, the voltage for a control of 1 {unit}, in "
            f"{volt / control}",
        ),
        (
            own is None and not any(control.same_dimension(u) for u in (volt, parse_unit("1"))),
            f"the control of a voltage drive is in {unit}. Give a voltage with unit='V', a duty "
            "cycle with unit='1', or volts as a Constant in V per unit of the control. For a "
            "current declare current_drive(...)",
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
    """Return a motor with controlled current: ``tau = kt n u``, limited by the supply voltage.

    Parameters
    ----------
    kt, ratio, efficiency
        As in `voltage_drive`.
    supply : float or Constant
        Largest voltage at the winding, V. The forward force is at most ``kt n (supply - ke n dq) /
        R``; the largest backward force has the same size at the opposite velocity. Infinite for no
        limit.
    resistance, ke : float or Constant, optional
        As in `voltage_drive`; they are given only together with `supply`. ke equals kt by default.
    reach : expression, optional
        Largest forward force as a function of the velocity, `VELOCITY` or that of the coordinate,
        such as the torque curve of a data sheet; above 0 at rest. It replaces `supply`,
        `resistance` and `ke`.
    unit : str
        Unit of the control, a current.
    **others
        Arguments of `Drive`: limit, relative_sd, lag, delay, logged, profile.

    Returns
    -------
    MotorDrive

    Raises
    ------
    ModelError
        A figure is out of range or in another unit, or the limit of the force is given twice or
        incompletely.

    References
    ----------
    [Krishnan2001]_, section 2.3.
    """
    check_others("current_drive", others)
    n = figure(ratio, "the gear ratio", *RATIO_UNITS, signed=True)
    gain = figure(kt, "kt", *KT_UNITS) * n
    volts = figure(supply, "the supply", "V", finite=False)
    has_supply, has_reach = math.isfinite(volts), reach is not None
    of_supply = (has_supply, resistance is not None)
    refuse(
        ModelError,
        (
            not parse_unit(unit).same_dimension(parse_unit("A")),
            f"the control of a current drive is in {unit}. Give a current with unit='A', or "
            "declare Drive(gain=..., unit=...) with the force for a control of 1",
        ),
        (
            (has_supply and has_reach) or len({*of_supply, has_supply or ke is not None}) > 1,
            "the force that the supply allows is given "
            + ("twice, by supply and by reach" if has_supply and has_reach else "incompletely")
            + ". Give supply and resistance (and ke if it differs from kt), or only reach",
        ),
        code="drive",
    )
    limit = sympy.oo if reach is None else expression(reach, "the drive's reach")
    if resistance is not None:
        ohms = figure(resistance, "the resistance", "V/A")
        emf = gain if ke is None else n * figure(ke, "ke", *KE_UNITS)
        limit = sympy.Float(abs(gain) / ohms * volts) - sympy.Float(gain / ohms * emf) * VELOCITY
    return MotorDrive(
        gain=gain, unit=unit, reach=limit, efficiency=efficiency, figures=(kt, ke, ratio), **others
    )


#: The ready-made drives, by their names in TOML declarations.
DRIVES: Mapping[str, Callable[..., Drive]] = MappingProxyType(
    {drive.__name__: drive for drive in (voltage_drive, current_drive)}
)
