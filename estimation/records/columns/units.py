"""Units of the roles and signals, and what a column's numbers mean: its values in SI.

::

    scaling  = [unit] { factor } [ offset ]        counts*360deg/4096/50+0.2deg
    factor   = ("*" | "/") quantity
    offset   = ("+" | "-") quantity
    quantity = number [unit]

A factor may be negative, ``*-1``. The unit is that of the column's numbers, by default the file's;
what encoders count has none, and what is one count is said by the factors. Within a unit ``*`` and
``/`` stand before a letter, as in ``mm/s`` or ``mm/rev``; before a number they scale. Numbers are
fractions and pi is kept apart, so that the product is rounded once. So are powers of an angle,
which SI counts as a number: ``rpm*5mm`` is no speed, ``rpm*5mm/rev`` is.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from axisid.estimation.tables import COUNTS, LABEL_WITH_UNIT, Quantity, exact_unit, is_unit
from axisid.modeling.declaration import ROLES, Axis
from axisid.modeling.quantities import Unit, angle_power, parse_unit
from axisid.support.arrays import Array
from axisid.support.errors import DataError, UsageError

#: What scales or moves, before a number; ``**2`` and ``^-2`` are of a unit.
_OPERATOR = re.compile(r"(?<![*^])\s*([*/](?!\*)(?=\s*[+-]?\.?\d)|[+-](?=\s*\.?\d))\s*")
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_LAST = re.compile(r"[*/+-]\s*\Z")
_NO_NUMBER = re.compile(r"[*/+-]\s*(-?(?:nan|inf(?:inity)?))\b", re.IGNORECASE)
_LARGEST = Fraction(10) ** 300
_LONGEST = 200
_ONE = parse_unit("1")


class ScalingError(ValueError):
    """A text that is no scaling.

    Attributes
    ----------
    letter : int
        Where, from 1.
    """

    def __init__(self, letter: int, why: str) -> None:
        super().__init__(why)
        self.letter = letter


@dataclass(frozen=True, slots=True, kw_only=True)
class Scaling:
    """What makes numbers of a column SI: times a factor, plus an offset.

    Attributes
    ----------
    of : Quantity
        What a 1 of the column is.
    offset : Quantity or None
        Coherent.
    is_scaled : bool
        Whether a factor has a unit, which is needed for what encoders count.
    """

    of: Quantity
    offset: Quantity | None = None
    is_scaled: bool = False


def is_scaling(text: str) -> bool:
    """Whether a text says more than a unit."""
    if _LAST.search(text) or _NO_NUMBER.search(text):
        return True
    if exact_unit(text) is not None:
        return False
    return bool(_OPERATOR.search(text) or _NUMBER.match(text))


def read_scaling(text: str, own: str = "") -> Scaling:
    """Read a scaling.

    Parameters
    ----------
    text : str
    own : str
        Unit of the column as its file writes it, for a text that begins with a factor.

    Raises
    ------
    ScalingError
        It is none: where, and why.
    """
    _check_numbers(text)
    head_ends = _unit_ends(text, 0)
    leads = _NUMBER.match(text)  # a factor without its sign
    if leads:
        of, place = _quantity(text, 0)
    else:
        name, place = text[:head_ends].strip() or own, head_ends
        of = _unit(name, 0, Fraction(1)) if name else Quantity(Fraction(1))
    base = Quantity(Fraction(1)) if leads else of  # one of the column's own unit
    scaled, offset = bool(leads) and of.unit is not None, None
    while (found := _OPERATOR.match(text, place)) is not None:
        if offset is not None:
            raise ScalingError(found.start(1) + 1, "the offset comes last, and once")
        quantity, place = _quantity(text, found.end())
        if found[1] in "+-":
            offset = _offset(quantity, of, base, found.start(1))
            offset = offset if found[1] == "+" else replace(offset, value=-offset.value)
            continue
        if quantity.is_count and found[1] == "*":
            raise ScalingError(found.end() + 1, "one count is a length or an angle, not counts")
        if not quantity.value:
            why = "a factor of 0 leaves nothing" if found[1] == "*" else "nothing is divided by 0"
            raise ScalingError(found.end() + 1, why)
        of = of * quantity if found[1] == "*" else of / quantity
        scaled = scaled or (quantity.unit is not None and not quantity.is_count)
    if not 1 / _LARGEST < abs(of.value) < _LARGEST:
        raise ScalingError(1, "the product of the factors is no number that can be computed with")
    return Scaling(of=of, offset=offset, is_scaled=scaled)


def _check_numbers(text: str) -> None:
    """Refuse what stands for a number and is none, or is one of absurd size."""
    if found := _NO_NUMBER.search(text):
        raise ScalingError(found.start(1) + 1, f"{found[1]!r} is no number to scale by")
    if found := _LAST.search(text):
        raise ScalingError(len(text) + 1, f"a number is missing after {found[0].strip()!r}")
    if len(text) > _LONGEST:
        raise ScalingError(_LONGEST + 1, f"it has more than {_LONGEST} letters")
    for number in _NUMBER.finditer(text):
        size = abs(float(number[0]))
        is_zero = not number[0].lower().partition("e")[0].strip("+-0.")
        if not (is_zero or 1 / _LARGEST < size < _LARGEST):
            raise ScalingError(number.start() + 1, f"{number[0]!r} is beyond any scale")


def _unit_ends(text: str, start: int) -> int:
    """Where a unit that begins there ends: before the next operator, or with the text."""
    found = _OPERATOR.search(text, start)
    return len(text) if found is None else found.start()


def _quantity(text: str, start: int) -> tuple[Quantity, int]:
    """The quantity that begins there, and where it ends."""
    number = _NUMBER.match(text, start)
    assert number is not None  # noqa: S101  # whoever asks has seen a digit
    end = _unit_ends(text, number.end())
    unit, value = text[number.end() : end], Fraction(number[0])
    return (_unit(unit, number.end(), value) if unit.strip() else Quantity(value)), end


def _unit(text: str, start: int, value: Fraction) -> Quantity:
    """A number of a unit."""
    name = text.strip()
    if name.lower() in COUNTS:
        return Quantity(value, is_count=True)
    found = _known(name)
    if found is None:
        letter = start + 1 + len(text) - len(text.lstrip())
        raise ScalingError(letter, f"{name!r} is no unit that is known")
    return replace(found, value=value * found.value)


def _known(name: str) -> Quantity | None:
    """One of a unit, or of one over another, as in ``mm/rev``; None where it is not known."""
    above, over, below = name.rpartition("/")
    parts = (_known(above.strip()), _known(below.strip())) if over else (None, None)
    return exact_unit(name) or (parts[0] / parts[1] if parts[0] and parts[1] else None)


def _offset(quantity: Quantity, of: Quantity, base: Quantity, place: int) -> Quantity:
    """An offset in the unit of the result; one of counts, or in the column's unit, is scaled."""
    if quantity.is_count and base.is_count:
        return of * replace(quantity, is_count=False)
    if quantity.unit is None:
        raise ScalingError(place + 1, "an offset needs its unit, as in +0.2deg")
    unit = of.unit or _ONE
    if quantity.unit.same_dimension(unit) and quantity.angle == of.angle:
        return quantity
    if (
        base.unit is not None
        and quantity.unit.same_dimension(base.unit)
        and quantity.angle == base.angle
    ):
        scale = of / base
        return scale * quantity
    raise ScalingError(place + 1, f"an offset in {quantity.unit} does not add to {unit}")


