"""Reading of logs in JSON: one document, or a record in each line.

A document has arrays by name, a list of records, or rows of cells. A record has one sample, its
values by name::

    {"time": [0, 1], "position": [2, 3]}            arrays by name, also below other names
    {"position": {"unit": "mm", "values": [2, 3]}}  the same with a unit
    [{"time": 0, "position": 2}, ...]               records, also below other names
    {"columns": ["time", "position"], "data": [[0, 2], ...]}
    [["time", "position"], [0, 2], ...]             rows, with their names first or without
"""

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from axisid.estimation.logs.text import TimeStampError, is_stamp, stamp_seconds
from axisid.estimation.raw_tables import Table, TableBuilder, split_labels
from axisid.support.errors import AxisidError, DataError
from axisid.support.memory import Room

from .column_checks import MIXED_TRUTHS, has_mixed_truths, once

#: Cells and unit of a column.
_Cells = tuple[Sequence[Any], str]

#: Bytes of Python's objects per byte of JSON, in arrays and in records of short numbers.
_UNFOLDED, _UNFOLDED_RECORDS = 12, 28
_DEEPEST = 8  # largest number of nested names


def read_json(file: Path, content: bytes, room: Room, *, lines: bool = False) -> Table:
    """Return the table of a log in JSON: one document, or one record or row in each line.

    Parameters
    ----------
    file : Path
        Path of the file, for messages.
    content : bytes
        Content of the file.
    room : Room
        Available memory.
    lines : bool
        True if each line is a record or a row.

    Raises
    ------
    DataError
        The content, or a line, is not JSON; it has no columns; or it needs more memory than is
        available.
    """
    records = lines or content.count(b"{") > 1 + content.count(b"[")
    room.take((_UNFOLDED_RECORDS if records else _UNFOLDED) * len(content))
    rows = enumerate(content.splitlines() if lines else (), 1)
    document = [_decoded(file, line, n) for n, line in rows if line.strip()]
    columns = once(_columns(document if lines else _decoded(file, content)))
    builder = TableBuilder(room=room)
    for label, (name, written) in zip(columns, split_labels([*columns]), strict=True):
        cells, unit = columns[label]
        if has_mixed_truths(cells):
            builder.pass_over(label, MIXED_TRUTHS)
            continue
        values, note = _values(cells)
        unit, note = ("s", f"{name}: {note}") if note else (unit or written, "")
        builder.add(name, values, unit=unit, label=label, note=note)
    return builder.table(
        str(file), advice="give arrays by name, or a list of records with a name for each number"
    )


def _decoded(file: Path, content: bytes, line: int = 0) -> Any:
    """Return the objects of a JSON text; NaN and Infinity are allowed, as in many programs.

    `line` is the number of the line in the file, for messages; 0 for a whole document.
    """
    try:
        return json.loads(content.decode("utf-8-sig"), object_pairs_hook=once)
    except AxisidError:
        raise
    except (ValueError, RecursionError) as error:
        why = str(error)
        if isinstance(error, UnicodeDecodeError):
            why = "the text is not UTF-8"
        if isinstance(error, RecursionError):
            why = "the document is nested too deeply"
        where = f", line {line}" if line else ""
        raise DataError(
            f"{file}{where} is not JSON: {why[:1].lower() + why[1:]}. Write the file again, or "
            "give it the ending of its format (.jsonl for a record in each line).",
            code="log-file",
        ) from error


def _columns(document: Any, name: str = "") -> Iterable[tuple[str, _Cells]]:
    """Yield name, cells and unit of each column of a document, with a dot between nested names.

    `name` is the name of the part of the document, from the names above it; empty for the whole
    document.
    """
    if (
        isinstance(document, list)
        and document
        and all(isinstance(each, Mapping) for each in document)
    ):
        records = [once(_leaves(record)) for record in document]
        for field in dict.fromkeys(field for record in records for field in record):
            yield f"{name}.{field}".lstrip("."), ([record.get(field) for record in records], "")
    elif isinstance(document, list) and name:
        yield name, (document, "")
    elif isinstance(document, list) and document and isinstance(document[0], list):
        yield from _of_lists(document)
    elif isinstance(document, Mapping) and name.count(".") < _DEEPEST:
        names, cells = document.get("columns"), document.get("values", document.get("data"))
        if isinstance(names, list) and isinstance(cells, list):
            yield from _of_lists([names, *cells])
        elif name and isinstance(cells, list):  # an array with its unit
            yield name, (cells, str(document.get("unit") or ""))
        elif (
            name and document and all(str(place).isdecimal() for place in document)
        ):  # a column with its row numbers, as pandas writes it
            yield name, ([*document.values()], "")
        else:
            for key, value in document.items():
                yield from _columns(value, f"{name}.{key}".lstrip("."))


def _leaves(record: Mapping[str, Any], above: str = "") -> Iterable[tuple[str, Any]]:
    """Yield name and value of each number of a record, with a dot between nested names.

    `above` are the names above the record, each with a dot after it.
    """
    for key, value in record.items():
        if isinstance(value, Mapping) and above.count(".") < _DEEPEST:
            yield from _leaves(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", value


def _of_lists(lists: Sequence[Any]) -> Iterable[tuple[str, _Cells]]:
    """Yield the columns of rows of cells; the first row may contain their names.

    Nothing is yielded if the rows have different lengths.
    """
    first = lists[0]
    named = bool(first) and all(isinstance(c, str) and not is_stamp(c) for c in first)
    names = first if named else [f"#{k}" for k in range(1, len(first) + 1)]
    body = lists[1:] if named else lists
    if all(isinstance(row, list) and len(row) == len(names) for row in body):
        yield from ((name, ([row[k] for row in body], "")) for k, name in enumerate(names))


def _values(cells: Sequence[Any]) -> tuple[np.ndarray[Any, Any], str]:
    """Return the cells of a column as an array, (N,), and a note.

    Numbers have NaN for empty cells. Time stamps become seconds from the first time stamp, which
    the note reports; otherwise the note is empty. Other cells become texts.
    """
    if all(cell is None or isinstance(cell, (int, float)) for cell in cells):
        with suppress(OverflowError):
            return np.array([math.nan if cell is None else float(cell) for cell in cells]), ""
    elif any(cells) and all(cell is None or isinstance(cell, str) for cell in cells):
        with suppress(TimeStampError):
            return stamp_seconds([cell or "" for cell in cells])
    return np.array(["" if cell is None else str(cell) for cell in cells]), ""
