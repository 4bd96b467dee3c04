"""Conversion of a column's numbers to SI by units and scalings, and the units of roles.

A scaling is a text that gives the size of the number 1 of a column, and an offset::

    scaling  = [unit] { factor } [ offset ]        counts*360deg/4096/50+0.2deg
    factor   = ("*" | "/") quantity
    offset   = ("+" | "-") quantity
    quantity = number [unit]

A factor may be negative, ``*-1``. The unit at the beginning is that of the column's numbers, by
default the unit in the file. Encoder counts have no unit; the factors give the size of one count.
Within a unit ``*`` and ``/`` precede a letter, as in ``mm/s`` or ``mm/rev``; before a number they
scale. Numbers are exact fractions, with pi to forty digits, so that the product is rounded once.
Powers of an angle, which are dimensionless in SI, are counted: ``rpm*5mm/rev`` is a speed, and
``rpm*5mm`` is not.
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
#: Operator, number and unit of a factor or an offset.
_FACTOR = re.compile(rf"([*/+-])\s*({_NUMBER.pattern})((?:(?!{_OPERATOR.pattern}).)*)", re.DOTALL)
#: Operator at the end of a text, without a number.
_LAST = re.compile(r"[*/+-]\s*\Z")
#: Operator before a text that floating point would read as a number.
_NO_NUMBER = re.compile(r"[*/+-]\s*(-?(?:nan|inf(?:inity)?))\b", re.IGNORECASE)
_LARGEST = Fraction(10) ** 300  # a larger scaling, or the inverse of a smaller one, is refused


class ScalingError(ValueError):
    """Error of a text that is not a scaling; its message is the reason."""


def is_scaling(text: str) -> bool:
    """Return True if a text is a scaling such as ``counts*360deg/4096``, and not only a unit.

    A scaling without its last number, or with a wrong number, also counts.
    """
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
        Unit of the column in its file, for a text that begins with a factor; empty for none.

    Raises
    ------
    ScalingError
        The text is not a scaling; the message gives the reason.
    """
    _check_numbers(text)
    if _NUMBER.match(text):  # a factor without its sign
        text, own = f"*{text}", ""
    first = _OPERATOR.search(text)
    head = text if first is None else text[: first.start()]
    name, offset = head.strip() or own, None
    # Size of the number 1 in the column: by its unit, and after the factors that follow.
    unit_size = size = _quantity(Fraction(1), name)
    for sign, number, unit in _FACTOR.findall(text[len(head) :]):
        if offset is not None:
            raise ScalingError("a scaling has one offset at most, at its end")
        quantity = _quantity(Fraction(number) * (-1 if sign == "-" else 1), unit)
        if sign in "+-":
            offset = _offset(quantity, size, unit_size)
        elif quantity.is_count and sign == "*":
            raise ScalingError("one count must be a length or an angle, not counts")
        elif not quantity.value:
            raise ScalingError(f"the factor {sign}0 makes every value 0 or infinite")
        else:
            size = size * quantity if sign == "*" else size / quantity
    if not 1 / _LARGEST < abs(size.value) < _LARGEST:
        raise ScalingError("the product of the factors is too large for floating point, or 0")
    return size, offset


def _check_numbers(text: str) -> None:
    """Refuse a scaling with missing or infinite numbers, or with a text that is too long."""
    if wrong := _NO_NUMBER.search(text):
        raise ScalingError(f"{wrong[1]!r} is not a number")
    if wrong := _LAST.search(text):
        raise ScalingError(f"a number is missing after {wrong[0].strip()!r}")
    if len(text) > 200:
        raise ScalingError("the text has more than 200 characters")


def _quantity(value: Fraction, unit: str) -> UnitQuantity:
    """Return a number with its unit as a quantity; counts of an encoder have no unit.

    Raises
    ------
    ScalingError
        The unit is unknown.
    """
    name = unit.strip()
    if not name or name.lower() in COUNTS:
        return UnitQuantity(value, is_count=bool(name))
    unit_of = _known(name)
    if unit_of is None:
        raise ScalingError(f"{name!r} is not a known unit")
    return replace(unit_of, value=value * unit_of.value)


def _known(name: str) -> UnitQuantity | None:
    """Return the quantity of a unit, or of a quotient such as ``mm/rev``; None if unknown."""
    numerator, slash, denominator = name.rpartition("/")
    parts = (_known(numerator.strip()), _known(denominator.strip())) if slash else (None, None)
    return exact_unit(name) or (parts[0] / parts[1] if parts[0] and parts[1] else None)