# different whole numbers: metres or radians are whole by chance in no log, fewer are a test of a
# few rows
_MIN_COUNTS = 10

#: Of the roles that are no length or angle, where no axis says more.
_UNITS: dict[str, tuple[str, ...]] = {
    "control": (),
    "force": ("N", "N m"),
    "velocity": ("m/s", "rad/s"),
    "acceleration": ("m/s^2", "rad/s^2"),
}


def expected_units(role: str, axis: Axis | None, injected_at: str | None = None) -> tuple[str, ...]:
    """Coherent units that a role may have: one if the axis is known.

    A test signal has that of what it is added to.
    """
    role = injected_at or "control" if role == "injected" else role
    if role == "time":
        return ("s",)
    if axis is not None and role not in ROLES:
        return tuple(signal.unit for signal in axis.signals if signal.name == role)
    if axis is None:
        return _UNITS.get(role, ("m", "rad"))
    q = axis.coordinate
    units = {
        "control": axis.drive.unit,
        "force": str(q.force_unit),
        "velocity": str(q.velocity_unit),
        "acceleration": str(q.acceleration_unit),
    }
    return (units.get(role, q.unit),)


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
    """Convert a column to SI, and say what was done; empty where nothing was.

    Parameters
    ----------
    role : str
    values : (N,) array
    text : str
        What the numbers are of, as the file or the user writes it: a unit, or a scaling such as
        ``counts*360deg/4096``, see `read_scaling`.
    axis : Axis or None
        Its coordinate and drive say what a role measures.
    requested : bool
        Whether the user gave the unit, for the error.
    source : str
        File name.
    own : str, optional
        Unit as the file writes it, for a scaling that begins with a factor; of what the file itself
        writes none, as that is no scaling.
    injected_at : str, optional
        What a test signal is added to.

    Raises
    ------
    UsageError, DataError
        The unit is unknown, or measures something else than the role does; or it is a scaling that
        cannot be read, or does not say what one count is.
    """
    wanted = expected_units(role, axis, injected_at)
    scaling, wrong = None, UsageError if requested else DataError
    if own is not None and is_scaling(text):
        scaling = _scaling(role, text, own, source, wanted)
        of, wrong = scaling.of, UsageError
        has = f"is given as {text!r}, which is {of.unit}"
    else:
        known, has = exact_unit(text), f"has the unit {text!r}"
        if known is None:
            raise wrong(
                f"{source}: the {role} {has}, which is not known; "
                f"{_advice_on_unit(role, text, wanted)}",
                code="units",
            )
        of = known
    same = [unit for unit in wanted if of.unit is not None and _measures(of.unit, unit)]
    if of.unit is not None and wanted and not same:
        of_axis = f" of axis {axis.name!r}" if axis is not None else ""
        raise wrong(
            f"{source}: the {role} {has}, but the {role}{of_axis} is measured in "
            f"{' or '.join(wanted)}. "
            f"Check the column, or give its unit with columns {role}=NAME:UNIT.",
            code="units",
        )
    factor = float(of)
    if scaling is None:
        return (values, "") if factor == 1.0 else (values * factor, f"{role}: {text} -> {of.unit}")
    _check_angle(role, text, of, wanted, source)
    unit = same[0] if same else of.unit or (wanted[0] if len(wanted) == 1 else "SI")
    said = f"{role}: {text}, {factor:.9g} {unit} each"
    if scaling.offset is None:
        return values * factor, said
    offset = float(scaling.offset)
    said += f" {'+' if offset >= 0 else '-'} {abs(offset):.9g}"
    return values * factor + offset, said


