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
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from axisid.estimation.logs.text import NoStampsError, is_stamp, stamp_seconds
from axisid.estimation.tables import (
    UNITS_ENTRY,
    Table,
    TableBuilder,
    library,
    one_line,
    refusing,
    split_labels,
)
from axisid.support.errors import DataError, UsageError
from axisid.support.memory import Room

_UNIT_KEYS = (b"unit", b"units", b"Unit")
_BATCH = 65_536  # rows that are unfolded before they are counted


def read_npz(file: Path, content: bytes, room: Room) -> Table:
    """Read a NumPy archive: vectors, columns of matrices (``data.1``), fields of records.

    Units are those of an entry ``axisid.units``, JSON by name, if there is one.

    Raises
    ------
    DataError
        It is damaged, or holds Python objects (which could run code) or no vectors, or it unfolds
        to more than there is room for.
    """
    found = TableBuilder(room=room)
    damaged = DataError(
        f"{file} cannot be read as a NumPy archive (write one with numpy.savez)",
        code="log-file",
    )
    with refusing(damaged), np.load(io.BytesIO(content), allow_pickle=False) as archive:
        units = _units(archive)
        for name, entry in zip(archive.files, archive.zip.infolist(), strict=True):
            room.take(entry.file_size)
            _add_entry(found, name, archive, units)
    return found.table(str(file), advice="save vectors of them with numpy.savez")


def _units(archive: Any) -> Mapping[str, str]:
    """Units by name, where the archive has them as JSON, as those that axisid writes."""
    try:
        told = json.loads(str(archive[UNITS_ENTRY])) if UNITS_ENTRY in archive.files else {}
    except ValueError:
        return {}
    pairs = told.items() if isinstance(told, dict) else ()
    return {name: unit for name, unit in pairs if isinstance(unit, str)}


def _add_entry(found: TableBuilder, name: str, archive: Any, units: Mapping[str, str]) -> None:
    """An array, or the fields of records; objects are left alone, since they could run code."""
    try:
        array = archive[name]
    except ValueError as error:
        if "Object arrays" not in str(error):
            raise
        found.pass_over(name, "Python objects, which could run code")
        return
    if array.dtype.names is None:
        found.add_array(name, array, unit=units.get(name, ""))
    for inner in array.dtype.names or ():
        found.add_array(f"{name}.{inner}", array[inner])


def read_parquet(file: Path, content: bytes, room: Room) -> Table:
    """Read a Parquet file; units come from the metadata of its fields, or from their names.

    Raises
    ------
    DataError
        It is damaged, unfolds to more than there is room for, or pyarrow is not installed.
    """
    arrow, parquet = (library(name, "parquet", file) for name in ("pyarrow", "pyarrow.parquet"))
    batches = []
    damaged = DataError(f"{file} cannot be read as a Parquet file", code="log-file")
    with refusing(damaged), parquet.ParquetFile(io.BytesIO(content)) as opened:
        for batch in opened.iter_batches(batch_size=_BATCH):
            room.take(2 * batch.nbytes)  # its columns are put together anew
            batches.append(batch)
        table = arrow.Table.from_batches(batches, opened.schema_arrow).flatten()
    found = TableBuilder(room=room)
    split = split_labels(table.schema.names)
    for field, values, (name, unit) in zip(table.schema, table.columns, split, strict=True):
        metadata = field.metadata or {}
        own = next(
            (metadata[k].decode(errors="replace") for k in _UNIT_KEYS if k in metadata), unit
        )
        found.add(name, values.to_numpy(), unit=own, label=field.name)
    return found.table(str(file))


def read_frame(frame: object) -> Table:
    """Columns of a mapping of arrays, or of any dataframe that narwhals knows.

    Raises
    ------
    UsageError
        It is neither.
    DataError
        Names occur twice.
    """
    source = f"a {type(frame).__name__}"
    if isinstance(frame, Mapping):
        arrays = [(str(name), _array(str(name), values)) for name, values in frame.items()]
    else:
        arrays = _frame_arrays(frame)
    labels = [label for label, _ in arrays]
    found = TableBuilder()
    for (name, unit), (label, values) in zip(split_labels(labels), arrays, strict=True):
        found.add(name, values, unit=unit, label=label)
    return found.table(source, missing=_index(frame))


def _array(name: str, values: object) -> np.ndarray[Any, Any]:
    if np.ma.is_masked(values):
        raise UsageError(
            f"the column {name!r} is masked; give numbers, with NaN for what lacks.",
            code="log-file",
        )
    try:
        return np.asarray(values)
    except ValueError as error:
        raise UsageError(
            f"the column {name!r} has values of different lengths; give one for each sample.",
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
            f"the log is a {type(frame).__name__}; give a path, a dataframe (pandas, Polars, "
            "PyArrow, ...) or a mapping of column names to arrays.",
            code="log-file",
        ) from error
    except narwhals.exceptions.NarwhalsError as error:
        raise DataError(
            f"the dataframe cannot be read: {one_line(error)}; rename one.",
            code="log-file",
        ) from error


def _index(frame: object) -> str:
    """What is said of the index of a pandas dataframe, which is no column."""
    names = [str(name) for name in getattr(getattr(frame, "index", None), "names", ()) if name]
    if not names:
        return ""
    return f"Its index {', '.join(names)} is no column; give log.reset_index()."


#: Bytes that a byte of JSON takes as Python's objects, in arrays and in records of short numbers.
_UNFOLDED, _UNFOLDED_RECORDS = 12, 28
_ADVICE = "give arrays by name, or a list of records with a name for each number"
_DEEPEST = 8  # names below one another


