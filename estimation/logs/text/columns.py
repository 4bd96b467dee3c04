"""Rows of text as columns: numbers by NumPy's parser, what it stumbles over cell by cell."""

import csv
from collections.abc import Iterable
from dataclasses import replace
from functools import partial

import numpy as np

from axisid.estimation.tables import Column, Samples, loaded_column
from axisid.support.arrays import Array
from axisid.support.errors import DataError
from axisid.support.remedy import Remedy

from .dialect import Dialect, Line, is_comment, is_number
from .tail import DROP_TAIL, complete_lines
from .time_stamps import NoStampsError, is_stamp, stamp_seconds


def without_comments(lines: Iterable[Line]) -> list[Line]:
    """Lines without those that are for the reader's eye."""
    return [line for line in lines if not is_comment(line[1])]


def text_columns(source: str, lines: list[Line], dialect: Dialect) -> dict[str, Column]:
    """Columns of lines of text.

    An empty cell is nan. A column of time stamps counts seconds from the first; any other column
    that holds text refuses to be read, with the place of its first such cell.

    Parameters
    ----------
    source : str
        File name, for messages.
    lines : list of (int, str)
        Line numbers and texts, without the header and without comments.
    dialect : Dialect

    Raises
    ------
    DataError
        A row has not as many cells as the header names columns.
    """
    numeric = _numeric(dialect, lines[0][1])
    values = _parse([line for _, line in lines], dialect, numeric)
    if values is None:
        return _parse_slowly(source, lines, dialect)
    numbers = [number for number, _ in lines]
    columns = {k: loaded_column(v) for k, v in zip(numeric, values.T, strict=True)}
    for k in set(range(len(dialect.names))) - set(numeric):
        cells = [_plain(line, dialect)[k] for _, line in lines]
        columns[k] = _of_text(source, dialect, k, numbers, cells)
    return _named(dialect, columns)


def _numeric(dialect: Dialect, line: str) -> list[int]:
    """Columns that hold numbers in a row, if the others hold text."""
    try:
        cells = dialect.cells(line)
    except csv.Error:
        return []
    text = {k for k, c in enumerate(cells) if c and not is_number(c, comma=dialect.comma)}
    return [k for k in range(len(dialect.names)) if k not in text]


def _plain(line: str, dialect: Dialect) -> list[str]:
    return [cell.strip() for cell in line.split(dialect.separator)]


def _named(dialect: Dialect, columns: dict[int, Column]) -> dict[str, Column]:
    """Columns by name, with their units; one without a name is called by its number."""
    return {
        name or f"#{k}": replace(
            columns[k - 1],
            unit=columns[k - 1].unit or dialect.units[k - 1],
            label=dialect.labels[k - 1],
            number=k,
        )
        for k, name in enumerate(dialect.names, 1)
    }


def _parse(lines: list[str], dialect: Dialect, numeric: list[int]) -> Array | None:
    """Some columns of rows as (n, columns) by NumPy's parser; None where it stumbles."""
    delimiter, width = dialect.separator, len(dialect.names)
    separators = lines[0].count(delimiter) if delimiter else width - 1
    some = len(numeric) < width or separators == width
    # Cells beyond those that are asked for are not looked at, so they are counted here.
    if some and (
        not numeric
        or delimiter is None
        or any('"' in line or line.count(delimiter) != separators for line in lines)
    ):
        return None
    if dialect.comma:
        if delimiter == "," or any("." in line for line in lines):
            return None
        lines = "\n".join(line.rstrip("\n") for line in lines).replace(",", ".").split("\n")
    try:
        values = np.loadtxt(
            lines,
            delimiter=delimiter,
            ndmin=2,
            comments=None,
            quotechar='"',
            usecols=numeric if some else None,
        )
    except ValueError:
        return None
    return values if values.shape[1] == len(numeric) else None


def _parse_slowly(source: str, lines: list[Line], dialect: Dialect) -> dict[str, Column]:
    """Cell by cell."""
    width = len(dialect.names)
    values = np.full((len(lines), width), np.nan)
    stumbles: dict[int, int] = {}
    texts: list[list[str]] = []
    for number, line in lines:
        try:
            cells = dialect.cells(line)
        except csv.Error as error:
            raise DataError(f"{source}, line {number} is no row of a table: {error}.") from error
        if len(cells) != width:
            tail = _tail_hint(lines, number, dialect)
            raise DataError(
                f"{source}, line {number}: {len(cells)} cells where the header names {width} "
                f"columns ({', '.join(dialect.names)}). ",
                Remedy.of("Remove or mend the line", tail, "."),
                code="broken-line",
            )
        for k, cell in enumerate(cells):
            if is_number(cell, comma=dialect.comma):
                values[len(texts), k] = float(cell.replace(",", ".") if dialect.comma else cell)
            elif cell:
                stumbles.setdefault(k, len(texts))
        texts.append(cells)
    numbers = [number for number, _ in lines]
    columns = {}
    for k in range(width):
        if k in stumbles:
            cells, row = [text[k] for text in texts], stumbles[k]
            advice = _tail_hint(lines, numbers[row], dialect)
            columns[k] = _of_text(source, dialect, k, numbers, cells, row, advice)
        else:
            columns[k] = loaded_column(values[:, k])
    return _named(dialect, columns)


def _of_text(
    source: str,
    dialect: Dialect,
    k: int,
    numbers: list[int],
    cells: list[str],
    row: int = 0,
    advice: Remedy | None = None,
) -> Column:
    """A column with text in it, first in a row: time stamps, or one that refuses to be read."""
    why = ""
    if is_stamp(cells[row]):
        try:
            seconds, note = stamp_seconds(cells)
        except NoStampsError as error:
            row, why = error.row or row, error.why
        else:
            return loaded_column(seconds, unit="s", note=f"{dialect.names[k]}: {note}")
    where = f"{source}, line {numbers[row]}: {cells[row]!r} in column {dialect.names[k]!r}"
    return Column(read=partial(_refuse, where, why, advice, comma=dialect.comma), texts=cells)


def _tail_hint(lines: list[Line], number: int, dialect: Dialect) -> Remedy | None:
    """More to do about a line that is one of the last."""
    count = complete_lines(lines, dialect)
    ends = count < len(lines) and number >= lines[count][0]
    return Remedy.of(", or leave the end of the log out with ", DROP_TAIL) if ends else None


def _refuse(where: str, why: str, advice: Remedy | None, *, comma: bool) -> Samples:
    if why:
        raise DataError(
            f"{where} is no time stamp that can be read: {why}. Export the log with stamps such as "
            "2026-02-01 12:00:00.250.",
            code="bad-time-stamp",
        )
    raise DataError(
        f"{where} is not a number (decimal {'comma' if comma else 'point'}), nor a time stamp such "
        "as 2026-02-01 12:00:00.250, 1.2.2026 12:00:00 or 12:00:00.250. ",
        Remedy.of("Mend the cell, remove the line, or choose another column", advice, "."),
        code="no-number",
    )
