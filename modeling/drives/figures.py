"""Figures of a data sheet: numbers, or constants whose units are checked along the gear."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, TypeAlias

from axisid.modeling.declaration import Drive
from axisid.modeling.quantities import (
    Constant,
    ConstantSymbol,
    Coordinate,
    Unit,
    number,
    parse_unit,
)
from axisid.support.errors import ModelError, quoted

#: What a drive is told: a plain number has the unit of its place, a `Constant` its own.
Figure: TypeAlias = float | Constant | ConstantSymbol


def figure(
    value: Figure, what: str, unit: str = "", *, positive: bool = True, finite: bool = True
) -> float:
    """The number of a figure.

    Raises
    ------
    ModelError
        It is none, or negative, or 0 where that is no figure, or a constant in another unit.
    """
    if unit:
        _check_dimension(value, what, unit)
    found = number(_number(value), what, finite=finite)
    if found < 0 or (positive and not found):
        said = "a positive number" if positive else "0 or more"
        raise ModelError(f"{what} is {quoted(value)}; give {said}.", code="drive")
    return found


def gear_ratio(value: Figure) -> float:
    """The number of a gear ratio, negative for a motor that turns the other way.

    Raises
    ------
    ModelError
        It is none, or 0.
    """
    found = number(_number(value), "the gear ratio")
    return math.copysign(figure(abs(found), "the gear ratio"), found)


def _check_dimension(value: Figure | None, what: str, *units: str) -> None:
    """Refuse a constant in another unit than those.

    Raises
    ------
    ModelError
        It is in another.
    """
    own = _unit(value)
    if own is None:
        return
    if not any(own.same_dimension(parse_unit(unit)) for unit in units):
        raise ModelError(f"{what} is in {own}; give it in {' or '.join(units)}.", code="drive")


def check_control(unit: str, volts: Figure) -> None:
    """Refuse a control that no voltage is made of by so many volts for a control of 1.

    Raises
    ------
    ModelError
        The volts are in another unit than V over the control's, or a plain number where the
        control is neither a voltage nor a duty.
    """
    control, volt = parse_unit(unit), parse_unit("V")
    own = _unit(volts)
    if own is not None and not own.same_dimension(volt / control):
        raise ModelError(
            f"volts is in {own}; give the voltage for a control of 1 {unit}, in {volt / control}.",
            code="drive",
        )
    if own is None and not any(control.same_dimension(u) for u in (volt, parse_unit("1"))):
        raise ModelError(
            f"the control of a voltage drive is in {unit}; give a voltage, unit='V', or a duty, "
            "unit='1', or volts as a Constant in V over the control's unit; of a current, "
            "current_drive(...).",
            code="drive",
        )


def check_current(unit: str) -> None:
    """Refuse a control that is no current.

    Raises
    ------
    ModelError
        It is none.
    """
    if not parse_unit(unit).same_dimension(parse_unit("A")):
        raise ModelError(
            f"the control of a current drive is in {unit}; give a current, unit='A', or declare "
            "Drive(gain=..., unit=...) with the force for a control of 1.",
            code="drive",
        )


def check_others(made_by: str, others: Mapping[str, Any]) -> None:
    """Refuse an argument that a drive has not.

    Raises
    ------
    ModelError
        There is one.
    """
    known = [f.name for f in fields(Drive) if f.name not in ("gain", "unit", "estimated")]
    if unknown := [name for name in others if name not in known]:
        raise ModelError(
            f"{made_by} has no argument {unknown[0]!r}; beside its own it takes "
            f"{', '.join(known)}.",
            code="drive",
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class GearedUnits:
    """Whether figures of a motor and its gear fit an axis.

    Attributes
    ----------
    kt, ke : Unit or None
        Of the constants; None for plain numbers, which fit any axis.
    ratio : Unit or None
        Of the gear ratio; None for a plain number.
    is_geared : bool
        Whether there is a ratio other than 1.
    """

    kt: Unit | None = None
    ke: Unit | None = None
    ratio: Unit | None = None
    is_geared: bool = False

    @classmethod
    def of(cls, kt: Figure, ke: Figure | None, ratio: Figure) -> "GearedUnits":
        """Of the figures themselves.

        Raises
        ------
        ModelError
            One is in a unit that none of them has.
        """
        _check_dimension(kt, "kt", "N m/A", "N/A")
        _check_dimension(ke, "ke", "V/(rad/s)", "V/(m/s)")
        _check_dimension(ratio, "the gear ratio", "1", "rad/m")
        return cls(kt=_unit(kt), ke=_unit(ke), ratio=_unit(ratio), is_geared=_number(ratio) != 1)

    def check_on(self, coordinate: Coordinate) -> None:
        """Refuse what counts the gear twice, or not at all.

        Raises
        ------
        ModelError
            The figures are the coordinate's already and there is a ratio, or they are not and
            there is none.
        """
        kt, ratio = coordinate.force_unit / parse_unit("A"), f"rad/{coordinate.unit}"
        ke = parse_unit("V") / coordinate.velocity_unit
        wrong = self.ratio is not None and not self.ratio.same_dimension(parse_unit(ratio))
        for name, unit, own in (("kt", self.kt, kt), ("ke", self.ke, ke)):
            if unit is None:
                continue
            is_own = unit.same_dimension(own)
            twice = is_own and self.is_geared and coordinate.unit == "m"
            if wrong or twice or not (is_own or self.is_geared):
                geared = (
                    f"a gear ratio in {self.ratio or 'no unit'}" if self.is_geared else "no gear"
                )
                raise ModelError(
                    f"{name} is in {unit}, with {geared} on a coordinate in {coordinate.unit}; "
                    f"give the motor's own {name} and ratio=..., the motor's angle over the "
                    f"coordinate, in {ratio}, or {name} in {own} without a ratio.",
                    code="drive",
                )


def _unit(value: Figure | None) -> Unit | None:
    if isinstance(value, Constant):
        return parse_unit(str(value.unit))
    return value.unit if isinstance(value, ConstantSymbol) else None


def _number(value: Figure) -> float:
    return value.value if isinstance(value, (Constant, ConstantSymbol)) else value
