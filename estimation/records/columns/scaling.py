"""What a column's numbers mean: ``counts*360deg/4096/50+0.2deg``, read exactly.

::

    scaling  = [unit] { factor } [ offset ]
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
from dataclasses import dataclass, replace
from fractions import Fraction

from axisid.estimation.tables import COUNTS, exact_unit
from axisid.modeling.quantities import Unit, angle_power, parse_unit

#: What scales or moves, before a number; ``**2`` and ``^-2`` are of a unit.
_OPERATOR = re.compile(r"(?<![*^])\s*([*/](?!\*)(?=\s*[+-]?\.?\d)|[+-](?=\s*\.?\d))\s*")
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_LAST = re.compile(r"[*/+-]\s*\Z")
_NO_NUMBER = re.compile(r"[*/+-]\s*(-?(?:nan|inf(?:inity)?))\b", re.IGNORECASE)
_LARGEST = Fraction(10) ** 300
_LONGEST = 200
#: To forty digits.
_PI = Fraction(31415926535897932384626433832795028841971, 10**40)
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


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number with its unit: a fraction, times a power of pi.

    Attributes
    ----------
    value : Fraction
        Of the coherent unit.
    turns : int
        Power of pi.
    unit : Unit or None
        Coherent; None for a plain number.
    angle : Fraction or int
        Power of the radian, which the unit counts as a number.
    is_count : bool
        Whether it is of what encoders count.
    """

    value: Fraction
    turns: int = 0
    unit: Unit | None = None
    is_count: bool = False
    angle: Fraction | int = 0

    def __mul__(self, other: "Quantity") -> "Quantity":
        return self._with(other, 1)

    def __truediv__(self, other: "Quantity") -> "Quantity":
        return self._with(other, -1)

    def _with(self, other: "Quantity", power: int) -> "Quantity":
        unit = self.unit
        if other.unit is not None:
            unit = (unit or _ONE) * other.unit**power if power < 0 or unit else other.unit
        return Quantity(
            self.value * other.value**power,
            self.turns + power * other.turns,
            unit,
            self.is_count,
            self.angle + power * other.angle,
        )

    def __float__(self) -> float:
        return float(self.value * _PI**self.turns)


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
    whole = exact_unit(name)
    if whole is not None:
        return Quantity(whole.factor, whole.turns, whole.unit, angle=angle_power(whole.unit))
    above, over, below = name.rpartition("/")
    parts = (_known(above.strip()), _known(below.strip())) if over else (None, None)
    return parts[0] / parts[1] if parts[0] and parts[1] else None


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
