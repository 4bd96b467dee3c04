"""A column of a log: its name or number, and what its numbers mean."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from axisid.support.errors import ModelError, quoted, refuse

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
#: A number, or a quantity that begins with one.
_QUANTITY = re.compile(rf"\s*{_NUMBER.pattern}.*")
_RATIO = re.compile(rf"\s*{_NUMBER.pattern}\s*(?:/\s*{_NUMBER.pattern}\s*)?")


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
        Turns of the encoder to one of the axis, by which it is divided: ``50``, ``"121/3"``;
        negative where it turns the other way.
    resolution : float or str
        Counts of the encoder to its turn, or what one count is: ``4096``, ``"0.5um"``.

    Raises
    ------
    ModelError
        Something is none of that; what a number makes of a log is looked at where one is read.

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
        said = {what: getattr(self, what) for what in ("resolution", "scale", "offset")}
        refuse(
            ModelError,
            (
                not valid,
                f"the name of a column is {quoted(self.name)}. Give a text, or its number from 1",
            ),
            (
                not isinstance(self.unit, str),
                f"the unit of a column is {quoted(self.unit)}. Give a text",
            ),
            (
                self.resolution != "" and self.unit,
                f"the column {self.name!r} has the unit {self.unit!r} and a resolution, which "
                "applies to counts. Omit one of them",
            ),
            (
                not _RATIO.fullmatch(str(self.gear)),
                f"the gear of a column is {quoted(self.gear)}. Give a number, or two as in 121/3",
            ),
            *(
                (
                    value != "" and not _QUANTITY.fullmatch(str(value)),
                    f"the {what} of a column is {quoted(value)}. Give a number, or a quantity such "
                    "as 360deg/4096",
                )
                for what, value in said.items()
            ),
            code="axis",
        )

    def __str__(self) -> str:
        name = self.name if isinstance(self.name, str) else f"#{self.name}"
        resolution, gear, offset = (
            str(each).strip() for each in (self.resolution, self.gear, self.offset or "")
        )
        counted = self.unit
        if resolution:
            per_turn = "1rev/" if _NUMBER.fullmatch(resolution) else ""
            counted = f"counts*{per_turn}{resolution}"
        scaled = "" if self.scale == 1 else f"*{self.scale}"
        geared = "" if self.gear == 1 else f"/{gear.replace('/', '*')}"
        moved = offset if offset[:1] in ("", "+", "-") else f"+{offset}"
        meaning = f"{counted}{scaled}{geared}{moved}"
        return f"{name}:{meaning}" if meaning else name


def column_texts(columns: Mapping[str, Any]) -> dict[str, Any]:
    """Columns by role as texts, where they are `Column`."""
    return {role: str(each) if isinstance(each, Column) else each for role, each in columns.items()}