def _advice_on_unit(role: str, unit: str, wanted: Sequence[str]) -> str:
    """What to do about a unit that is not known."""
    counts = ""
    if unit.lower() in COUNTS:
        each = f"columns {role}=NAME:{unit}*360deg/4096"
        counts = f"say what one of these counts is, as in {each}. Else "
    return (
        f"{counts}give the unit that it is in with columns {role}=NAME:UNIT (mm, deg, "
        f"rev, ms, mA, Ncm, ...), or NAME:{(wanted or ('V',))[0]} where it is SI."
    )


def _scaling(role: str, text: str, own: str, source: str, wanted: Sequence[str]) -> Scaling:
    """What a scaling says, which has to say what one count is."""
    try:
        scaling = read_scaling(text, own if is_unit(own) else "")
    except ScalingError as error:
        raise UsageError(
            f"{source}: the {role} is given as {text!r}: at letter {error.letter}, {error}; "
            f"write it as in {_example(role, wanted)}.",
            code="units",
        ) from error
    if scaling.of.is_count and not scaling.is_scaled:
        raise UsageError(
            f"{source}: the {role} is given as {text!r}, which does not say what one count "
            f"is; give that, as in {_example(role, wanted)}.",
            code="units",
        )
    return scaling


def _example(role: str, wanted: Sequence[str]) -> str:
    """A scaling of a role, for a message."""
    unit = next(iter(wanted), "")
    rate = unit.removeprefix("rad").removeprefix("m")
    if rate in ("/s", "/s^2") and unit != rate:
        turns = "rpm" if rate == "/s" else "rev/s^2"
        return f"columns {role}=NAME:{turns}{'*5mm/rev' * unit.startswith('m')}"
    each = "5mm/4096" if unit == "m" else "360deg/4096/50+0.2deg"
    named = role if unit in ("m", "rad") else "position"
    return f"columns {named}=NAME:counts*{each}"


