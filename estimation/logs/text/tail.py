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
    early = _ends_early(lines, dialect) or bool(cut_in_number(lines, dialect, ended=ended))
    first = len(lines) - 1 if early else len(lines)
    for count in range(first, max(len(lines) - MAX_INCOMPLETE_LINES.value, 1) - 1, -1):
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
    *before, last = (_cells(line, dialect) for _, line in lines[-MAX_INCOMPLETE_LINES.value :])
    alike = [cells for cells in before if len(cells) == len(last)]
    return bool(alike) and any(
        not cell and all(others) for cell, *others in zip(last, *alike, strict=True)
    )


def cut_in_number(lines: list[Line], dialect: Dialect, *, ended: bool) -> str:
    """Why the last line looks cut off inside its last number; empty where it does not."""
    last = [line.rstrip() for _, line in lines[-NEIGHBOURS - 1 :]]
    of_all = [_cells(line, dialect) for line in last]
    width = len(dialect.names)
    if len(of_all[-1]) != width:
        return ""  # cut off in another cell, which shows
    alike = [(cells[-1], line[-1]) for cells, line in zip(of_all, last, strict=True) if cells]
    cells = [cell.replace(",", ".") if dialect.comma else cell for cell, _ in alike]
    return cut_number(cells, [end for _, end in alike], ended=ended)


def cut_notes(lines: list[Line], dialect: Dialect, *, ended: bool) -> tuple[Note, ...]:
    """What is said of a last line that looks cut off inside its last number; empty for none."""
    why = cut_in_number(lines, dialect, ended=ended)
    if not why:
        return ()
    number, line = lines[-1]
    last = _cells(line, dialect)[-1]
    found = f"line {number}, the last, looks cut off inside its last number, {last!r}: {why}; "
    return (Note(found, Remedy.of("leave it out with ", DROP_TAIL)),)


def without_tail(
    lines: list[Line], dialect: Dialect, *, ended: bool = True
) -> tuple[list[Line], Repair]:
    """The lines without those at the end that are none, and what is said of them."""
    count = complete_lines(lines, dialect, ended=ended)
    incomplete = lines[count:]
    if not incomplete:
        return lines, Repair(kind="tail", count=0, text="no incomplete lines at the end")
    number, line = incomplete[0]
    what = "line" if len(incomplete) == 1 else "lines"
    shown = line.strip() if len(line.strip()) <= _SHOWN else f"{line.strip()[:_SHOWN]}..."
    text = f"{len(incomplete)} incomplete {what} at the end left out, from line {number}: {shown!r}"
    return lines[:count], Repair(kind="tail", count=len(incomplete), text=text)


def _cells(line: str, dialect: Dialect) -> list[str]:
    try:
        return dialect.cells(line)
    except csv.Error:
        return []


def _kind(cell: str, dialect: Dialect) -> str:
    if is_number(cell, comma=dialect.comma):
        return "number"
    return "stamp" if is_stamp(cell) else "text"
