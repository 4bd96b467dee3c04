"""Conversion of time stamps to seconds from the first time stamp; ambiguous ones are refused."""

import re
from collections.abc import Iterable, Sequence
from datetime import date

import numpy as np

from axisid.support.arrays import Array

_DAY = 86_400
_SECOND = 1_000_000_000  # ns
_STAMP = re.compile(
    r"(?:(?P<date>\d{4}-\d\d?-\d\d?|\d{4}/\d\d?/\d\d?|\d\d?\.\d\d?\.\d{4}|\d\d?/\d\d?/\d{4}"
    r"|[+-]?\d{1,6} days?,?)(?:T|\s+\+?))?"
    r"(?P<hour>[01]?\d|2[0-3]):(?P<minute>[0-5]\d)"
    r"(?::(?P<second>[0-5]\d)(?:[.,](?P<fraction>\d{1,9}))?)?"
    r"(?:\s*(?P<half>[AaPp][Mm]))?"
    r"(?:\s*(?P<zone>Z|UTC|GMT|[+-]\d\d(?::?\d\d)?|[A-Z]{3,4}|[A-Z]\w+(?:/[\w+-]+){1,2}))?"
    r"(?:\[[\w/+-]+\])?"
)
_UTC_OFFSET = re.compile(r"([+-])(\d\d):?(\d\d)?")


class TimeStampError(ValueError):
    """Error of cells that are not time stamps of one format.

    Attributes
    ----------
    row : int
        Index of the first cell that is not a time stamp; 0 if the formats of cells differ.
    why : str
        Reason, if the cell is similar to a time stamp; empty for another text.
    """

    def __init__(self, row: int, why: str = "") -> None:
        super().__init__(why)
        self.row, self.why = row, why


def is_stamp(cell: str) -> bool:
    """Return True if a cell is a time stamp.

    Hours and minutes without seconds need a date, or am or pm.
    """
    return _groups(cell) is not None


def _groups(cell: str) -> tuple[str, ...] | None:
    """Return date, hour, minute, second, fraction, am or pm, and zone of a time stamp as texts.

    A missing part is empty. None for a cell that is not a time stamp.
    """
    match = _STAMP.fullmatch(cell)
    if match is None:
        return None
    parts = match.groups("")
    is_hour = not parts[5] or 1 <= int(parts[1]) <= 12
    return parts if is_hour and (parts[0] or parts[3] or parts[5]) else None


def stamp_seconds(cells: Sequence[str]) -> tuple[Array, str]:
    """Return the seconds from the first time stamp, (N,), and a note on assumptions.

    Empty cells are NaN. Dates are ``2026-02-01``, ``2026/02/01``, ``1.2.2026`` (the day first), and
    ``02/01/2026`` if only one order of day and month fits, or all stamps have one date. Zones such
    as ``+01:00`` or ``UTC`` are taken into account. A named zone, such as ``CET``, must be that of
    all stamps, and is ignored. Without dates, a step back by more than half a day is midnight.

    Raises
    ------
    TimeStampError
        A cell is not a time stamp, a day does not exist, the formats differ, or the order of day
        and month is ambiguous.
    """
    # Parts of the filled cells.
    filled = [k for k, cell in enumerate(cells) if cell]
    groups = [_groups(cells[k]) for k in filled]
    if None in groups:
        raise TimeStampError(filled[groups.index(None)])
    stamps = [parts for parts in groups if parts]
    # All stamps must have one format, and the same zone if it is a name.
    dates, *_, halves, zones = zip(*stamps, strict=True)
    has_named_zone = any(
        not (zone in ("", "Z", "UTC", "GMT") or _UTC_OFFSET.fullmatch(zone))
        for zone in dict.fromkeys(zones)
    )
    for part in (dates, halves, zones):
        if ("" in part and any(part)) or (part is zones and has_named_zone and len({*zones}) > 1):
            raise TimeStampError(0, "the column mixes several formats of time stamps")
    # Days, and nanoseconds since midnight.
    order, note = _order(dict.fromkeys(dates))
    numbers = {}
    for text in dict.fromkeys(dates):
        try:
            numbers[text] = _day(text, order)
        except ValueError as error:
            raise TimeStampError(filled[dates.index(text)], "there is no such day") from error
    days = np.array([numbers[text] for text in dates], dtype=np.int64)
    within = np.array([_since_midnight(*parts[1:]) for parts in stamps], dtype=np.int64)
    if not any(dates):
        days = np.cumsum(np.diff(within, prepend=within[0]) < -_DAY * _SECOND // 2)
        if days[-1]:
            note = ", continued over midnight when they restart"
    seconds = np.full(len(cells), np.nan)
    seconds[filled] = (days - days[0]) * _DAY + (within - within[0]) / _SECOND
    return seconds, f"time stamps, relative to the first{note}"


def _since_midnight(
    hour: str, minute: str, second: str, fraction: str, half: str, zone: str
) -> int:
    """Return the nanoseconds since midnight from the parts of a time stamp.

    It is midnight in UTC if the zone is an offset from UTC. `half` is am, pm or empty.
    """
    hours = int(hour) % 12 + 12 * (half.lower() == "pm") if half else int(hour)
    seconds = hours * 3600 + int(minute) * 60 + int(second or "0")
    if offset := _UTC_OFFSET.fullmatch(zone):
        sign, zone_hours, zone_minutes = offset.groups("0")
        seconds -= int(f"{sign}1") * (int(zone_hours) * 3600 + int(zone_minutes) * 60)
    return seconds * _SECOND + int(fraction.ljust(9, "0"))


def _order(dates: Iterable[str]) -> tuple[str, str]:
    """Return the part that comes first in dates with slashes, ``day`` or ``month``, and a note.

    The note is empty if no assumption was needed.

    Raises
    ------
    TimeStampError
        The dates do not show which part comes first.
    """
    slashed = {tuple(map(int, text.split("/"))) for text in dates if text.find("/") in (1, 2)}
    day_first = any(first > 12 for first, _, _ in slashed)
    month_first = any(second > 12 for _, second, _ in slashed)
    if len(slashed) < 2:
        return ("month" if month_first else "day"), ""
    if day_first or month_first:
        order = "day" if day_first else "month"
        return order, f", dates with the {order} first"
    raise TimeStampError(0, "the order of day and month in its dates is ambiguous")


def _day(text: str, order: str) -> int:
    """Return the number of the day of a date, or of a count such as ``3 days``; 0 for no date.

    `order`, ``day`` or ``month``, is the part that comes first in dates that end with the year.
    """
    if not text or "day" in text:
        return int((text or "0").split(maxsplit=1)[0])
    parts = [int(part) for part in re.split(r"[-./]", text)]
    year, month, day = parts if parts[0] > 31 else (parts[2], parts[1], parts[0])
    if order == "month":
        month, day = day, month
    return date(year, month, day).toordinal()