def _offset(quantity: UnitQuantity, size: UnitQuantity, unit_size: UnitQuantity) -> UnitQuantity:
    """Return the offset of a scaling in the unit of its result.

    An offset in counts, or in the unit of the column, is multiplied by the scaling.

    Parameters
    ----------
    quantity : UnitQuantity
        Offset as the user gave it.
    size, unit_size : UnitQuantity
        Quantity of the number 1 in the column, with and without the factors of the scaling.

    Raises
    ------
    ScalingError
        The offset has no unit, or the unit of another quantity.
    """
    if quantity.is_count and unit_size.is_count:
        return size * replace(quantity, is_count=False)
    if quantity.unit is None:
        raise ScalingError("an offset needs its unit, as in +0.2deg")
    # An offset in the unit of the result is added as given; in the unit of the column it is scaled.
    unit = size.unit or parse_unit("1")
    choices = (
        (unit, size.angle, UnitQuantity(Fraction(1))),
        (unit_size.unit, unit_size.angle, size / unit_size),
    )
    for wanted, angle, scale in choices:
        if wanted is not None and quantity.unit.same_dimension(wanted) and quantity.angle == angle:
            return scale * quantity
    raise ScalingError(f"an offset in {quantity.unit} cannot be added to {unit}")


#: Coherent units of roles without an axis; other roles are a length or an angle.
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

