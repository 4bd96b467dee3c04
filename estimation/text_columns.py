"""Rows of text as columns: numbers by NumPy's parser, what it stumbles over cell by cell."""

import csv
import re
from collections.abc import Iterable
from dataclasses import replace
from functools import partial

import numpy as np

from .arrays import Array
from .dialect import Dialect, Line, is_comment, is_number
from .errors import DataError
from .table import Column, Samples, at_hand

_DAY_FIRST = re.compile(r"(\d{1,2})\.(\d{1,2})\.(\d{4})[ T](.*)")
_TIME_ONLY = re.compile(r"\d{1,2}:\d{2}:\d{2}(?:[.,]\d+)?")
_STAMP = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d([.,]\d{1,9})?)?Z?")


Origins = dict[int, np.datetime64]


def without_comments(rows: Iterable[Line]) -> list[Line]:
    """Rows without the lines that are for the reader's eye."""
    return [row for row in rows if not is_comment(row[1])]


def text_columns(
    source: str, rows: list[Line], dialect: Dialect, origins: Origins | None = None
) -> dict[str, Column]:
    """Columns of rows of text.

    An empty cell is nan. A column of time stamps counts seconds from the first; any other column
    that holds text refuses to be read, with the place of its first such cell.

    Parameters
    ----------
    source : str
        File name, for messages.
    rows : list of (int, str)
        Line numbers and texts, without the header and without comments.
    dialect : Dialect
    origins : dict of int to datetime64, optional
        The first time stamp of each column, from one block of rows to the next.

    Raises
    ------
    DataError
        A row has not as many cells as the header names columns.
    """
    numeric = _numeric(dialect, rows[0][1])
    values = _parse([line for _, line in rows], dialect, numeric)
    if values is None:
        return _parse_slowly(source, rows, dialect, {} if origins is None else origins)
    origins = {} if origins is None else origins
    columns = {k: at_hand(v) for k, v in zip(numeric, values.T, strict=True)}
    for k in set(range(len(dialect.names))) - set(numeric):
        cells = [_plain(line, dialect)[k] for _, line in rows]
        columns[k] = _of_text(source, dialect, k, rows[0][0], cells, origins)
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
    """Columns by name, with their units; one without a name is left out."""
    return {
        name: replace(columns[k], unit=columns[k].unit or dialect.units[k], label=dialect.labels[k])
        for k, name in enumerate(dialect.names)
        if name
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


def _parse_slowly(
    source: str, rows: list[Line], dialect: Dialect, origins: Origins
) -> dict[str, Column]:
    """Cell by cell."""
    width = len(dialect.names)
    values = np.full((len(rows), width), np.nan)
    stumbles: dict[int, tuple[int, int]] = {}
    texts: list[list[str]] = []
    for number, line in rows:
        try:
            cells = dialect.cells(line)
        except csv.Error as error:
            raise DataError(f"{source}, line {number} is no row of a table: {error}.") from error
        if len(cells) != width:
            raise DataError(
                f"{source}, line {number}: {len(cells)} cells where the header names {width} "
                f"columns ({', '.join(dialect.names)}). Remove or mend the line."
            )
        for k, cell in enumerate(cells):
            if is_number(cell, comma=dialect.comma):
                values[len(texts), k] = float(cell.replace(",", ".") if dialect.comma else cell)
            elif cell:
                stumbles.setdefault(k, (number, len(texts)))
        texts.append(cells)
    columns = {}
    for k in range(width):
        if k in stumbles:
            number, row = stumbles[k]
            cells = [text[k] for text in texts]
            columns[k] = _of_text(source, dialect, k, number, cells, origins, row)
        else:
            columns[k] = at_hand(values[: len(texts), k])
    return _named(dialect, columns)


def _of_text(
    source: str,
    dialect: Dialect,
    k: int,
    number: int,
    cells: list[str],
    origins: Origins,
    row: int = 0,
) -> Column:
    """A column with text in it: time stamps, or one that refuses to be read."""
    cells_iso = [_iso(cell) for cell in cells]
    if all(_STAMP.fullmatch(cell) for cell in cells_iso):
        plain = [cell.rstrip("Z").replace(",", ".") for cell in cells_iso]
        try:
            stamps = np.array(plain, dtype="datetime64[ns]")
        except ValueError:  # no such day
            pass
        else:
            origin = origins.setdefault(k, stamps[0])
            return at_hand((stamps - origin) / np.timedelta64(1, "s"), unit="s")
    return Column(read=partial(_refuse, source, dialect, dialect.names[k], number, cells[row]))


def _iso(cell: str) -> str:
    """A time stamp as ISO 8601 writes it, from ``3.2.2026 12:00:00,250`` or ``12:00:00.250``."""
    if found := _DAY_FIRST.fullmatch(cell):
        day, month, year, rest = found.groups()
        return f"{year}-{month:0>2}-{day:0>2} {rest}"
    if not _TIME_ONLY.fullmatch(cell):
        return cell
    hours, _, rest = cell.partition(":")
    return f"1970-01-01 {hours:0>2}:{rest}"


def _refuse(source: str, dialect: Dialect, name: str, number: int, cell: str) -> Samples:
    mark = "comma" if dialect.comma else "point"
    raise DataError(
        f"{source}, line {number}: {cell!r} in column {name!r} is not a number (decimal "
        f"{mark}), nor a time stamp such as 2026-02-01 12:00:00.250, 1.2.2026 12:00:00 or "
        "12:00:00. Mend the cell, remove the line, or choose another column."
    )
