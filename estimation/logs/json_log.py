"""Logs in JSON: arrays by name, a list of records, rows of cells, or one record in a line.

::

    {"time": [0, 1], "position": [2, 3]}            arrays by name, also below other names
    {"position": {"unit": "mm", "values": [2, 3]}}  the same with a unit
    [{"time": 0, "position": 2}, ...]               records, also below other names
    {"columns": ["time", "position"], "data": [[0, 2], ...]}
    [["time", "position"], [0, 2], ...]             rows, with their names first or without
"""

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from axisid.estimation.logs.text import NoStampsError, is_stamp, stamp_seconds
from axisid.estimation.tables import Table, TableBuilder, split_labels
from axisid.support.errors import DataError
from axisid.support.files.memory import Room

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
            code="no-json",
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
    if all(isinstance(each, Mapping) for each in found):
        return _of_records(found)
    if all(isinstance(each, list) for each in found):
        return _of_lists(found)
    return {}


def _of_arrays(
    found: Mapping[str, Any], above: str = "", depth: int = 0
) -> Iterable[tuple[str, tuple[Sequence[Any], str]]]:
    """Arrays by name; those below other names have both, with a dot between."""
    for key, value in found.items():
        name = f"{above}{key}"
        if isinstance(value, list) and value and all(isinstance(e, Mapping) for e in value):
            yield from ((f"{name}.{own}", cells) for own, cells in _of_records(value).items())
        elif isinstance(value, list):
            yield name, (value, "")
        elif isinstance(value, Mapping) and depth < _DEEPEST:
            inner = value.get("values", value.get("data"))
            if isinstance(inner, list):
                yield name, (inner, str(value.get("unit") or ""))
            elif value and all(str(place).isdecimal() for place in value):  # as pandas writes it
                yield name, ([*value.values()], "")
            else:
                yield from _of_arrays(value, f"{name}.", depth + 1)


def _of_records(records: Sequence[Mapping[str, Any]]) -> dict[str, tuple[Sequence[Any], str]]:
    """Columns of records; what a record lacks is an empty cell."""
    flat = [_flat(record) for record in records]
    names = dict.fromkeys(name for record in flat for name in record)
    return {name: ([record.get(name) for record in flat], "") for name in names}


def _flat(record: Mapping[str, Any], above: str = "", depth: int = 0) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in record.items():
        if isinstance(value, Mapping) and depth < _DEEPEST:
            found |= _flat(value, f"{above}{key}.", depth + 1)
        else:
            found[f"{above}{key}"] = value
    return found


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