#: Units of angles as logs write them, which messages advise instead of a unit without an angle.
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
    """Return the possible coherent units of a role; a single unit if the axis is known.

    Empty for the control of an unknown axis. A test signal has the unit of the signal that it is
    added to: at `injected_at`, or to the control if that is None.
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
        True if the user gave the unit: an error is then a `UsageError`.
    source : str
        File name.
    own : str, optional
        Unit in the file, for a scaling by the user that begins with a factor; None for a text from
        the file, which cannot be a scaling.
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
    error_type = UsageError if requested or scaled else DataError
    # Size of the number 1 in the column.
    try:
        if scaled:
            size, offset = read_scaling(text, own if own and is_unit(own) else "")
        elif (plain := exact_unit(text)) or text.lower() in COUNTS:
            size = plain or UnitQuantity(Fraction(1), is_count=True)
        else:
            # A quotient such as mm/rev is refused too: it does not name the unit of the motion.
            raise ScalingError(f"{text!r} is not a known unit")
        if size.unit is None and (size.is_count or not scaled):
            raise ScalingError("the size of one count is missing")
    except ScalingError as error:
        example = _EXAMPLES.get(next(iter(wanted), ""), _EXAMPLES["rad"])
        raise error_type(
            f"{source}: the {role} is given as {text!r}: {error}. Give the size of one count, as "
            f"in {setting('columns', {role: f'NAME:{example}'})}, or the unit of the numbers with "
            f"{setting('columns', {role: 'NAME:UNIT'})} (mm, deg, rev, ms, mA, Ncm, ...). The SI "
            f"unit is {(wanted or ('V',))[0]}.",
            code="units",
        ) from error
    # Units of the role that have the same dimension, and the same power of an angle.
    same = [
        unit
        for unit in wanted
        if size.unit is not None and size.unit.same_dimension(parse_unit(unit))
    ]
    if size.unit is not None and wanted and not same:
        of_axis = f" of axis {axis.name!r}" if axis is not None else ""
        raise error_type(
            f"{source}: the {role} is given as {text!r}, which is {size.unit}, but the "
            f"{role}{of_axis} is measured in {' or '.join(wanted)}. Check the column, or give its "
            f"unit with {setting('columns', {role: 'NAME:UNIT'})}.",
            code="units",
        )
    factor = float(size)
    if scaled:
        _check_angle(role, text, size, same, source)
    elif same and not any(_has_angle_of(size, unit) for unit in same):
        named = " or ".join(name for name in _ANGLES if _is_of(name, same[0])) or same[0]
        raise error_type(
            f"{source}: the {role} is given as {text!r}, which does not name an angle, but the "
            f"{role} is measured in {same[0]}. Numbers per radian, degree or turn differ by "
            f"factors such as 2 pi. Give the unit with its angle ({named}), as in "
            f"{setting('columns', {role: f'NAME:{same[0]}'})}.",
            code="units",
        )
    # Convert the numbers.
    if not scaled:
        note = f"{role}: {text} -> {size.unit}"
        return (values, "") if factor == 1.0 else (values * factor, note)
    unit = same[0] if same else size.unit or (wanted[0] if len(wanted) == 1 else "SI")
    note = f"{role}: {text}, {factor:.9g} {unit} each"
    if offset is None:
        return values * factor, note
    added = float(offset)
    return values * factor + added, f"{note} {'+' if added >= 0 else '-'} {abs(added):.9g}"


def _check_angle(
    role: str, text: str, size: UnitQuantity, same: Sequence[str], source: str
) -> None:
    """Refuse a scaling whose result contains a wrong power of an angle.

    That is a length that contains an angle, or an angle without a unit of angle. Angles are
    dimensionless in SI, so that ``rpm*5mm`` has the unit of a speed, but differs by 2 pi from the
    speed of a screw with a lead of 5 mm per turn.

    Parameters
    ----------
    role, text, source : str
        Role of the column, scaling, and file name, for the message.
    size : UnitQuantity
        Quantity of the number 1 in the column.
    same : sequence of str
        Coherent units of the role with the same dimension.

    Raises
    ------
    UsageError
    """
    motions = {unit: angle_power(parse_unit(unit)) for unit in same if unit in _EXAMPLES}
    if not motions or size.angle in motions.values():
        return
    unit, power = next(iter(motions.items()))
    times = "times" if size.angle > power else "divided by"
    raise UsageError(
        f"{source}: the {role} is given as {text!r}, which is {unit} {times} an angle. Give the "
        "length per angle: rpm*5mm/rev or counts*1rev/4096*5mm/rev for a screw, *5mm/rad for a "
        "radius, or mm/5mm*1rev for an angle.",
        code="units",
    )


def _has_angle_of(quantity: UnitQuantity, unit: str) -> bool:
    """Return True if a quantity has the same power of an angle as a unit, or the unit has none."""
    power = angle_power(parse_unit(unit))
    return not power or quantity.angle == power


def _is_of(name: str, unit: str) -> bool:
    """Return True if a unit of logs has the dimension and power of angle of a coherent unit."""
    named, wanted = exact_unit(name), parse_unit(unit)
    return bool(
        named
        and named.unit
        and named.unit.same_dimension(wanted)
        and named.angle == angle_power(wanted)
    )


def likely_unit(declared: str, times: float, vague: float) -> str | None:
    """Return the usual unit that the numbers of a column may have, by their size.

    Parameters
    ----------
    declared : str
        Declared unit of the column.
    times : float
        Size of the column's numbers relative to numbers in the declared unit.
    vague : float
        Relative uncertainty of the ratio.

    Returns
    -------
    str or None
        None if no usual unit has this ratio to the declared unit, or the uncertainty is infinite.
    """
    declared_unit = exact_unit(declared)
    if declared_unit is None or not vague < np.inf:
        return None
    for name in _LIKELY_UNITS:
        unit = exact_unit(name)
        if unit is None or unit.unit != declared_unit.unit:
            continue
        if abs(times * float(unit / declared_unit) - 1) <= vague:
            return name
    return None


def check_no_counts(role: str, name: str, values: Array, axis: Axis | None, *, source: str) -> None:
    """Refuse a position of whole numbers without a unit, which are probably encoder counts.

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
        f"{finite.min():.9g} to {finite.max():.9g}. The numbers are probably counts of an encoder. "
        f"Give the size of one count, as in {setting('columns', {role: f'{name}:{example}'})}. If "
        f"the numbers are in {unit}, give this unit ({name}:{unit}).",
        code="units",
    )


def assumed_units_text(
    roles: Mapping[str, str], axis: Axis | None, *, injected_at: str | None
) -> str:
    """Return a note on columns without a given unit, with the assumed units.

    `roles` has the names of these columns by role.
    """
    named = []
    for role, name in roles.items():
        unit = " or ".join(expected_units(role, axis, injected_at)) or "unit of the drive"
        label = LABEL_WITH_UNIT.fullmatch(name)
        if label and label[4] and not label[4].isdecimal():
            unit += f" ({label[4]!r} is not a known unit)"
        named.append(f"{role} in {unit}")
    return f"SI where the log has no unit: {', '.join(named)}"
