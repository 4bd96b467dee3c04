"""Columns by name: NumPy archives, Parquet, JSON, and the dataframes and arrays of a script.

JSON may be arrays by name, a list of records, rows of cells, or one record in a line::

    {"time": [0, 1], "position": [2, 3]}            arrays by name, also below other names
    {"position": {"unit": "mm", "values": [2, 3]}}  the same with a unit
    [{"time": 0, "position": 2}, ...]               records, also below other names
    {"columns": ["time", "position"], "data": [[0, 2], ...]}
    [["time", "position"], [0, 2], ...]             rows, with their names first or without
"""

import io
import json
import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import msgspec
import numpy as np

from axisid.estimation.logs.text import TimeStampError, is_stamp, stamp_seconds
from axisid.estimation.raw_tables import UNITS_ENTRY, Table, TableBuilder, split_labels, twice
from axisid.support.errors import AxisidError, DataError, UsageError
from axisid.support.libraries import library, one_line, refusing
from axisid.support.memory import Room
from axisid.support.settings import setting

#: Cells and unit of a column.
_Cells = tuple[Sequence[Any], str]


def read_npz(file: Path, content: bytes, room: Room) -> Table:
    """Read a NumPy archive: vectors, columns of matrices (``data.1``), fields of records.

    Units are those of an entry ``axisid.units``, JSON by name, if there is one.

    Raises
    ------
    DataError
        It is damaged, or holds Python objects (which could run code) or no vectors, its units
        cannot be read, or it unfolds to more than there is room for.
    """
    builder = TableBuilder(room=room)
    with (
        refusing(f"{file} cannot be read as a NumPy archive (write one with numpy.savez)"),
        ZipFile(io.BytesIO(content)) as packed,
        np.load(io.BytesIO(content), allow_pickle=False) as archive,
    ):
        with refusing(
            f"the entry {UNITS_ENTRY!r} of {file} is not a JSON object of units by name. Write it "
            'as {"position": "mm"}, or omit it and give the units with '
            f"{setting('columns', {'ROLE': 'NAME:UNIT'})}"
        ):
            written = archive[UNITS_ENTRY] if UNITS_ENTRY in archive.files else "{}"
            units = msgspec.convert(
                json.loads(str(written), object_pairs_hook=_once), type=dict[str, str]
            )
        for name, entry in zip(archive.files, packed.infolist(), strict=True):
            room.take(entry.file_size)
            _add_entry(builder, name, archive, units)
    return builder.table(str(file), advice="save vectors of them with numpy.savez")


def _add_entry(builder: TableBuilder, name: str, archive: Any, units: Mapping[str, str]) -> None:
    """An array, or the fields of records; objects are left alone, since they could run code."""
    try:
        array = archive[name]
    except ValueError as error:
        if "Object arrays" not in str(error):
            raise
        builder.pass_over(name, "Python objects, which could execute code")
        return
    if array.dtype.names is None:
        builder.add_array(name, array, unit=units.get(name, ""))
    for inner in array.dtype.names or ():
        builder.add_array(f"{name}.{inner}", array[inner])


def read_parquet(file: Path, content: bytes, room: Room) -> Table:
    """Read a Parquet file; units come from the metadata of its fields, or from their names.

    Raises
    ------
    DataError
        It is damaged, unfolds to more than there is room for, or pyarrow is not installed.
    """
    arrow, parquet = (library(name, "parquet", file) for name in ("pyarrow", "pyarrow.parquet"))
    batches = []
    with (
        refusing(f"{file} cannot be read as a Parquet file (write it anew)"),
        parquet.ParquetFile(io.BytesIO(content)) as opened,
    ):
        for batch in opened.iter_batches():
            room.take(2 * batch.nbytes)  # its columns are put together anew
            batches.append(batch)
        table = arrow.Table.from_batches(batches, opened.schema_arrow).flatten()
    builder = TableBuilder(room=room)
    split = split_labels(table.schema.names)
    for field, values, (name, unit) in zip(table.schema, table.columns, split, strict=True):
        metadata = {**(field.metadata or {})}
        unit_text = (
            metadata.get(b"unit")
            or metadata.get(b"units")
            or metadata.get(b"Unit")
            or unit.encode()
        )
        builder.add(
            name, values.to_numpy(), unit=unit_text.decode(errors="replace"), label=field.name
        )
    return builder.table(str(file))


#: Bytes that a byte of JSON takes as Python's objects, in arrays and in records of short numbers.
_UNFOLDED, _UNFOLDED_RECORDS = 12, 28
_DEEPEST = 8  # names below one another


def read_json(file: Path, content: bytes, room: Room, *, lines: bool = False) -> Table:
    """Read a log that is one JSON document, or has one record or row of it in each line.

    Raises
    ------
    DataError
        It is no JSON, or a line is none: which; it holds no columns, or there is no room for it.
    """
    records = lines or content.count(b"{") > 1 + content.count(b"[")
    room.take((_UNFOLDED_RECORDS if records else _UNFOLDED) * len(content))
    rows = enumerate(content.splitlines() if lines else (), 1)
    document = [_decoded(file, line, n) for n, line in rows if line.strip()]
    columns = _once(_columns(document if lines else _decoded(file, content)))
    builder = TableBuilder(room=room)
    for label, (name, written) in zip(columns, split_labels([*columns]), strict=True):
        cells, unit = columns[label]
        if has_mixed_truths(cells):
            builder.pass_over(label, _MIXED)
            continue
        values, note = _values(cells)
        unit, note = ("s", f"{name}: {note}") if note else (unit or written, "")
        builder.add(name, values, unit=unit, label=label, note=note)
    return builder.table(
        str(file), advice="give arrays by name, or a list of records with a name for each number"
    )


