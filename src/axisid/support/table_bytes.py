"""Columns as the content of a NumPy archive or a Parquet file."""

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .libraries import library


def npz_bytes(arrays: Mapping[str, Any]) -> bytes:
    """Return named arrays as the bytes of a compressed NumPy archive (.npz)."""
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    return buffer.getvalue()


def parquet_bytes(
    columns: Mapping[str, Any], units: Mapping[str, str], about: Mapping[str, str], file: Path
) -> bytes:
    """Return columns as the bytes of a Parquet file.

    Parameters
    ----------
    columns : mapping of str to array_like
    units : mapping of str to str
        Unit by column, written as the metadata ``unit`` of the field; columns may be missing.
    about : mapping of str to str
        Metadata of the schema, which describe the file.
    file : Path
        The file, for messages.

    Raises
    ------
    DataError
        pyarrow is not installed.
    """
    arrow = library("pyarrow", "parquet", file)
    parquet = library("pyarrow.parquet", "parquet", file)
    arrays = {name: arrow.array(values) for name, values in columns.items()}
    fields = [
        arrow.field(name, values.type, metadata={"unit": units[name]} if units.get(name) else None)
        for name, values in arrays.items()
    ]
    schema = arrow.schema(fields, metadata=dict(about))
    buffer = io.BytesIO()
    parquet.write_table(arrow.Table.from_arrays([*arrays.values()], schema=schema), buffer)
    return buffer.getvalue()
