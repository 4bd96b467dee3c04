"""A column of a log: its name or number, and what its numbers mean."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from axisid.support.errors import ModelError, is_real, quoted

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_RATIO = re.compile(rf"\s*(-?{_NUMBER})\s*(?:/\s*({_NUMBER})\s*)?")
_FACTOR = re.compile(rf"\s*-?{_NUMBER}\s*\S.*")


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a log, for `Axis` and `read_record`; its text is what ``--columns`` takes.

    Attributes
    ----------
    name : str or int
        As the log has it, or its number from 1.
    unit : str
        Of its numbers, where the log does not say it or says it wrongly.
    scale : float or str
        What its numbers are times: a number, or a quantity such as ``"360deg/4096"``; -1 turns
        the sign.
    offset : str
        What is added after that, with its unit: ``"0.2deg"``, ``"-1.5mm"``.
    gear : float or str
        Turns of the encoder to one of the axis, by which it is divided: ``50``, ``"121/3"``.
    resolution : float or str
        Counts of the encoder to its turn, or what one count is: ``4096``, ``"0.5um"``.

    Raises
    ------
    ModelError
        Something is none of that.

    Examples
    --------
    >>> str(Column("inc", resolution=4096, gear=50, offset="0.2deg"))
    'inc:counts*1rev/4096/50+0.2deg'
    """

    name: str | int
    unit: str = ""
    scale: float | str = 1
    offset: str = ""
    gear: float | str = 1
    resolution: float | str = ""

    def __post_init__(self) -> None:
        numbered = isinstance(self.name, int) and not isinstance(self.name, bool)
        valid = int(self.name) > 0 if numbered else isinstance(self.name, str) and self.name
        if not valid:
            raise ModelError(
                f"the name of a column is {quoted(self.name)}; give a text, or its number from 1.",
                code="axis",
            )
        if self.resolution != "" and self.unit:
            raise ModelError(
                f"the column {self.name!r} has the unit {self.unit!r} and a resolution, which is "
                "of counts; leave one of them out.",
                code="axis",
            )
        _ = str(self)

    def __str__(self) -> str:
        name = self.name if isinstance(self.name, str) else f"#{self.name}"
        counted = _text("unit", self.unit)
        if isinstance(self.resolution, str) and _is_quantity(self.resolution):
            counted = f"counts*{_quantity('resolution', self.resolution, 'such as 4096 or 0.5um')}"
        elif self.resolution != "":
            counted = f"counts*1rev/{_ratio('resolution', self.resolution)[0]}"
        if isinstance(self.scale, str) and _is_quantity(self.scale):
            scaled = f"*{_quantity('scale', self.scale, 'such as 2.5 or 360deg/4096')}"
        else:
            scaled = _fraction("*/", *_ratio("scale", self.scale, signed=True))
        geared, moved = _fraction("/*", *_ratio("gear", self.gear)), ""
        if self.offset:
            plain = _text("offset", self.offset).strip()
            sign, size = (plain[0], plain[1:]) if plain[:1] in ("+", "-") else ("+", plain)
            moved = f"{sign}{_quantity('offset', size, 'with its unit, such as 0.2deg')}"
        meaning = f"{counted}{scaled}{geared}{moved}"
        return f"{name}:{meaning}" if meaning else name


def _is_quantity(text: str) -> bool:
    return bool(text) and _RATIO.fullmatch(text) is None


def _fraction(signs: str, above: str, below: str) -> str:
    """Two numbers behind their signs, where they are not 1."""
    return "".join(f"{sign}{n}" for sign, n in zip(signs, (above, below), strict=True) if n != "1")


def _text(what: str, value: object) -> str:
    if not isinstance(value, str) or not value.isprintable():
        raise ModelError(f"the {what} of a column is {quoted(value)}; give a text.", code="axis")
    return value


def _quantity(what: str, text: str, such: str) -> str:
    if _FACTOR.fullmatch(_text(what, text)) is None:
        raise ModelError(
            f"the {what} of a column is {text!r}; give a quantity {such}.", code="axis"
        )
    return text.strip()


def _ratio(what: str, value: object, *, signed: bool = False) -> tuple[str, str]:
    """Two positive numbers as they are written, the one over the other; the first may be signed."""
    match = _RATIO.fullmatch(value) if isinstance(value, str) else None
    if match is not None:
        above, below = match[1], match[2] or "1"
    elif is_real(value) and math.isfinite(value):
        whole = Fraction(repr(float(value)))
        above, below = (str(whole) if whole.denominator == 1 else repr(float(value))), "1"
    else:
        above, below = "0", "0"
    if not (Fraction(below) > 0 and (Fraction(above) > 0 or (signed and Fraction(above)))):
        kind = "number other than 0" if signed else "positive number"
        raise ModelError(f"the {what} of a column is {quoted(value)}; give a {kind}.", code="axis")
    return above, below


def column_texts(columns: Mapping[str, Any]) -> dict[str, Any]:
    """Columns by role as texts, where they are `Column`."""
    return {role: str(each) if isinstance(each, Column) else each for role, each in columns.items()}
