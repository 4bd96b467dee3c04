"""Units of roles and signals, and scalings: conversion of a column's numbers to SI.

::

    scaling  = [unit] { factor } [ offset ]        counts*360deg/4096/50+0.2deg
    factor   = ("*" | "/") quantity
    offset   = ("+" | "-") quantity
    quantity = number [unit]

A factor may be negative, ``*-1``. The unit is that of the column's numbers, by default that of the
file; encoder counts have none, and the factors give the size of one count. Within a unit ``*`` and
``/`` precede a letter, as in ``mm/s`` or ``mm/rev``; before a number they scale. Numbers are exact
fractions, with pi to forty digits, so that the product is rounded once. Powers of an angle, which
are dimensionless in SI, are counted: ``rpm*5mm`` is no speed, ``rpm*5mm/rev`` is.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from axisid.estimation.raw_tables import COUNTS, LABEL_WITH_UNIT, UnitQuantity, exact_unit, is_unit
from axisid.modeling.declaration import Axis
from axisid.modeling.quantities import angle_power, parse_unit
from axisid.support.arrays import Array
from axisid.support.errors import DataError, UsageError
from axisid.support.settings import setting

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?0*\d{1,2}(?!\d))?")
#: Operator before a number; the powers ``**2`` and ``^-2`` belong to a unit.
_OPERATOR = re.compile(r"(?<![*^])(?:[*/](?!\*)(?=\s*[+-]?\.?\d)|[+-](?=\s*\.?\d))")
_FACTOR = re.compile(rf"([*/+-])\s*({_NUMBER.pattern})((?:(?!{_OPERATOR.pattern}).)*)", re.DOTALL)
_LAST = re.compile(r"[*/+-]\s*\Z")
_NO_NUMBER = re.compile(r"[*/+-]\s*(-?(?:nan|inf(?:inity)?))\b", re.IGNORECASE)
_LARGEST = Fraction(10) ** 300


class ScalingError(ValueError):
    """The reason why a text is no scaling."""


def is_scaling(text: str) -> bool:
    """Return True if a text is a scaling such as ``counts*360deg/4096``, and not only a unit."""
    begun = _LAST.search(text) or _NO_NUMBER.search(text)
    return bool(
        begun or (exact_unit(text) is None and (_OPERATOR.search(text) or _NUMBER.match(text)))
    )


def read_scaling(text: str, own: str = "") -> tuple[UnitQuantity, UnitQuantity | None]:
    """Return the quantity of the number 1 in a column, and the offset that is added to it.

    The offset is None if the text has none. Both are in coherent units.

    Parameters
    ----------
    text : str
        Scaling as the user gave it, such as ``counts*360deg/4096+0.2deg``.
    own : str
        Unit of the column in its file, for a text that begins with a factor.

    Raises
    ------
    ScalingError
        The text is no scaling; the message gives the reason.
    """
    _check_numbers(text)
    if _NUMBER.match(text):  # a factor without its sign
        text, own = f"*{text}", ""
    first = _OPERATOR.search(text)
    head = text if first is None else text[: first.start()]
    name, offset = head.strip() or own, None
    base = of = _quantity(Fraction(1), name)
    for sign, number, unit in _FACTOR.findall(text[len(head) :]):
        if offset is not None:
            raise ScalingError("it can have one offset only, at its end")
        quantity = _quantity(Fraction(number) * (-1 if sign == "-" else 1), unit)
        if sign in "+-":
            offset = _offset(quantity, of, base)
        elif quantity.is_count and sign == "*":
            raise ScalingError("one count must be a length or an angle, not counts")
        elif not quantity.value:
            raise ScalingError(f"{sign}0 makes every value 0 or infinite")
        else:
            of = of * quantity if sign == "*" else of / quantity
    if not 1 / _LARGEST < abs(of.value) < _LARGEST:
        raise ScalingError("the product of the factors exceeds floating point, or is 0")
    return of, offset


def _check_numbers(text: str) -> None:
    """Refuse missing or infinite numbers, and a text that is too long."""
    if wrong := _NO_NUMBER.search(text):
        raise ScalingError(f"{wrong[1]!r} is not a number")
    if wrong := _LAST.search(text):
        raise ScalingError(f"a number is missing after {wrong[0].strip()!r}")
    if len(text) > 200:
        raise ScalingError("it has more than 200 characters")


def _quantity(value: Fraction, unit: str) -> UnitQuantity:
    """Return a number with its unit as a quantity; counts of an encoder have no unit."""
    name = unit.strip()
    if not name or name.lower() in COUNTS:
        return UnitQuantity(value, is_count=bool(name))
    unit_of = _known(name)
    if unit_of is None:
        raise ScalingError(f"{name!r} is not a known unit")
    return replace(unit_of, value=value * unit_of.value)


def _known(name: str) -> UnitQuantity | None:
    """Return the quantity of a unit, or of a quotient such as ``mm/rev``; None if unknown."""
    above, over, below = name.rpartition("/")
    parts = (_known(above.strip()), _known(below.strip())) if over else (None, None)
    return exact_unit(name) or (parts[0] / parts[1] if parts[0] and parts[1] else None)


def _offset(quantity: UnitQuantity, of: UnitQuantity, base: UnitQuantity) -> UnitQuantity:
    """Return the offset of a scaling in the unit of its result.

    An offset in counts, or in the unit of the column, is multiplied by the scaling.

    Parameters
    ----------
    quantity : UnitQuantity
        Offset as the user gave it.
    of, base : UnitQuantity
        Quantity of the number 1 in the column, with and without the factors of the scaling.
    """
    if quantity.is_count and base.is_count:
        return of * replace(quantity, is_count=False)
    if quantity.unit is None:
        raise ScalingError("an offset needs its unit, as in +0.2deg")
    unit, one = of.unit or parse_unit("1"), UnitQuantity(Fraction(1))
    for wanted, angle, scale in ((unit, of.angle, one), (base.unit, base.angle, of / base)):
        if wanted is not None and quantity.unit.same_dimension(wanted) and quantity.angle == angle:
            return scale * quantity
    raise ScalingError(f"an offset in {quantity.unit} does not add to {unit}")


#: Coherent units of roles that are no length or angle, without an axis.
_UNITS: dict[str, tuple[str, ...]] = {
    "time": ("s",),
    "control": (),
    "force": ("N", "N m"),
    "velocity": ("m/s", "rad/s"),
    "acceleration": ("m/s^2", "rad/s^2"),
}


#: Units that a column may have without a statement, the more likely ones first.
_LIKELY_UNITS = (
    *("bar", "mbar", "kPa", "MPa", "mV", "kV", "mA", "kN", "mm", "cm", "deg", "min"),
    *("mm/s", "cm/s", "m/min", "mm/min", "rpm", "deg/s", "rev/s"),
    *("mm/s^2", "cm/s^2", "g", "deg/s^2", "rev/s^2"),
)

#: Units of angles as logs write them, to name in place of one without an angle.
_ANGLES = ("rad", "deg", "rev", "rad/s", "deg/s", "rev/s", "rpm", "rad/s^2", "deg/s^2", "rev/s^2")

#: Scalings that give a unit of motion.
_EXAMPLES = {
    "m": "counts*5mm/4096",
    "rad": "counts*360deg/4096/50+0.2deg",
    "m/s": "rpm*5mm/rev",
    "m/s^2": "rev/s^2*5mm/rev",
    "rad/s": "rpm*1/50",
    "rad/s^2": "rev/s^2*1/50",
}


def expected_units(role: str, axis: Axis | None, injected_at: str | None = None) -> tuple[str, ...]:
    """Return the possible coherent units of a role; a single one if the axis is known.

    A test signal has the unit of the signal that it is added to.
    """
    role = injected_at or "control" if role == "injected" else role
    if axis is None:
        return _UNITS.get(role, ("m", "rad"))
    q = axis.coordinate
    units = {
        **{signal.name: signal.unit for signal in axis.signals},
        "time": "s",
        "control": axis.drive.unit,
        "force": str(q.force_unit),
        "velocity": str(q.velocity_unit),
        "acceleration": str(q.acceleration_unit),
    }
    return (units.get(role, q.unit),)


class Scale(NamedTuple):
    """Scale to SI: the value is ``factor * number + offset`` for a number of a log."""

    factor: float = 1.0
    offset: float = 0.0


def to_si(
    role: str,
    values: Array,
    text: str,
    axis: Axis | None,
    *,
    requested: bool,
    source: str,
    own: str | None = None,
    injected_at: str | None = None,
) -> tuple[Array, str]:
    """Return a column in SI, (N,), and a note on the conversion; an empty note without conversion.

    Parameters
    ----------
    role : str
    values : (N,) array
        Numbers of the column.
    text : str
        Unit of the numbers as in the file or as given by the user, or a scaling such as
        ``counts*360deg/4096``, see `read_scaling`.
    axis : Axis or None
        Axis whose coordinate and drive determine the unit of a role.
    requested : bool
        True if the user gave the unit, for the kind of error.
    source : str
        File name.
    own : str, optional
        Unit in the file, for a scaling by the user that begins with a factor; None for a text from
        the file, which is no scaling.
    injected_at : str, optional
        Injection point of a test signal.

    Raises
    ------
    UsageError, DataError
        The unit is unknown, or of another dimension than that of the role; or a scaling cannot be
        read, or lacks the size of one count.
    """
    wanted = expected_units(role, axis, injected_at)
    scaled = own is not None and is_scaling(text)
    offset: UnitQuantity | None = None
    wrong = UsageError if requested or scaled else DataError
    try:
        if scaled:
            of, offset = read_scaling(text, own if own and is_unit(own) else "")
        elif (plain := exact_unit(text)) or text.lower() in COUNTS:
            of = plain or UnitQuantity(Fraction(1), is_count=True)
        else:
            # A quotient such as mm/rev is refused too: it does not name the unit of the motion.
            raise ScalingError(f"{text!r} is not a known unit")
        if of.unit is None and (of.is_count or not scaled):
            raise ScalingError("the size of one count is missing")
    except ScalingError as error:
        example = _EXAMPLES.get(next(iter(wanted), ""), _EXAMPLES["rad"])
        raise wrong(
            f"{source}: the {role} is given as {text!r}: {error}. Give the size of one count, as "
            f"in {setting('columns', {role: f'NAME:{example}'})}, or the unit of the numbers with "
            f"{setting('columns', {role: 'NAME:UNIT'})} (mm, deg, rev, ms, mA, Ncm, ...). The SI "
            f"unit is {(wanted or ('V',))[0]}.",
            code="units",
        ) from error
    same = [
        unit for unit in wanted if of.unit is not None and of.unit.same_dimension(parse_unit(unit))
    ]
    if of.unit is not None and wanted and not same:
        of_axis = f" of axis {axis.name!r}" if axis is not None else ""
        raise wrong(
            f"{source}: the {role} is given as {text!r}, which is {of.unit}, but the "
            f"{role}{of_axis} is measured in {' or '.join(wanted)}. Check the column, or give its "
            f"unit with {setting('columns', {role: 'NAME:UNIT'})}.",
            code="units",
        )
    factor = float(of)
    if scaled:
        _check_angle(role, text, of, same, source)
    elif same and not any(_has_angle_of(of, unit) for unit in same):
        named = " or ".join(name for name in _ANGLES if _is_of(name, same[0])) or same[0]
        raise wrong(
            f"{source}: the {role} is given as {text!r}, which does not name an angle, but the "
            f"{role} is measured in {same[0]}. Numbers per radian, degree or turn differ by "
            f"factors such as 2 pi. Give the unit with its angle, {named}, as in columns "
            f"{role}=NAME:{same[0]}.",
            code="units",
        )
    if not scaled:
        return (values, "") if factor == 1.0 else (values * factor, f"{role}: {text} -> {of.unit}")
    unit = same[0] if same else of.unit or (wanted[0] if len(wanted) == 1 else "SI")
    note = f"{role}: {text}, {factor:.9g} {unit} each"
    if offset is None:
        return values * factor, note
    added = float(offset)
    return values * factor + added, f"{note} {'+' if added >= 0 else '-'} {abs(added):.9g}"


def _check_angle(role: str, text: str, of: UnitQuantity, same: Sequence[str], source: str) -> None:
    """Refuse a scaling whose result contains a wrong power of an angle.

    That is a length that contains an angle, or an angle without a unit of angle.

    Angles are dimensionless in SI, so that ``rpm*5mm`` has the unit of a speed: it differs by 2 pi
    from that of a screw with a lead of 5 mm per turn.
    """
    motions = {unit: angle_power(parse_unit(unit)) for unit in same if unit in _EXAMPLES}
    if not motions or of.angle in motions.values():
        return
    unit, power = next(iter(motions.items()))
    times = "times" if of.angle > power else "over"
    raise UsageError(
        f"{source}: the {role} is given as {text!r}, which is {unit} {times} an angle. Give the "
        "length per angle, as in rpm*5mm/rev or counts*1rev/4096*5mm/rev for a screw, *5mm/rad for "
        "a radius, mm/5mm*1rev for an angle.",
        code="units",
    )


def _has_angle_of(of: UnitQuantity, unit: str) -> bool:
    """Return True if a quantity has the same power of an angle as a unit, or the unit has none."""
    power = angle_power(parse_unit(unit))
    return not power or of.angle == power


def _is_of(name: str, unit: str) -> bool:
    """Return True if a unit of logs has the dimension of a coherent one, including its angle."""
    named, wanted = exact_unit(name), parse_unit(unit)
    return bool(
        named
        and named.unit
        and named.unit.same_dimension(wanted)
        and named.angle == angle_power(wanted)
    )


def likely_unit(declared: str, times: float, vague: float) -> str | None:
    """Return the usual unit in which the numbers of a column may be, by their size.

    Parameters
    ----------
    declared : str
        Declared unit.
    times : float
        Ratio of the column's numbers to those in the declared unit.
    vague : float
        Relative uncertainty of the ratio.

    Returns
    -------
    str or None
        None if no usual unit has this ratio.
    """
    own = exact_unit(declared)
    if own is None or not vague < np.inf:
        return None
    for name in _LIKELY_UNITS:
        unit = exact_unit(name)
        if unit is None or unit.unit != own.unit:
            continue
        if abs(times * float(unit / own) - 1) <= vague:
            return name
    return None


def check_no_counts(role: str, name: str, values: Array, axis: Axis | None, *, source: str) -> None:
    """Refuse whole numbers without a unit as a position: they are probably encoder counts.

    Raises
    ------
    DataError
        All numbers of a position or reference are whole.
    """
    finite = values[np.isfinite(values)]
    whole = role in ("position", "reference") and np.all(finite == np.round(finite))
    # Ten different values are not whole by chance; fewer may be a short test.
    if not whole or len(np.unique(finite)) < 10:
        return
    unit = (axis.coordinate.unit if axis is not None else "") or "rad"
    example = _EXAMPLES.get(unit, _EXAMPLES["rad"])
    raise DataError(
        f"{source}: the {role} {name!r} has no unit and only whole numbers, from "
        f"{finite.min():.9g} to {finite.max():.9g}. They look like counts of an encoder. Give the "
        f"size of one count, as in {setting('columns', {role: f'{name}:{example}'})}. If the "
        f"numbers are in {unit}, give that unit ({name}:{unit}).",
        code="units",
    )


def assumed_units_text(
    roles: Mapping[str, str], axis: Axis | None, *, injected_at: str | None
) -> str:
    """Return a note on columns without a given unit, by role."""
    named = []
    for role, name in roles.items():
        unit = " or ".join(expected_units(role, axis, injected_at)) or "unit of the drive"
        label = LABEL_WITH_UNIT.fullmatch(name)
        if label and label[4] and not label[4].isdecimal():
            unit += f" ({label[4]!r} is not a known unit)"
        named.append(f"{role} {unit}")
    return f"no unit given, so SI: {', '.join(named)}"