def _decoded(file: Path, content: bytes, line: int = 0) -> Any:
    """What a text holds; NaN and Infinity are taken, which most writers write."""
    try:
        return json.loads(content.decode("utf-8-sig"), object_pairs_hook=_once)
    except AxisidError:
        raise
    except (ValueError, RecursionError) as error:
        why = "it is not text in UTF-8" if isinstance(error, UnicodeDecodeError) else str(error)
        why = "it is nested too deeply" if isinstance(error, RecursionError) else why
        where = f", line {line}" if line else ""
        raise DataError(
            f"{file}{where} is not JSON: {why[:1].lower() + why[1:]}. Write the file again, or "
            "give it the ending of its format (.jsonl for a record in each line).",
            code="log-file",
        ) from error


def _once(pairs: Iterable[tuple[str, Any]]) -> dict[str, Any]:
    """Values by name.

    Raises
    ------
    DataError
        A name occurs twice.
    """
    listed = [*pairs]
    found = dict(listed)
    if len(found) < len(listed):
        counts = Counter(name for name, _ in listed)
        raise twice(next(name for name, count in counts.items() if count > 1))
    return found


def _columns(document: Any, name: str = "") -> Iterable[tuple[str, _Cells]]:
    """Columns by name of what JSON holds, with a dot between names below one another."""
    if (
        isinstance(document, list)
        and document
        and all(isinstance(each, Mapping) for each in document)
    ):
        records = [_once(_leaves(record)) for record in document]
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
        ):  # as pandas writes them
            yield name, ([*document.values()], "")
        else:
            for key, value in document.items():
                yield from _columns(value, f"{name}.{key}".lstrip("."))


def _leaves(record: Mapping[str, Any], above: str = "") -> Iterable[tuple[str, Any]]:
    """What lies below the names of a record, with a dot between these."""
    for key, value in record.items():
        if isinstance(value, Mapping) and above.count(".") < _DEEPEST:
            yield from _leaves(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", value


def _of_lists(lists: Sequence[Any]) -> Iterable[tuple[str, _Cells]]:
    """Columns of rows of cells, whose first may be their names."""
    first = lists[0]
    named = bool(first) and all(isinstance(c, str) and not is_stamp(c) for c in first)
    names = first if named else [f"#{k}" for k in range(1, len(first) + 1)]
    body = lists[1:] if named else lists
    if all(isinstance(row, list) and len(row) == len(names) for row in body):
        yield from ((name, ([row[k] for row in body], "")) for k, name in enumerate(names))


def _values(cells: Sequence[Any]) -> tuple[np.ndarray[Any, Any], str]:
    """Numbers, nan where there is none, or seconds of time stamps with what was assumed of them.

    Else the cells as texts.
    """
    if all(cell is None or isinstance(cell, (int, float)) for cell in cells):
        with suppress(OverflowError):
            return np.array([math.nan if cell is None else float(cell) for cell in cells]), ""
    elif any(cells) and all(cell is None or isinstance(cell, str) for cell in cells):
        with suppress(TimeStampError):
            return stamp_seconds([cell or "" for cell in cells])
    return np.array(["" if cell is None else str(cell) for cell in cells]), ""


_MIXED = "true or false among numbers"


def has_mixed_truths(cells: Sequence[Any]) -> bool:
    """Return whether true or false stands among numbers."""
    there = [cell for cell in cells if cell is not None]
    truths = sum(isinstance(cell, (bool, np.bool_)) for cell in there)
    return 0 < truths < len(there)


def read_frame(frame: object) -> Table:
    """Columns of a mapping of arrays, or of any dataframe that narwhals knows.

    Raises
    ------
    UsageError
        It is neither.
    DataError
        Names occur twice.
    """
    if isinstance(frame, Mapping):
        arrays = [(str(name), _array(str(name), values)) for name, values in frame.items()]
    else:
        arrays = _frame_arrays(frame)
    builder = TableBuilder()
    split = split_labels([label for label, _ in arrays])
    for (name, unit), (label, values) in zip(split, arrays, strict=True):
        if values.dtype == object and has_mixed_truths(values.tolist()):
            builder.pass_over(label, _MIXED)
        else:
            builder.add(name, values, unit=unit, label=label)
    index = [str(name) for name in getattr(getattr(frame, "index", None), "names", ()) if name]
    return builder.table(
        f"a {type(frame).__name__}",
        missing=f"Its index {', '.join(index)} is not a column. Give log.reset_index()."
        if index
        else "",
    )


def _array(name: str, values: object) -> np.ndarray[Any, Any]:
    if np.ma.is_masked(values):
        raise UsageError(
            f"the column {name!r} is masked. Give numbers, with NaN for missing values.",
            code="log-file",
        )
    try:
        if isinstance(values, (list, tuple)) and has_mixed_truths(values):
            return np.array(values, dtype=object)
        return np.asarray(values)
    except ValueError as error:
        raise UsageError(
            f"the column {name!r} has values of different lengths. Give one number per sample.",
            code="log-file",
        ) from error


def _frame_arrays(frame: Any) -> list[tuple[str, np.ndarray[Any, Any]]]:
    import narwhals

    try:
        table = narwhals.from_native(frame, eager_only=True)
        return [
            (".".join(map(str, s.name)) if isinstance(s.name, tuple) else str(s.name), s.to_numpy())
            for s in table.iter_columns()
        ]
    except TypeError as error:
        raise UsageError(
            f"the log is a {type(frame).__name__}. Give a path, a dataframe (pandas, Polars, "
            "PyArrow, ...) or a mapping of column names to arrays.",
            code="log-file",
        ) from error
    except narwhals.exceptions.NarwhalsError as error:
        raise DataError(
            f"the dataframe cannot be read: {one_line(error)}. Rename one of the columns.",
            code="log-file",
        ) from error
