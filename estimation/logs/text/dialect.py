"""Dialect of a table in a text: separator, decimal mark, header, units and first data row.

The dialect is the one that fits the first lines of the text best.
"""

import csv
import re
from collections import Counter
from dataclasses import dataclass
from typing import NamedTuple

from axisid.estimation.raw_tables import is_unit, split_labels
from axisid.support.checks import refuse
from axisid.support.errors import DataError

from .time_stamps import is_stamp

#: Separators in the order of preference where several fit; None is any run of blanks.
_SEPARATORS = (";", "\t", ",", "|", None)
_SAMPLE = 400  # number of first lines from which the dialect is found
_MOST_COLUMNS = 10_000
#: Names of separators, for the user.
_NAMED = {";": "semicolon", "\t": "tab", ",": "comma", "|": "bar", None: "blanks", " ": "blank"}
#: Text of a spreadsheet for a missing number, `#N/A` or `#DIV/0!`, before another cell.
_SHEET_ERROR = re.compile(r"\s*#(N/A|NV|[^\W\d_a-z]+(/0)?[!?])\s*[;\t,| ]")
#: Patterns of a number with a decimal point, and with a decimal comma.
_NUMBERS = tuple(
    re.compile(
        rf"\s*[+-]?((\d+{mark}?\d*|{mark}\d+)(e[+-]?\d+)?|nan|inf(inity)?)\s*",
        re.ASCII | re.IGNORECASE,
    )
    for mark in (r"\.", ",")
)
#: Pattern of a number in which a comma may separate thousands.
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+")

