"""Reading of a log that a script gives as a dataframe or as a mapping of arrays."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from axisid.estimation.raw_tables import Table, TableBuilder, split_labels
from axisid.support.errors import DataError, UsageError
from axisid.support.libraries import one_line

from .column_checks import MIXED_TRUTHS, has_mixed_truths


def read_frame(frame: object) -> Table:
    """Return the columns of a mapping of arrays, or of any dataframe that narwhals supports.

    Raises
    ------
    UsageError
        The argument is neither a mapping nor a supported dataframe, or a column has masked values
        or values of different lengths.
    DataError
        Two columns have the same name.
    """
    if isinstance(frame, Mapping):
        arrays = [(str(name), _array(str(name), values)) for name, values in frame.items()]
    else:
        arrays = _frame_arrays(frame)
    builder = TableBuilder()
    split = split_labels([label for label, _ in arrays])
    for (name, unit), (label, values) in zip(split, arrays, strict=True):
        if values.dtype == object and has_mixed_truths(values.tolist()):
            builder.pass_over(label, MIXED_TRUTHS)
        else:
            builder.add(name, values, unit=unit, label=label)
    index = [str(name) for name in getattr(getattr(frame, "index", None), "names", ()) if name]
    missing = ""
    if index:
        missing = (
            f"The index {', '.join(index)} of the dataframe is not a column. Give "
            "log.reset_index()."
        )
    return builder.table(f"a {type(frame).__name__}", missing=missing)


def _array(name: str, values: object) -> np.ndarray[Any, Any]:
    """Return the values of a column of a mapping as an array; refuse masked or ragged values.

    Raises
    ------
    UsageError
    """
    if np.ma.is_masked(values):
        raise UsageError(
            f"the column {name!r} has masked values. Give numbers, with NaN for missing values.",
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
    """Return the names and values of the columns of a dataframe.

    Raises
    ------
    UsageError, DataError
        The argument is not a supported dataframe, or cannot be read.
    """
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
