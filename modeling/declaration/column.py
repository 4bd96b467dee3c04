"""A column of a log: its name or number, and the meaning of its numbers."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from axisid.support.checks import refuse
from axisid.support.errors import ModelError
from axisid.support.wording import quoted

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
#: A number, or a quantity that begins with one.
_QUANTITY = re.compile(rf"\s*{_NUMBER.pattern}.*")
_RATIO = re.compile(rf"\s*{_NUMBER.pattern}\s*(?:/\s*{_NUMBER.pattern}\s*)?")


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a log, for `Axis` and `read_record`; ``str`` of it is valid for ``--columns``.

    Attributes
    ----------
    name : str or int
        Name in the log, or number of the column, from 1.
    unit : str
        Unit of its numbers, if the log does not state it or states it wrongly.
    scale : float or str
        Factor of its numbers: a number, or a quantity such as ``"360deg/4096"``; -1 changes the
        sign.
    offset : str
        Offset added after scaling, with its unit: ``"0.2deg"``, ``"-1.5mm"``.
    gear : float or str
        Turns of the encoder per turn of the axis: ``50``, ``"121/3"``; negative if the encoder
        turns in the opposite direction. The numbers are divided by it.
    resolution : float or str
        Counts of the encoder per turn, or the size of one count: ``4096``, ``"0.5um"``.

    Raises
    ------
    ModelError
        A value has another type or form. Units are checked when a log is read.

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
        if isinstance(self.name, int) and not isinstance(self.name, bool):
            is_valid = int(self.name) > 0
        else:
            is_valid = isinstance(self.name, str) and self.name != ""
        quantities = {what: getattr(self, what) for what in ("resolution", "scale", "offset")}
        refuse(
            ModelError,
            (
                not is_valid,
                f"the name of a column is {quoted(self.name)}. Give the name as text, or the "
                "number of the column from 1",
            ),
            (
                not isinstance(self.unit, str),
                f"the unit of a column is {quoted(self.unit)}. Give a text",
            ),
            (
                self.resolution != "" and self.unit,
                f"the column {self.name!r} has the unit {self.unit!r} and a resolution, but a "
                "resolution applies to counts. Omit the unit or the resolution",
            ),
            (
                not _RATIO.fullmatch(str(self.gear)),
                f"the gear of a column is {quoted(self.gear)}. Give a number or a ratio, as in "
                "121/3",
            ),
            *(
                (
                    value != "" and not _QUANTITY.fullmatch(str(value)),
                    f"the {what} of a column is {quoted(value)}. Give a number, or a quantity such "
                    "as 360deg/4096",
                )
                for what, value in quantities.items()
            ),
            code="axis",
        )

    def __str__(self) -> str:
        """Return the column as text for ``--columns``: ``name:unit*scale/gear+offset``."""
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
    """Return the columns by role, with each `Column` as text; other values stay unchanged."""
    return {role: str(each) if isinstance(each, Column) else each for role, each in columns.items()}