def _check_angle(role: str, text: str, of: Quantity, wanted: Sequence[str], source: str) -> None:
    """Refuse a length that is still one times an angle, and an angle that nothing says is one.

    SI counts angles as numbers, so that ``rpm*5mm`` is a speed to it: by 2 pi another than that of
    a screw of 5 mm a turn.
    """
    if of.unit is None:
        return
    units = [parse_unit(unit) for unit in wanted]
    motions = [unit for unit in units if of.unit.same_dimension(unit) and _is_of_motion(unit)]
    if not motions or any(angle_power(unit) == of.angle for unit in motions):
        return
    unit = motions[0]
    left = of.angle - angle_power(unit)
    if angle_power(unit):
        said = "that of no angle"
        what = "say which angle it is, as in mm/5mm*1rev for a screw or mm/5mm*1rad for a radius"
    elif left > 0:
        said = f"{unit} times an angle"
        what = "say what length belongs to it, *5mm/rev for a screw or *5mm/rad for a radius"
    else:
        said = f"{unit} an angle"
        what = "say what angle it is of, as in counts*1rev/4096*5mm/rev"
    raise UsageError(
        f"{source}: the {role} is given as {text!r}, which is {said}; {what}.",
        code="units",
    )


def _is_of_motion(unit: Unit) -> bool:
    """Whether a unit is of length or angle and time alone, such as m/s; a plain number is not."""
    mass, length, _, current, heat = unit.exponents
    return not (mass or current or heat) and bool(length or angle_power(unit))


def check_no_counts(role: str, name: str, values: Array, axis: Axis | None, *, source: str) -> None:
    """Refuse whole numbers without a unit as a position: they are what an encoder counts.

    Raises
    ------
    DataError
        They are.
    """
    finite = values[np.isfinite(values)]
    if role not in ("position", "reference") or np.any(finite != np.round(finite)):
        return
    if len(np.unique(finite)) < _MIN_COUNTS:
        return
    unit = (axis.coordinate.unit if axis is not None else "") or "rad"
    example = "5mm/4096" if unit == "m" else "360deg/4096"
    raise DataError(
        f"{source}: the {role} {name!r} has no unit, and is whole numbers alone, from "
        f"{finite.min():.9g} to {finite.max():.9g}: those are counts of an encoder; say "
        f"what one of them is, as in columns {role}={name}:counts*{example}; where they "
        f"are {unit} indeed, say so ({name}:{unit}).",
        code="units",
    )


def _measures(unit: Unit, wanted: str) -> bool:
    """Whether the units agree in kind: an angle is a number, but no angle is a length."""
    return unit.same_dimension(parse_unit(wanted))


def assumed_units_text(
    roles: Mapping[str, str], axis: Axis | None, *, injected_at: str | None
) -> str:
    """What is said of columns, by role, whose unit nobody gave."""
    if not roles:
        return ""
    named = []
    for role, name in roles.items():
        wanted = expected_units(role, axis, injected_at)
        unit = " or ".join(wanted) if wanted else "as the drive has it"
        label = LABEL_WITH_UNIT.fullmatch(name)
        passed = label[4] if label is not None else None
        unknown = passed and not passed.isdecimal()
        named.append(f"{role} {unit}" + (f" ({passed!r} is no unit known)" if unknown else ""))
    return f"no unit given, so SI: {', '.join(named)}"
