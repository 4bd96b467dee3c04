"""The end of a text log: a line that was cut off as the logger stopped, or a footer."""

import csv

from axisid.estimation.tables import Repair
from axisid.estimation.thresholds.logs import MAX_INCOMPLETE_LINES
from axisid.support.remedy import Note, Remedy, Setting

from .cut_number import NEIGHBOURS, cut_number
from .dialect import Dialect, Line, is_number
from .time_stamps import is_stamp

#: Leaves out what is no row at the end.
DROP_TAIL = Setting("tail", "drop")
_SHOWN = 40  # characters


def complete_rows(rows: list[Line], dialect: Dialect, *, ended: bool = True) -> int:
    """How many rows there are before the lines at the end that are none; all if these are many.

    Parameters
    ----------
    rows : list of (int, str)
    dialect : Dialect
    ended : bool
        Whether the last line has its end; one that the logger was stopped in has not.
    """
    kinds = [_kind(cell, dialect) for cell in _cells(rows[0][1], dialect)]
    early = _ends_early(rows, dialect) or bool(cut_in_number(rows, dialect, ended=ended))
    first = len(rows) - 1 if early else len(rows)
    for count in range(first, max(len(rows) - MAX_INCOMPLETE_LINES.value, 1) - 1, -1):
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
    *before, last = (_cells(line, dialect) for _, line in rows[-MAX_INCOMPLETE_LINES.value :])
    alike = [cells for cells in before if len(cells) == len(last)]
    return bool(alike) and any(
        not cell and all(others) for cell, *others in zip(last, *alike, strict=True)
    )


def cut_in_number(rows: list[Line], dialect: Dialect, *, ended: bool) -> str:
    """Why the last row looks cut off inside its last number; empty where it does not."""
    lines = [line.rstrip() for _, line in rows[-NEIGHBOURS - 1 :]]
    of_all = [_cells(line, dialect) for line in lines]
    width = len(dialect.names)
    if len(of_all[-1]) != width:
        return ""  # cut off in another cell, which shows
    alike = [(cells[-1], line[-1]) for cells, line in zip(of_all, lines, strict=True) if cells]
    cells = [cell.replace(",", ".") if dialect.comma else cell for cell, _ in alike]
    return cut_number(cells, [end for _, end in alike], ended=ended)


def cut_notes(
    rows: list[Line], dialect: Dialect, *, ended: bool, numbered: bool = True
) -> tuple[Note, ...]:
    """What is said of a last row that looks cut off inside its last number; empty for none."""
    why = cut_in_number(rows, dialect, ended=ended)
    if not why:
        return ()
    number, line = rows[-1]
    where = f"line {number}, the last," if numbered else "the last line"
    found = f"{where} looks cut off inside its last number, {_cells(line, dialect)[-1]!r}: {why}; "
    return (Note(found, Remedy.of("leave it out with ", DROP_TAIL)),)


def without_tail(
    rows: list[Line], dialect: Dialect, *, ended: bool = True
) -> tuple[list[Line], Repair]:
    """The rows without the lines at the end that are none, and what is said of them."""
    count = complete_rows(rows, dialect, ended=ended)
    incomplete = rows[count:]
    if not incomplete:
        return rows, Repair(kind="tail", count=0, text="no incomplete lines at the end")
    number, line = incomplete[0]
    lines = "line" if len(incomplete) == 1 else "lines"
    shown = line.strip() if len(line.strip()) <= _SHOWN else f"{line.strip()[:_SHOWN]}..."
    text = (
        f"{len(incomplete)} incomplete {lines} at the end left out, from line {number}: {shown!r}"
    )
    return rows[:count], Repair(kind="tail", count=len(incomplete), text=text)


def _cells(line: str, dialect: Dialect) -> list[str]:
    try:
        return dialect.cells(line)
    except csv.Error:
        return []


def _kind(cell: str, dialect: Dialect) -> str:
    if is_number(cell, comma=dialect.comma):
        return "number"
    return "stamp" if is_stamp(cell) else "text"