def read_json(file: Path, content: bytes, room: Room) -> Table:
    """Read a log that is one JSON document.

    Raises
    ------
    DataError
        It is no JSON, holds no columns, or there is no room for it.
    """
    records = content.count(b"{") > 1 + content.count(b"[")
    room.take((_UNFOLDED_RECORDS if records else _UNFOLDED) * len(content))
    found = _decoded(file, content)
    return _table(file, _columns(found), room)


def read_json_lines(file: Path, content: bytes, room: Room) -> Table:
    """Read a log of one JSON record or row in each line.

    Raises
    ------
    DataError
        A line is no JSON: which; or as `read_json`.
    """
    room.take(_UNFOLDED_RECORDS * len(content))
    lines = [(n, line) for n, line in enumerate(content.splitlines(), 1) if line.strip()]
    records = [_decoded(file, line, number) for number, line in lines]
    return _table(file, _columns(records), room)


def _decoded(file: Path, content: bytes, line: int = 0) -> Any:
    """What a text holds; NaN and Infinity are taken, which most writers write."""
    try:
        return json.loads(content.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        where = f", line {line}" if line else ""
        why = str(error) if isinstance(error, json.JSONDecodeError) else "it is no text in UTF-8"
        why = "it is nested too deep" if isinstance(error, RecursionError) else why
        raise DataError(
            f"{file}{where} is no JSON: {why[:1].lower() + why[1:]}. Write it anew, or give the "
            "file the ending of what it is (.jsonl for a record in each line).",
            code="log-file",
        ) from error


def _columns(found: Any) -> dict[str, tuple[Sequence[Any], str]]:
    """Cells and unit by name; empty where there are none."""
    if isinstance(found, Mapping):
        names, lists = found.get("columns"), found.get("data")
        if isinstance(names, list) and isinstance(lists, list):
            return _of_lists([names, *lists])
        return dict(_of_arrays(found))
    if not isinstance(found, list) or not found:
        return {}
    return dict(_of_arrays({"": found})) if _are(Mapping, found) else _of_lists(found)


def _are(kind: type, found: Any) -> bool:
    return isinstance(found, list) and bool(found) and all(isinstance(e, kind) for e in found)


def _of_arrays(found: Mapping[str, Any]) -> Iterable[tuple[str, tuple[Sequence[Any], str]]]:
    """Arrays by name; of records those of their names, where what a record lacks is empty."""
    for name, value in _leaves(found, is_leaf=_is_column):
        if _are(Mapping, value):
            flat = [dict(_leaves(record)) for record in value]
            for own in dict.fromkeys(own for record in flat for own in record):
                yield f"{name}.{own}".lstrip("."), ([record.get(own) for record in flat], "")
        elif isinstance(value, list):
            yield name, (value, "")
        elif isinstance(value, Mapping) and _is_column(value):
            inner = value.get("values", value.get("data"))
            unit = str(value.get("unit") or "") if isinstance(inner, list) else ""
            yield name, (inner if isinstance(inner, list) else [*value.values()], unit)


def _is_column(value: Mapping[str, Any]) -> bool:
    """Whether it is an array with its unit, or cells by their numbers, as pandas writes them."""
    numbered = bool(value) and all(str(place).isdecimal() for place in value)
    return numbered or isinstance(value.get("values", value.get("data")), list)


def _leaves(
    found: Mapping[str, Any],
    above: str = "",
    depth: int = 0,
    is_leaf: Callable[[Mapping[str, Any]], bool] = lambda _: False,
) -> Iterable[tuple[str, Any]]:
    """What lies below names, with a dot between these."""
    for key, value in found.items():
        nested = isinstance(value, Mapping) and depth < _DEEPEST
        if nested and not is_leaf(value):
            yield from _leaves(value, f"{above}{key}.", depth + 1, is_leaf)
        else:
            yield f"{above}{key}", value


def _of_lists(lists: Sequence[Any]) -> dict[str, tuple[Sequence[Any], str]]:
    """Columns of rows of cells, whose first may be their names."""
    first = lists[0] if isinstance(lists[0], list) else []
    named = bool(first) and all(isinstance(c, str) and not is_stamp(c) for c in first)
    names = first if named else [f"#{k}" for k in range(1, len(first) + 1)]
    body = lists[1:] if named else lists
    if not all(isinstance(row, list) and len(row) == len(names) for row in body):
        return {}
    return {name: ([row[k] for row in body], "") for k, name in enumerate(names)}


def _table(file: Path, columns: Mapping[str, tuple[Sequence[Any], str]], room: Room) -> Table:
    found = TableBuilder(room=room)
    for label, (name, written) in zip(columns, split_labels([*columns]), strict=True):
        cells, unit = columns[label]
        stamps = _stamps(cells)
        values, note = (_values(cells), "") if stamps is None else stamps
        found.add(name, values, unit="s" if note else unit or written, label=label)
        found.note(name, f"{name}: {note}" if note else "")
    return found.table(str(file), advice=_ADVICE)


def _values(cells: Sequence[Any]) -> np.ndarray[Any, Any]:
    """Numbers, nan where there is none; else the cells as texts."""
    if all(cell is None or isinstance(cell, (int, float)) for cell in cells):
        try:
            return np.array([math.nan if cell is None else float(cell) for cell in cells])
        except OverflowError:
            pass
    return np.array(["" if cell is None else str(cell) for cell in cells])


def _stamps(cells: Sequence[Any]) -> tuple[np.ndarray[Any, Any], str] | None:
    """Seconds of time stamps and what was assumed; None for what are none."""
    if not all(cell is None or (isinstance(cell, str) and is_stamp(cell)) for cell in cells):
        return None
    texts = [cell or "" for cell in cells]
    try:
        return stamp_seconds(texts) if any(texts) else None
    except NoStampsError:
        return None
