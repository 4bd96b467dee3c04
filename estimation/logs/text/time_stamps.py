"""Time stamps in seconds from the first, as they are written; what may mean two is refused."""

import re
from collections.abc import Callable, Hashable, Iterable, Sequence
from datetime import date, datetime, time
from functools import partial
from typing import TypeVar
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

import numpy as np
from numpy.typing import NDArray

from axisid.support.arrays import Array

_DAY = 86_400
_SECOND = 1_000_000_000  # ns
_STAMP = re.compile(
    r"(?:(?P<date>\d{4}-\d\d?-\d\d?|\d{4}/\d\d?/\d\d?|\d\d?\.\d\d?\.\d{4}|\d\d?/\d\d?/\d{4}"
    r"|[+-]?\d{1,6} days?,?)(?:T|\s+\+?))?"
    r"(?P<hour>\d\d?):(?P<minute>\d\d)(?::(?P<second>\d\d)(?:[.,](?P<fraction>\d{1,9}))?)?"
    r"(?:\s*(?P<half>[AaPp][Mm]))?"
    r"(?:\s*(?P<zone>Z|UTC|GMT|[+-]\d\d(?::?\d\d)?|[A-Z]{3,4}|[A-Z]\w+(?:/[\w+-]+){1,2}))?"
    r"(?:\[[\w/+-]+\])?"
)
#: Hours by which zones of three or four letters are ahead of UTC, where they name one alone.
_ZONES = {
    "Z": 0,
    "UTC": 0,
    "GMT": 0,
    "WET": 0,
    "WEST": 1,
    "BST": 1,
    "CET": 1,
    "MEZ": 1,
    "CEST": 2,
    "MESZ": 2,
    "EET": 2,
    "EEST": 3,
    "MSK": 3,
    "JST": 9,
    "EST": -5,
    "EDT": -4,
    "CST": -6,
    "CDT": -5,
    "MST": -7,
    "MDT": -6,
    "PST": -8,
    "PDT": -7,
}
_HOUR = 3600
_SLASHED = re.compile(r"\d\d?/\d\d?/\d{4}")

_Whole = NDArray[np.int64]
_Part = TypeVar("_Part", bound=Hashable)


class NoStampsError(ValueError):
    """Cells that are no time stamps of one kind.

    Attributes
    ----------
    row : int
        The first cell that is none.
    why : str
        Where it is no mere text.
    """

    def __init__(self, row: int, why: str = "") -> None:
        super().__init__(why)
        self.row, self.why = row, why


def is_stamp(cell: str) -> bool:
    """Whether a cell is a time stamp; hours and minutes alone need a date or a half of the day."""
    return _groups(cell) is not None


def _groups(cell: str) -> tuple[str, ...] | None:
    """Date, hour, minute, second, fraction, half of the day and zone; None for no stamp."""
    found = _STAMP.fullmatch(cell)
    if found is None:
        return None
    parts = found.groups("")
    return parts if parts[0] or parts[3] or parts[5] else None


def stamp_seconds(cells: Sequence[str]) -> tuple[Array, str]:
    """Seconds from the first stamp, nan where a cell is empty, and what was assumed.

    Dates are ``2026-02-01``, ``2026/02/01``, ``1.2.2026`` (the day first), and ``02/01/2026`` where
    only one order of day and month fits or all stamps are of one date. Zones such as ``+01:00`` or
    ``UTC`` count; without dates, a step back by more than half a day is midnight.

    Raises
    ------
    NoStampsError
        A cell is no time stamp, there is no such time, or the order of day and month is open.
    """
    filled = [k for k, cell in enumerate(cells) if cell]
    seconds = np.full(len(cells), np.nan)
    try:
        seconds[filled], note = _filled_seconds([cells[k] for k in filled])
    except NoStampsError as error:
        raise NoStampsError(filled[error.row], error.why) from error
    return seconds, f"time stamps counted from the first{note}"


