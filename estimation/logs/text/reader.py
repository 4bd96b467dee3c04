"""Reading of delimited text, whose dialect is found by `dialect`.

Lines at the end may not be rows: a line that was truncated when the logger stopped, or a footer.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from axisid.estimation.raw_tables import RawColumn, Repair, Samples, Table
from axisid.support.arrays import Array
from axisid.support.errors import DataError

from .dialect import Dialect, Line, is_comment, is_number, sniff, split_cells
from .time_stamps import TimeStampError, is_stamp, stamp_seconds
from .twincat import is_twincat, read_twincat

#: Instruction to leave out incomplete lines at the end, a sentence.
_DROP_TAIL = 'To leave out lines at the end of the log, set tail = "drop" in run.toml.'
_NEIGHBOURS = 20  # number of lines above the last with which its last number is compared

_LABVIEW_END = "***End_of_Header***"
_SEPARATOR = "Separator"  # label in the header of a LabVIEW file, followed by the separator


def read_text(source: str, content: bytes, *, drop_tail: bool = False, endings: str = "") -> Table:
    """Return the table of a text: delimited text, or an export of TwinCAT Scope or LabVIEW.

    Parameters
    ----------
    source : str
        File name, for messages.
    content : bytes
    drop_tail : bool
        True if incomplete lines at the end may be left out. A truncated last number is always left
        out.
    endings : str
        Endings of the formats that are not text, for messages.

    Raises
    ------
    DataError
        The file is not text, or has no table.
    """
    # Filled lines with their numbers; exports of TwinCAT and LabVIEW have headers of their own.
    text, encoding = _decoded(source, content, endings)
    lines = [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip()]
    notes = (f"encoding {encoding}",) if encoding != "utf-8-sig" else ()
    if is_twincat(lines):
        table = read_twincat(source, lines)
        return replace(table, notes=(*table.notes, *notes))
    if lines and lines[0][1].startswith("LabVIEW Measurement"):
        lines, more = _plain_lines(source, lines)
        notes = (*more, *notes)
    # Rows, without a truncated last line, and without other incomplete lines if this is allowed.
    dialect = sniff(source, lines)
    body = [line for line in lines[dialect.first :] if not is_comment(line[1])]
    whole = len(body) - (not text.endswith(("\n", "\r")) and is_cut(body, dialect))
    if drop_tail:
        whole = complete_lines(body[:whole], dialect)
    tail = body[whole:]
    return Table(
        source=source,
        columns=text_columns(source, body[:whole], dialect),
        notes=dialect.notes + notes,
        repairs=(left_out(tail),) if drop_tail or tail else (),
    )


def _decoded(source: str, content: bytes, endings: str) -> tuple[str, str]:
    """Return the text of a file, and its assumed encoding.

    The encoding is UTF-8, with or without a byte order mark; UTF-16 by its mark or by its zero
    bytes; otherwise Windows-1252. `endings` are those of formats that are not text, for messages.

    Raises
    ------
    DataError
        The file has none of these encodings, or has zero bytes and is not UTF-16.
    """
    even, odd = content[:2000:2].count(0), content[1:2000:2].count(0)
    encodings = ["utf-8-sig", "cp1252"]  # the byte order mark is not part of the text
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        encodings = ["utf-16"]
    elif max(even, odd) > 0.3 * len(content[:2000]) / 2:  # zeros of every second byte
        encodings = ["utf-16-le" if odd > even else "utf-16-be"]
    for encoding in encodings:
        with suppress(UnicodeDecodeError):
            text = content.decode(encoding)
            if "\0" not in text:
                return text, encoding
    raise DataError(
        f"{source} is not text in UTF-8, UTF-16 or Windows-1252. Save it as CSV in UTF-8, or give "
        f"the file the ending of its format ({endings}).",
        code="no-text",
    )


def text_columns(source: str, lines: list[Line], dialect: Dialect) -> dict[str, RawColumn]:
    """Return the columns of lines of text by name.

    An empty cell is NaN. Time stamps become seconds from the first time stamp. Any other column
    with text gets an error, which names its first cell with text and is raised when the column is
    used.

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
        The number of cells of a row is not the number of columns of the header.
    """
    # Parse the columns whose first cell is a number; if that fails, all cells are split below.
    first = dialect.cells(lines[0][1])
    text = {k for k, c in enumerate(first) if c and not is_number(c, comma=dialect.comma)}
    numeric = [k for k in range(len(dialect.names)) if first and k not in text]
    values = _parse([line for _, line in lines], dialect, numeric)
    rows = [dialect.cells(line) for _, line in lines] if values is None else []
    for (number, _), cells in zip(lines, rows, strict=False):
        if len(cells) != len(dialect.names):
            raise DataError(
                f"{source}, line {number}: the line has {len(cells)} cells, but the header names "
                f"{len(dialect.names)} columns ({', '.join(dialect.names)}). Remove or correct the "
                f"line. {_DROP_TAIL}",
                code="log-text",
            )
    columns = {}
    for k, name in enumerate(dialect.names):
        if values is not None and k in numeric:
            column = RawColumn(samples=Samples(values=values[:, numeric.index(k)]))
        else:
            split = (line.split(dialect.separator, k + 1)[k].strip() for _, line in lines)
            cells = [row[k] for row in rows] or [*split]
            column = _column_of_cells(source, lines, dialect, k, cells)
        columns[name or f"#{k + 1}"] = replace(
            column, unit=column.unit or dialect.units[k], label=dialect.labels[k]
        )
    return columns


def _parse(lines: list[str], dialect: Dialect, numeric: list[int]) -> Array | None:
    """Return some columns of rows as numbers, (n, c); None if NumPy's parser cannot parse them.

    `lines` are the texts of the rows, `numeric` the indices of the columns.
    """
    delimiter, width = dialect.separator, len(dialect.names)
    separators = lines[0].count(delimiter) if delimiter else width - 1
    # Columns must be selected if some are text, or if rows end with a separator. The parser ignores
    # the cells of other columns, so the number of cells of each row is checked here.
    is_selection = len(numeric) < width or separators == width
    if is_selection and (
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
            usecols=numeric if is_selection else None,
        )
    except ValueError:
        return None
    return values if values.shape[1] == len(numeric) else None


def _column_of_cells(
    source: str, lines: list[Line], dialect: Dialect, k: int, cells: list[str]
) -> RawColumn:
    """Return the column with index k from its cells: numbers, time stamps, or an error.

    The error is that of a column with text, which is raised when the column is used.
    """
    # The first cell that is not a number.
    comma, why = dialect.comma, ""
    row = next((i for i, c in enumerate(cells) if c and not is_number(c, comma=comma)), None)
    if row is None:
        plain = (cell.replace(",", ".") if comma else cell for cell in cells)
        return RawColumn(samples=Samples(values=np.array([float(cell or "nan") for cell in plain])))
    if is_stamp(cells[row]):
        try:
            seconds, note = stamp_seconds(cells)
            return RawColumn(
                samples=Samples(values=seconds), unit="s", note=f"{dialect.names[k]}: {note}"
            )
        except TimeStampError as error:
            row, why = error.row or row, error.why
    reason = (
        f"is not a number (decimal {'comma' if comma else 'point'}) or a time stamp such as "
        "2026-02-01 12:00:00.250, 1.2.2026 12:00:00 or 12:00:00.250. Correct the cell, remove "
        f"the line, or choose another column. {_DROP_TAIL}"
    )
    if why:
        reason = (
            f"is not a readable time stamp: {why}. Export the log with time stamps such as "
            "2026-02-01 12:00:00.250."
        )
    where = f"{source}, line {lines[row][0]}: {cells[row]!r} in column {dialect.names[k]!r}"
    return RawColumn(samples=DataError(f"{where} {reason}", code="log-text"))


def _plain_lines(source: str, lines: Sequence[Line]) -> tuple[list[Line], tuple[str, ...]]:
    """Return the lines of the table in a LabVIEW measurement file, and notes on assumptions.

    The lines are a header with names and units, and the rows, without the headers of the file.

    Raises
    ------
    DataError
        The headers of the file have no end, or no names of columns follow.
    """
    # The table is below the last line that ends a header.
    ends = [k for k, (_, line) in enumerate(lines[:200]) if line.startswith(_LABVIEW_END)]
    if not ends or ends[-1] + 1 >= len(lines):
        raise DataError(
            f"{source}: the LabVIEW measurement file has no samples below its headers, which end "
            f"with {_LABVIEW_END}. Export the log again.",
            code="log-text",
        )
    # Separator and units are in the header.
    head = [line for _, line in lines[: ends[-1]]]
    separators = (line[len(_SEPARATOR) :][:1] for line in head if line.startswith(_SEPARATOR))
    separator = next(separators, "\t")
    number, line = lines[ends[-1] + 1]
    names = split_cells(line.rstrip(separator), separator)
    labels = next((split_cells(x, separator) for x in head if x.startswith("Y_Unit_Label")), [])
    units = ["", *labels[1:], *[""] * len(names)]
    body = lines[ends[-1] + 2 :]
    if names[-1] == "Comment":
        names = names[:-1]
        body = [(k, separator.join(row.split(separator)[: len(names)])) for k, row in body]
    heads = [f"{n} [{u}]" if u else n for n, u in zip(names, units, strict=False)]
    return [(number, separator.join(heads)), *body], (
        "LabVIEW measurement file, whose headers and comments are ignored",
    )


def complete_lines(lines: list[Line], dialect: Dialect) -> int:
    """Return the number of lines without incomplete ones at the end.

    A complete row has the same kinds of cells as the first row, and no empty cell that the row
    above it does not have. All lines are returned if more than fifty at the end are incomplete.
    """
    kinds = [_kind(cell, dialect) for cell in dialect.cells(lines[0][1])]
    # More than fifty lines of another kind are another table.
    rows = [dialect.cells(line) for _, line in lines[-51:]]
    for k in range(len(rows) - 1, 0, -1):
        same_width = any(rows[k]) and len(rows[k]) == len(kinds)
        if same_width and all(
            kind in ("text", _kind(cell, dialect)) if cell else not neighbour
            for cell, neighbour, kind in zip(rows[k], rows[k - 1], kinds, strict=False)
        ):
            return len(lines) - len(rows) + k + 1
    return len(lines)


def is_cut(lines: list[Line], dialect: Dialect) -> bool:
    """Return True if the last line, which has no line end, is probably truncated.

    Its last number is then shorter than the last numbers of the 20 lines above it. False if there
    are fewer lines, or if the line has a wrong number of cells.
    """
    rows = [dialect.cells(line) for _, line in lines[-_NEIGHBOURS - 1 :]]
    if len(rows) <= _NEIGHBOURS or any(len(row) != len(dialect.names) for row in rows):
        return False
    *above, last = (len(row[-1].lstrip("+-")) for row in rows)
    return 0 < last < min(above)


def left_out(lines: list[Line]) -> Repair:
    """Return the repair that reports the lines at the end that are left out, which may be none."""
    if not lines:
        return Repair(kind="tail", count=0, text="no incomplete lines at the end")
    number, line = lines[0]
    what, are = ("line", "is") if len(lines) == 1 else ("lines", "are")
    excerpt = f"{line.strip()[:40]}..." if len(line.strip()) > 40 else line.strip()
    return Repair(
        kind="tail",
        count=len(lines),
        text=f"{len(lines)} incomplete {what} at the end {are} left out, from line {number}: "
        f"{excerpt!r}",
    )


def _kind(cell: str, dialect: Dialect) -> str:
    """Return the kind of a cell: ``number``, ``stamp`` or ``text``."""
    is_text = "stamp" if is_stamp(cell) else "text"
    return "number" if is_number(cell, comma=dialect.comma) else is_text
