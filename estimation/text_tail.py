"""The end of a text log: a line that was cut off as the logger stopped, or a footer."""

import csv

from .dialect import Dialect, Line, is_number
from .provenance import Repair
from .time_stamps import is_stamp

_LONGEST = 50  # lines; more is no end but another table
_SHOWN = 40  # characters


def complete_rows(rows: list[Line], dialect: Dialect) -> int:
    """How many rows there are before the lines at the end that are none; all if these are many."""
    kinds = [_kind(cell, dialect) for cell in _cells(rows[0][1], dialect)]
    first = len(rows) - 1 if _ends_early(rows, dialect) else len(rows)
    for count in range(first, max(len(rows) - _LONGEST, 1) - 1, -1):
        cells = _cells(rows[count - 1][1], dialect)
        alike = len(cells) == len(kinds) and all(
            _kind(cell, dialect) == kind or not cell or kind == "text"
            for cell, kind in zip(cells, kinds, strict=True)
        )
        if alike and any(cells):
            return count
    return len(rows)


def _ends_early(rows: list[Line], dialect: Dialect) -> bool:
    """Whether the last line lacks a cell that none of the lines before it lacks."""
    *before, last = (_cells(line, dialect) for _, line in rows[-_LONGEST:])
    alike = [cells for cells in before if len(cells) == len(last)]
    return bool(alike) and any(
        not cell and all(others) for cell, *others in zip(last, *alike, strict=True)
    )


def without_tail(rows: list[Line], dialect: Dialect) -> tuple[list[Line], Repair]:
    """The rows without the lines at the end that are none, and what is said of them."""
    count = complete_rows(rows, dialect)
    left_out = rows[count:]
    if not left_out:
        return rows, Repair(kind="tail", count=0, text="no incomplete lines at the end")
    number, line = left_out[0]
    lines = "line" if len(left_out) == 1 else "lines"
    shown = line.strip() if len(line.strip()) <= _SHOWN else f"{line.strip()[:_SHOWN]}..."
    text = f"{len(left_out)} incomplete {lines} at the end left out, from line {number}: {shown!r}"
    return rows[:count], Repair(kind="tail", count=len(left_out), text=text)


def _cells(line: str, dialect: Dialect) -> list[str]:
    try:
        return dialect.cells(line)
    except csv.Error:
        return []


def _kind(cell: str, dialect: Dialect) -> str:
    if is_number(cell, comma=dialect.comma):
        return "number"
    return "stamp" if is_stamp(cell) else "text"
