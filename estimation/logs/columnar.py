"""Columns by name: NumPy archives, Parquet files, and the dataframes and arrays of a script."""

import io
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

import numpy as np

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
from axisid.support.files.memory import Room

_UNIT_KEYS = (b"unit", b"units", b"Unit")
_HEADS = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}
_DOUBLE = 8  # bytes
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
        code="damaged-npz",
    )
    with refusing(damaged), np.load(io.BytesIO(content), allow_pickle=False) as archive:
        units = _units(archive)
        for name, entry in zip(archive.files, archive.zip.infolist(), strict=True):
            room.take(entry.file_size)
            with archive.zip.open(entry) as stream:
                room.check(_DOUBLE * _numbers(stream))
            _add_entry(found, name, archive, units)
    return found.table(str(file), advice="save vectors of them with numpy.savez")


def _numbers(stream: IO[bytes]) -> int:
    """How many numbers an array of an archive has, by its head; 0 where that does not tell."""
    try:
        read = _HEADS[np.lib.format.read_magic(stream)]
        shape, _, dtype = read(stream)
    except (KeyError, ValueError, EOFError):
        return 0
    return math.prod(shape) if dtype.kind in "fiub" else 0


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
        found.passed_over[name] = "Python objects, which could run code"
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
    damaged = DataError(f"{file} cannot be read as a Parquet file", code="damaged-parquet")
    with refusing(damaged), parquet.ParquetFile(io.BytesIO(content)) as opened:
        for batch in opened.iter_batches(batch_size=_BATCH):
            room.take(2 * batch.nbytes)  # its columns are put together anew
            batches.append(batch)
        table = arrow.Table.from_batches(batches, opened.schema_arrow).flatten()
    found = TableBuilder(room=room)
    split = split_labels(table.schema.names)
    for field, values, (name, unit) in zip(table.schema, table.columns, split, strict=True):
        metadata = field.metadata or {}
        own = next((metadata[k].decode() for k in _UNIT_KEYS if k in metadata), unit)
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
            code="masked-column",
        )
    try:
        return np.asarray(values)
    except ValueError as error:
        raise UsageError(
            f"the column {name!r} has values of different lengths; give one for each sample.",
            code="ragged-column",
        ) from error


def _frame_arrays(frame: Any) -> list[tuple[str, np.ndarray[Any, Any]]]:
    import narwhals

    try:
        table = narwhals.from_native(frame, eager_only=True)
        return [(_flat(series.name), series.to_numpy()) for series in table.iter_columns()]
    except TypeError as error:
        raise UsageError(
            f"the log is a {type(frame).__name__}; give a path, a dataframe (pandas, Polars, "
            "PyArrow, ...) or a mapping of column names to arrays.",
            code="log-type",
        ) from error
    except narwhals.exceptions.NarwhalsError as error:
        raise DataError(
            f"the dataframe cannot be read: {one_line(error)}; rename one.",
            code="damaged-dataframe",
        ) from error


def _flat(name: object) -> str:
    """The levels of a name in one."""
    return ".".join(str(level) for level in name) if isinstance(name, tuple) else str(name)


def _index(frame: object) -> str:
    """What is said of the index of a pandas dataframe, which is no column."""
    names = [str(name) for name in getattr(getattr(frame, "index", None), "names", ()) if name]
    if not names:
        return ""
    return f"Its index {', '.join(names)} is no column; give log.reset_index()."
