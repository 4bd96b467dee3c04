"""Columns by name: NumPy archives, Parquet files, and the dataframes and arrays of a script."""

import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from axisid.modeling import AxisidError, UsageError

from .column_units import split_labels
from .errors import DataError
from .table import Column, Table, at_hand, library, told, unlike, vector_columns

_UNIT_KEYS = (b"unit", b"units", b"Unit")


def read_npz(file: Path, content: bytes) -> Table:
    """Read a NumPy archive: vectors, columns of matrices (``data.1``), fields of records.

    Raises
    ------
    DataError
        It is damaged, or holds Python objects (which could run code) or no vectors.
    """
    columns: dict[str, Column] = {}
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as archive:
            for name in archive.files:
                columns |= _array_columns(name, archive[name])
    except Exception as error:
        # Damaged archives raise zip, zlib, struct and value errors alike.
        raise DataError(f"{file} cannot be read as a NumPy archive: {told(error)}.") from error
    if not columns:
        raise DataError(f"{file} holds no numeric vectors; save them with numpy.savez.")
    return Table(source=str(file), columns=columns)


def _array_columns(name: str, array: np.ndarray[Any, Any]) -> dict[str, Column]:
    if array.dtype.names is None:
        return vector_columns(name, array)
    found: dict[str, Column] = {}
    for inner in array.dtype.names:
        found |= vector_columns(f"{name}.{inner}", array[inner])
    return found


def read_parquet(file: Path, content: bytes) -> Table:
    """Read a Parquet file; units come from the metadata of its fields, or from their names.

    Raises
    ------
    DataError
        It is damaged, or pyarrow is not installed.
    """
    parquet = library("pyarrow.parquet", "parquet", file)
    try:
        table = parquet.read_table(io.BytesIO(content)).flatten()
    except Exception as error:
        raise DataError(f"{file} cannot be read as a Parquet file: {told(error)}.") from error
    columns, notes = arrow_columns(table)
    unlike([field.name for field in table.schema], str(file))
    return Table(source=str(file), columns=columns, notes=notes)


def parquet_blocks(file: Path, rows: int) -> Iterator[Table]:
    """The table of a Parquet file, so many rows at a time.

    Raises
    ------
    DataError
        It is damaged, or pyarrow is not installed.
    """
    arrow, parquet = (
        library("pyarrow", "parquet", file),
        library("pyarrow.parquet", "parquet", file),
    )
    origins: dict[str, Any] = {}
    try:
        with parquet.ParquetFile(file) as content:
            for batch in content.iter_batches(batch_size=rows):
                table = arrow.Table.from_batches([batch]).flatten()
                columns, notes = arrow_columns(table, origins)
                yield Table(source=str(file), columns=columns, notes=notes)
    except (OSError, ValueError, arrow.ArrowException) as error:
        if isinstance(error, AxisidError):
            raise
        raise DataError(f"{file} cannot be read as a Parquet file: {told(error)}.") from error


def arrow_columns(
    table: Any, origins: dict[str, Any] | None = None
) -> tuple[dict[str, Column], tuple[str, ...]]:
    """Numeric columns of an Arrow table, times in s, and what was assumed of them.

    `origins` remembers the first time stamps from one block to the next.
    """
    origins = {} if origins is None else origins
    columns: dict[str, Column] = {}
    notes: list[str] = []
    split = split_labels(table.schema.names)
    for field, (name, written) in zip(table.schema, split, strict=True):
        values = table.column(field.name).to_numpy()
        metadata = field.metadata or {}
        unit = next((metadata[k].decode() for k in _UNIT_KEYS if k in metadata), written)
        columns |= _column(name, field.name, values, unit, notes, origins)
    return columns, tuple(notes)


def _column(
    name: str,
    label: str,
    values: np.ndarray[Any, Any],
    unit: str,
    notes: list[str],
    origins: dict[str, Any],
) -> dict[str, Column]:
    """A column of numbers, or of time stamps and durations, counted in s from the first stamp."""
    if values.dtype.kind == "M":
        notes.append(f"{name}: time stamps counted from the first")
        values = values - origins.setdefault(name, values[:1])
    if values.dtype.kind == "m":
        seconds = values / np.timedelta64(1, "s")
        return {name: at_hand(seconds.astype(np.float64), unit="s", label=label)}
    if values.dtype.kind not in "fiub" or values.ndim != 1:
        return {}
    return {name: at_hand(values.astype(np.float64), unit=unit, label=label)}


def read_frame(frame: object) -> Table:
    """Columns of a mapping of arrays, or of any dataframe that narwhals knows.

    Raises
    ------
    UsageError
        It is neither.
    DataError
        The library narwhals is not installed.
    """
    notes: list[str] = []
    columns: dict[str, Column] = {}
    if isinstance(frame, Mapping):
        arrays = {str(name): _array(str(name), values) for name, values in frame.items()}
    else:
        arrays = _frame_arrays(frame)
    for (label, values), (name, unit) in zip(arrays.items(), split_labels([*arrays]), strict=True):
        columns |= _column(name, label, values, unit, notes, {})
    return Table(source=f"a {type(frame).__name__}", columns=columns, notes=tuple(notes))


def _array(name: str, values: object) -> np.ndarray[Any, Any]:
    if np.ma.is_masked(values):
        raise UsageError(f"the column {name!r} is masked; give numbers, with NaN for what lacks.")
    return np.asarray(values)


def _frame_arrays(frame: object) -> dict[str, np.ndarray[Any, Any]]:
    narwhals = library("narwhals", "dataframe", Path("the dataframe"))
    try:
        table = narwhals.from_native(frame, eager_only=True)
    except TypeError as error:
        raise UsageError(
            f"the log is a {type(frame).__name__}; give a path, a dataframe (pandas, Polars, "
            "PyArrow, ...) or a mapping of column names to arrays."
        ) from error
    return {str(name): table[name].to_numpy() for name in table.columns}
