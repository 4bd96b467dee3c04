"""Writing of columns by role as a log, with the names and units of an axis."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from axisid.estimation.logs.text import is_number
from axisid.estimation.raw_tables import UNITS_ENTRY, TableBuilder, is_unit, split_labels
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array
from axisid.support.errors import AxisidError, ModelError, UsageError
from axisid.support.table_bytes import npz_bytes, parquet_bytes

from .roles import role_columns
from .units import expected_units, is_scaling

_PROBED = np.array([1.0, 2.0, 6.0])  # numbers whose conversion to SI shows scale and offset
#: Endings of the files that a log can be written to.
LOG_ENDINGS = (".csv", ".parquet", ".npz")


def log_content(
    channels: Mapping[str, Array], axis: Axis, mark: str, about: str, file: Path
) -> str | bytes:
    """Return the content of a log that `read_record` reads back unchanged.

    Parameters
    ----------
    channels : mapping of str to array, (N,) each
        Columns by role, SI.
    axis : Axis
        Axis that declares names and units of the columns.
    mark, about : str
        Kind of the file, and a text on its source, for the description in the file.
    file : Path
        Path whose ending determines the format, see `LOG_ENDINGS`.

    Raises
    ------
    UsageError
        The ending is not in `LOG_ENDINGS`.
    ModelError
        The axis declares a column name that is not possible in a header.
    DataError
        The file is Parquet and pyarrow is not installed.
    """
    if file.suffix not in LOG_ENDINGS:
        raise UsageError(
            f"{file}: a log cannot be written to a file with this ending. Give a name that ends in "
            f"one of {', '.join(LOG_ENDINGS)}.",
            code="twin",
        )
    heads = {role: _head(role, axis) for role in channels}
    scales = _scales(heads, axis)
    columns = {heads[role]: _as_logged(v, *scales[role]) for role, v in channels.items()}
    if file.suffix == ".csv":
        return _csv(columns, f"{mark} {' '.join(about.split())}", file)
    # Parquet and NumPy files have names and units apart; a declared name with a unit stays whole.
    split = zip(columns, split_labels([*columns]), strict=True)
    declared = {str(column) for column in axis.columns.values()}
    units = {head if head in declared else name: unit for head, (name, unit) in split}
    named: dict[str, Any] = dict(zip(units, columns.values(), strict=True))
    metadata = {"axisid": mark, "about": " ".join(about.split())}
    if file.suffix == ".parquet":
        return parquet_bytes(named, units, metadata, file)
    return npz_bytes(
        {**named, UNITS_ENTRY: json.dumps(units), "axisid": " ".join(metadata.values())}
    )


def _head(role: str, axis: Axis) -> str:
    """Return the header of the column of a role: its name and unit, such as ``position [m]``."""
    declared = str(axis.columns.get(role, role))
    name, colon, meaning = (part.strip() for part in declared.rpartition(":"))
    if colon and is_scaling(meaning):
        return name
    if colon and is_unit(meaning):
        return f"{name} [{meaning}]"
    (unit,) = expected_units(role, axis) or ("",)
    has_unit = split_labels([declared])[0][1] or unit in ("", "1")
    return declared if has_unit else f"{declared} [{unit}]"


def _scales(heads: Mapping[str, str], axis: Axis) -> dict[str, tuple[float, float]]:
    """Return the factor and the offset from the numbers of a log to SI, by role.

    A few numbers are read from a table with these headers (`heads`, by role); their values in SI
    show factor and offset.

    Raises
    ------
    ModelError
        A declared column name is not possible in a header.
    """
    builder = TableBuilder()
    for (name, unit), head in zip(split_labels([*heads.values()]), heads.values(), strict=True):
        builder.add(name, _PROBED, unit=unit, label=head)
    try:
        read = role_columns(builder.table("a log"), axis, {}).samples
    except AxisidError:
        read = {}
    # A name such as #3 is the number of a column, and a header that begins with # is a comment.
    lost = [r for r in axis.columns if r in heads and (r not in read or heads[r][0] == "#")]
    if lost:
        declared = ", ".join(f"{axis.columns[role]!r} of its {role}" for role in lost)
        raise ModelError(
            f"axis {axis.name!r} declares the columns {declared}, which are not possible as names "
            "in a header. Declare columns by their names and units.",
            code="twin",
        )
    scales = {}
    for role in heads:
        values = read[role].values if role in read else _PROBED
        factor = float((values[-1] - values[0]) / (_PROBED[-1] - _PROBED[0]))
        scales[role] = factor, float(values[0] - factor * _PROBED[0])
    return scales


def _as_logged(values: Array, factor: float, offset: float) -> Array:
    """Return values in SI, (N,), as the numbers of a log, (N,): whole numbers for counts."""
    if (factor, offset) == (1.0, 0.0):
        return values
    raw = (values - offset) / factor
    whole = np.rint(raw)
    # Rounding errors of a count are less than a millionth.
    return whole if np.all(np.abs(raw - whole) < 1e-6) else raw


def _csv(columns: Mapping[str, Array], about: str, file: Path) -> str:
    """Return columns, (N,) by header, as comma-separated text with a first line `about`.

    Raises
    ------
    ModelError
        A header has a comma, a quote or a line end, or all headers are numbers.
    """
    # Quotes would be part of a name, and a line of numbers is no header.
    if any(set(head) & set(',"\r\n') for head in columns) or all(
        is_number(name) for name, _ in split_labels([*columns])
    ):
        raise ModelError(
            f"{file}: the column names {', '.join(map(repr, columns))} cannot be written as "
            "comma-separated text. Give a file name that ends in .parquet or .npz, or declare "
            "other names.",
            code="twin",
        )
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    return "\n".join(
        [f"# {about}", ",".join(columns), *(",".join(map(repr, row)) for row in rows), ""]
    )