#: Number of a line in the file, and its text.
Line = tuple[int, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class Dialect:
    """Format of the table in a text.

    Attributes
    ----------
    separator : str or None
        Separator of the cells; None for any run of blanks.
    comma : bool
        True if numbers have a decimal comma.
    names, units, labels : tuple of str
        Names, units and whole headers of the columns; a unit is empty if none is written.
    first : int
        Index of the first row of data among the filled lines.
    notes : tuple of str
        Assumptions, for the user.
    """

    separator: str | None
    comma: bool
    names: tuple[str, ...]
    units: tuple[str, ...]
    labels: tuple[str, ...]
    first: int
    notes: tuple[str, ...]

    def cells(self, line: str) -> list[str]:
        """Return the cells of a line, stripped, without an empty cell after a last separator."""
        return split_cells(line, self.separator, len(self.names))


def how_written(separator: str | None, *, comma: bool) -> str:
    """Return a text on separator and decimal mark, such as ``separator comma, decimal point``."""
    named = _NAMED.get(separator, repr(separator))
    return f"separator {named}, decimal {'comma' if comma else 'point'}"


def split_cells(line: str, separator: str | None, width: int | None = None) -> list[str]:
    """Return the cells of a line, stripped.

    `separator` is None for any run of blanks. If the number of columns (`width`) is given, an empty
    cell after a last separator is left out.
    """
    if separator is None:
        return line.replace('"', "").split()
    cells = line.split(separator)
    if '"' in line:
        try:
            cells = next(csv.reader([line], delimiter=separator, skipinitialspace=True))
        except csv.Error:
            return [line]
    cells = [cell.strip() for cell in cells]
    return cells if len(cells) - 1 != width or cells[-1] else cells[:-1]


def is_comment(line: str) -> bool:
    """Return True if a line is a comment."""
    return line.lstrip().startswith(("#", "%", "//")) and not _SHEET_ERROR.match(line)


def is_number(cell: str, *, comma: bool = False) -> bool:
    """Return True if a cell is a number with a decimal point; with a decimal comma if `comma`."""
    return bool(_NUMBERS[comma].fullmatch(cell))


def sniff(source: str, lines: list[Line]) -> Dialect:
    """Return the dialect of the filled lines of a file.

    First the separator, decimal mark and number of columns that fit the first lines best are found.
    Then header and units are read from the lines above the data, and the decimal mark is decided
    from later lines if the first lines leave it open.

    Parameters
    ----------
    source : str
        File name, for messages.
    lines : list of (int, str)
        Line numbers and texts of the filled lines.

    Raises
    ------
    DataError
        There is no table, or the text is ambiguous.
    """
    # The first lines that are not comments, with their indices.
    sample = [(i, line) for i, (_, line) in enumerate(lines[:_SAMPLE]) if not is_comment(line)]
    longest = max((line for _, line in sample), key=len, default="")
    width = max(len(longest.split(separator)) for separator in _SEPARATORS)
    refuse(
        DataError,
        (
            len(sample) < 2,
            f"{source}: the text has {len(sample)} filled lines, but a header row and samples are "
            "expected. Export the log again, or give another file",
        ),
        (
            width > _MOST_COLUMNS,  # a line this long is not a sample, and would take minutes
            f"{source}: a line has {width} cells. A log has at most {_MOST_COLUMNS} columns and "
            "one sample per row. Transpose the table if it has one column per sample",
        ),
        code="log-text",
    )
    separator, comma, width, first, *_ = _best(source, sample)
    # Header and units.
    header, units, note = _header(
        source, lines, [i for i, _ in sample if i < first], first, separator, width
    )
    split = split_labels(header)
    names = [name for name, _ in split]
    # Decimal mark: a comma is one if numbers have commas, and no number has a point.
    body = [line for i, line in sample if i >= first]
    if not comma and separator != ",":
        body = _until_decided(lines, body, separator)
        comma = not _marked(body, separator, ".") and bool(_marked(body, separator, ","))
    stamp = next(filter(is_stamp, names), None)
    marked = _marked(body, separator, ",") if comma else []
    refuse(
        DataError,
        (
            stamp,
            f"{source}, line {lines[max(first - 1, 0)][0]}: the time stamp {stamp!r} is in the "
            "row directly above the first numbers, where the names of the columns are expected. "
            "Complete the row, or remove it",
            "log-text",
        ),
        (
            all(is_number(name) for name in names),
            f"{source}: the first row has numbers ({', '.join(names[:4])}) instead of names. Write "
            "the names of the columns above the first row",
        ),
        (
            marked and all(_THOUSANDS.fullmatch(cell) for cell in marked),
            f"{source}: {next(iter(marked), '')!r} is ambiguous: the comma can be a decimal comma "
            "or separate thousands. Export the log with a decimal point",
            "log-text",
        ),
    )
    return Dialect(
        separator=separator,
        comma=comma,
        names=tuple(names),
        # A unit in the row of units is used instead of a unit in the header.
        units=tuple(
            u.strip("[]()- ") or head_unit for u, (_, head_unit) in zip(units, split, strict=True)
        ),
        labels=tuple(header),
        first=first,
        notes=(how_written(separator, comma=comma), *([note] if note else [])),
    )


class _Reading(NamedTuple):
    """A possible dialect of the first lines of a text, with its quality of fit.

    Attributes
    ----------
    separator : str or None
        Separator of the cells; None for any run of blanks.
    comma : bool
        True if numbers have a decimal comma.
    width : int
        Number of columns.
    first : int
        Index of the first row of data among the filled lines.
    table_rows : int
        Number of rows of the table among the first lines.
    fit : (float, bool, bool, int)
        Quality of fit, by which dialects are ordered: share of numbers among the cells, True with a
        header, True for a decimal point or if a number has a decimal comma, and number of columns.
    """

    separator: str | None
    comma: bool
    width: int
    first: int
    table_rows: int
    fit: tuple[float, bool, bool, int]


def _best(source: str, sample: list[tuple[int, str]]) -> _Reading:
    """Return the reading of the first lines whose dialect fits best.

    Parameters
    ----------
    source : str
        Name of the file, for messages.
    sample : list of (int, str)
        Indices and texts of the first filled lines.

    Raises
    ------
    DataError
        No dialect gives a table of numbers.
    """
    quoted = any('"' in line for _, line in sample)
    tried = [
        _reading(sample, separator, comma)
        for separator in _SEPARATORS
        for comma in (False, True)
        if quoted or (separator, comma) != (",", True)
    ]
    readings = [reading for reading in tried if reading is not None]
    if not readings:
        raise DataError(
            f"{source}: no table of numbers was found in the first {len(sample)} filled lines. "
            "Export the log with a header row and rows of numbers below it, separated by comma, "
            "semicolon, tab, bar or blanks.",
            code="log-text",
        )
    if any(reading.width > 1 and reading.fit[1] for reading in readings):
        # A comma that fits a header of several names is no decimal mark of one column.
        readings = [r for r in readings if r.width > 1 or not r.comma]
    # Compare the readings with nearly the largest number of rows by their fit.
    enough = 0.9 * max(reading.table_rows for reading in readings)
    readings = [reading for reading in readings if reading.table_rows >= enough]
    return max(readings, key=lambda reading: reading.fit)  # the first of equals


def _reading(sample: list[tuple[int, str]], separator: str | None, comma: bool) -> _Reading | None:
    """Return the reading of the first lines with a separator and a decimal mark.

    None if no row of numbers is found.

    Parameters
    ----------
    sample : list of (int, str)
        Indices and texts of the first filled lines.
    separator : str or None
        Separator of the cells; None for any run of blanks.
    comma : bool
        True if numbers have a decimal comma.
    """
    # Cells of each line, and a flag for each cell that is a number.
    rows = [(i, split_cells(line, separator)) for i, line in sample]
    numbers = [[is_number(cell, comma=comma) for cell in cells] for _, cells in rows]
    # In a line with a number, time stamps count as numbers.
    numeric = [
        [of or (any(flags) and is_stamp(cell)) for of, cell in zip(flags, cells, strict=True)]
        for flags, (_, cells) in zip(numbers, rows, strict=True)
    ]
    # Share of numbers among the filled cells, and number of cells, of each line.
    shares = [
        (sum(flags) / max(sum(1 for c in cells if c), 1), len(cells))
        for (_, cells), flags in zip(rows, numeric, strict=True)
    ]
    least = 0.5  # smallest share of numbers among the filled cells of a row of the table
    tabular = [width for share, width in shares if share >= least]
    if not tabular:
        return None
    # The rows of the table have the most frequent number of cells.
    width = Counter(tabular).most_common(1)[0][0]
    body = [k for k, (share, w) in enumerate(shares) if share >= least and w == width]
    # The data begin at two rows of the table in succession; a single row above is not part of it.
    begin = next((k for k in body if k + 1 in body), body[0])
    flags = [flag for row in numeric[begin:] for flag in row]
    cells = [c for _, row in rows[begin:] for c in row]
    # A separator at the end of every row gives an empty last column, which does not count.
    trailing = width > 1 and not any(rows[k][1][-1] for k in body if k >= begin)
    share = sum(flags) / max(sum(1 for c in cells if c), 1)
    above = rows[begin - 1][1] if begin > 0 else []
    width -= trailing
    named = len(above) in (width, width + 1) and not any(
        is_number(cell, comma=comma) for cell in above
    )
    # A decimal comma must occur in a number; a decimal point is assumed.
    used = not comma or any("," in c for c in cells)
    return _Reading(
        separator,
        comma,
        width,
        rows[begin][0],
        sum(k >= begin for k in body),
        (share, named, used, width),
    )


def _header(
    source: str,
    lines: list[Line],
    above: list[int],
    first: int,
    separator: str | None,
    width: int,
) -> tuple[list[str], list[str], str]:
    """Return the cells of the header, the cells of the row of units, and a note for the user.

    The header is the last line above the data, or the line above it if the last line is a row of
    units. Comments are not considered, unless all lines above the data are comments: then those
    with as many cells as the table has columns are considered. Without such a comment, there is no
    header row, and the columns are named ``#1``, ``#2``, ...

    The units are empty texts if there is no row of units. The note says that there is no header
    row, or that lines above the header are ignored; otherwise it is empty.

    Parameters
    ----------
    source : str
        Name of the file, for messages.
    lines : list of (int, str)
        Line numbers and texts.
    above : list of int
        Indices of the lines above the data that are not comments.
    first : int
        Index of the first row of data.
    separator : str or None
        Separator of the cells; None for any run of blanks.
    width : int
        Number of columns.

    Raises
    ------
    DataError
        The header has another number of cells than the rows.
    """

    def cells(index: int) -> list[str]:
        """Return the cells of a filled line, by its index, without marks of a comment."""
        return split_cells(lines[index][1].lstrip("#%/ "), separator, width)

    # Choose the header row, and the row of units below it.
    commented = [i for i in range(first) if is_comment(lines[i][1]) and len(cells(i)) == width]
    candidates = above or commented
    if not candidates:
        return (
            [f"#{k}" for k in range(1, width + 1)],
            [""] * width,
            "there is no header row, so columns are named by their numbers",
        )
    header_row = candidates[-1]
    header, units = cells(header_row), [""] * width
    if len(candidates) > 1 and _is_unit_row(header):
        row_above = cells(candidates[-2])
        if len(header) == len(row_above) == width:
            header_row, header, units = candidates[-2], row_above, header
    # Check the width of the header.
    if len(header) != width:
        raise DataError(
            f"{source}, line {lines[header_row][0]}: the header names {len(header)} columns "
            f"({', '.join(header[:6])}), but the rows have {width} cells. Correct the header row. "
            "If numbers have a decimal comma, separate the columns by semicolon or tab.",
            code="log-text",
        )
    note = ""
    if header_row > 0:
        note = f"the header is in line {lines[header_row][0]}, and the lines above it are ignored"
    return header, units, note


def _is_unit_row(cells: list[str]) -> bool:
    """Return True for a row of units, in which half of the cells or more are units.

    Cells that mark a missing unit, such as `-` and `[]`, are not counted.
    """
    filled = [cell.strip("[]()") for cell in cells if cell.strip("[]()-")]
    units = sum(is_unit(c) and not is_number(c) for c in filled)
    return any(cells) and 2 * units >= len(filled)


def _until_decided(lines: list[Line], body: list[str], separator: str | None) -> list[str]:
    """Return rows of data in which a number has a decimal mark, if there are any.

    These are the first rows (`body`), or later ones if no number of the first rows has a decimal
    mark: the log of an axis at rest may begin with plain zeros.
    """
    if _marked(body, separator, ".") or _marked(body, separator, ","):
        return body
    for k, (_, line) in enumerate(lines[_SAMPLE:], _SAMPLE):
        if ("." in line or "," in line) and any(_marked([line], separator, m) for m in ".,"):
            return [later for _, later in lines[k : k + _SAMPLE] if not is_comment(later)]
    return body


def _marked(body: list[str], separator: str | None, mark: str) -> list[str]:
    """Return the cells that are numbers with a given decimal mark, from the texts of rows."""
    marked = (line.replace('"', "") for line in body if mark in line)
    cells = (cell.strip() for line in marked for cell in line.split(separator))
    return [c for c in cells if mark in c and is_number(c, comma=mark == ",")]
