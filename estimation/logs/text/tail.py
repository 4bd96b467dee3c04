"""The end of a text log: a line that was cut off as the logger stopped, or a footer."""

import csv

from axisid.estimation.tables import Repair
from axisid.support.remedy import Setting

from .dialect import Dialect, Line, is_number
from .time_stamps import is_stamp

_MAX_INCOMPLETE_LINES = 50  # unlike lines are an incomplete end; more are another table

#: Leaves out what is no row at the end.
DROP_TAIL = Setting("tail", "drop")
_SHOWN = 40  # characters
_NEIGHBOURS = 20  # lines above the last whose last numbers tell how long it should be


def complete_lines(lines: list[Line], dialect: Dialect, *, ended: bool = True) -> int:
    """How many lines are rows before those at the end that are none; all if these are many.

    Parameters
    ----------
    lines : list of (int, str)
    dialect : Dialect
    ended : bool
        Whether the last line has its end; one that the logger was stopped in has not.
    """
    kinds = [_kind(cell, dialect) for cell in _cells(lines[0][1], dialect)]
    early = _ends_early(lines, dialect) or (not ended and is_cut(lines, dialect))
    first = len(lines) - 1 if early else len(lines)
    for count in range(first, max(len(lines) - _MAX_INCOMPLETE_LINES, 1) - 1, -1):
        cells = _cells(lines[count - 1][1], dialect)
        alike = len(cells) == len(kinds) and all(
            _kind(cell, dialect) == kind or not cell or kind == "text"
            for cell, kind in zip(cells, kinds, strict=True)
        )
        if alike and any(cells):
            return count
    return len(lines)


def _ends_early(lines: list[Line], dialect: Dialect) -> bool:
    """Whether the last line lacks a cell that none of the lines before it lacks."""
    *before, last = (_cells(line, dialect) for _, line in lines[-_MAX_INCOMPLETE_LINES:])
    alike = [cells for cells in before if len(cells) == len(last)]
    return bool(alike) and any(
        not cell and all(others) for cell, *others in zip(last, *alike, strict=True)
    )


def is_cut(lines: list[Line], dialect: Dialect) -> bool:
    """Whether the last number of a text without a last line end is shorter than all above it."""
    rows = [_cells(line, dialect) for _, line in lines[-_NEIGHBOURS - 1 :]]
    if len(rows) <= _NEIGHBOURS or any(len(row) != len(dialect.names) for row in rows):
        return False  # cut off in another cell, which shows, or too few to tell
    *above, last = (len(row[-1].lstrip("+-")) for row in rows)
    return 0 < last < min(above)


def left_out(lines: list[Line]) -> Repair:
    """What is said of lines at the end that are left out."""
    if not lines:
        return Repair(kind="tail", count=0, text="no incomplete lines at the end")
    number, line = lines[0]
    what = "line" if len(lines) == 1 else "lines"
    shown = line.strip() if len(line.strip()) <= _SHOWN else f"{line.strip()[:_SHOWN]}..."
    text = f"{len(lines)} incomplete {what} at the end left out, from line {number}: {shown!r}"
    return Repair(kind="tail", count=len(lines), text=text)


def _cells(line: str, dialect: Dialect) -> list[str]:
    try:
        return dialect.cells(line)
    except csv.Error:
        return []


def _kind(cell: str, dialect: Dialect) -> str:
    if is_number(cell, comma=dialect.comma):
        return "number"
    return "stamp" if is_stamp(cell) else "text"