def _filled_seconds(cells: Sequence[str]) -> tuple[Array, str]:
    """Seconds from the first stamp, of cells none of which is empty."""
    found = [_groups(cell) for cell in cells]
    if None in found:
        raise NoStampsError(found.index(None))
    dates, *times, zones = zip(*(parts for parts in found if parts), strict=True)
    for part in (dates, times[-1], zones):
        if "" in part and any(part):
            raise NoStampsError(0, "its stamps are of several kinds")
    local = _since_midnight(*times)
    order, note = _order(dict.fromkeys(dates))
    days = _mapped(dates, lambda text: _day(text, order))
    if any("/" in zone for zone in dict.fromkeys(zones)) and any(dates):
        within = local - _SECOND * _ahead_by_place(zones, days, local)
    else:
        within = local - _SECOND * _mapped(zones, _zone)
    if not any(dates):
        days = np.cumsum(np.diff(within, prepend=within[0]) < -_DAY * _SECOND // 2)
        if days[-1]:
            note = ", over midnight where they start again"
    return (days - _day(dates[0], order)) * _DAY + (within - within[0]) / _SECOND, note


def _mapped(texts: Sequence[_Part], number: Callable[[_Part], int]) -> _Whole:
    """A whole number for each part of a stamp; equal ones, which are many, are read once."""
    table: dict[_Part, int] = {}
    for text in dict.fromkeys(texts):
        try:
            table[text] = number(text)
        except NoStampsError as error:
            raise NoStampsError(texts.index(text), error.why) from error
    return np.array([table[text] for text in texts], dtype=np.int64)


def _since_midnight(
    hours: Sequence[str],
    minutes: Sequence[str],
    seconds: Sequence[str],
    fractions: Sequence[str],
    halves: Sequence[str],
) -> _Whole:
    """Nanoseconds since midnight."""
    hour, minute = _mapped(hours, int), _mapped(minutes, int)
    second = _mapped(seconds, lambda text: int(text or "0"))
    fraction = _mapped(fractions, lambda text: int(text.ljust(9, "0")))
    outside = (minute > 59) | (second > 59) | (hour > 23)
    if halves[0]:
        outside |= (hour < 1) | (hour > 12)
        hour = hour % 12 + 12 * np.array([half in ("PM", "pm", "Pm", "pM") for half in halves])
    if outside.any():
        raise NoStampsError(int(np.argmax(outside)), "there is no such time")
    return (hour * 3600 + minute * 60 + second) * _SECOND + fraction


def _zone(text: str) -> int:
    """Seconds by which a zone is ahead of UTC; one of a place alone says nothing without a date."""
    if not text or "/" in text:
        return 0
    if text in _ZONES:
        return _ZONES[text] * _HOUR
    if text[0] not in "+-":
        raise NoStampsError(0, f"the zone {text!r} is not known")
    digits = text[1:].replace(":", "").ljust(4, "0")
    ahead = int(digits[:2]) * _HOUR + int(digits[2:]) * 60
    return -ahead if text[0] == "-" else ahead


def _ahead_by_place(zones: Sequence[str], days: _Whole, local: _Whole) -> _Whole:
    """Seconds by which the clock of a place is ahead of UTC, by the day and the time of day.

    The hour that an autumn's night has twice is the second one from where the stamps go back.
    """
    minutes = local // (60 * _SECOND)
    moments = [*zip(zones, days.tolist(), minutes.tolist(), strict=True)]
    ahead, later = (_mapped(moments, partial(_ahead, fold=fold)) for fold in (0, 1))
    twice = ahead != later
    seconds = days * _DAY + local // _SECOND - ahead
    back = np.diff(seconds, prepend=seconds[0]) < -_HOUR // 4
    again = twice & (np.cumsum(back & twice) > 0)
    return np.asarray(np.where(again, later, ahead), dtype=np.int64)


def _ahead(at: tuple[str, int, int], fold: int) -> int:
    """Seconds by which a zone is ahead of UTC, by its name, at a minute of a day of its own."""
    zone, day, minute = at
    if "/" not in zone:
        return _zone(zone)
    moment = datetime.combine(date.fromordinal(day), time(minute // 60, minute % 60, fold=fold))
    try:
        ahead = moment.replace(tzinfo=ZoneInfo(zone)).utcoffset()
    except (ZoneInfoNotFoundError, ValueError, OSError) as error:
        raise NoStampsError(0, f"the zone {zone!r} is not known") from error
    return 0 if ahead is None else int(ahead.total_seconds())


def _order(dates: Iterable[str]) -> tuple[str, str]:
    """Which of ``day`` and ``month`` comes first in dates with slashes, and what is said of it."""
    if "" in dates:
        return "day", ""
    slashed = {tuple(map(int, text.split("/"))) for text in dates if _SLASHED.fullmatch(text)}
    day_first = any(first > 12 for first, _, _ in slashed)
    month_first = any(second > 12 for _, second, _ in slashed)
    if len(slashed) < 2:
        return ("month" if month_first else "day"), ""
    if day_first or month_first:
        order = "day" if day_first else "month"
        return order, f", dates with the {order} first"
    raise NoStampsError(0, "its dates may have the day or the month first")


def _day(text: str, order: str) -> int:
    """Number of a day."""
    if not text:
        return 0
    if "day" in text:
        return int(text.split(maxsplit=1)[0])
    parts = [int(part) for part in re.split(r"[-./]", text)]
    year, month, day = parts if parts[0] > 31 else (parts[2], parts[1], parts[0])
    if order == "month":
        month, day = day, month
    try:
        return date(year, month, day).toordinal()
    except ValueError as error:
        raise NoStampsError(0, "there is no such day") from error
