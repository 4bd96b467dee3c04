"""Columns by role as a log has them: under the axis's heads, in its units, whole as a file."""

import json
from collections.abc import Callable, Container, Mapping, Sequence
from pathlib import Path

import numpy as np

from axisid.estimation.logs.text import is_number
from axisid.estimation.tables import (
    UNITS_ENTRY,
    TableBuilder,
    is_unit,
    npz_bytes,
    parquet_bytes,
    split_labels,
)
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array
from axisid.support.errors import AxisidError, ModelError, UsageError

from .roles import role_columns
from .units import expected_units, is_scaling

Units = Sequence[tuple[str, str]]  # names and units of columns

_PROBED = np.array([1.0, 2.0, 6.0])  # what is read of them tells a column's scale and offset
_WHOLE = 1e-6  # of a count: what arithmetic leaves
_WITHOUT_UNIT = ("", "1")


def log_content(
    channels: Mapping[str, Array], axis: Axis, mark: str, about: str, file: Path
) -> str | bytes:
    """The content of a log that `read_record` reads back as it is.

    Parameters
    ----------
    channels : mapping of str to array, (N,) each
        By role, SI.
    axis : Axis
    mark, about : str
        What the file says it is, and of what.
    file : Path
        Its ending tells how it is written, see `LOG_FORMATS`.

    Raises
    ------
    UsageError
        The ending is another one.
    ModelError
        The axis names a column in a way that no log with heads can have.
    DataError
        The file is Parquet and pyarrow is not installed.
    """
    if file.suffix not in LOG_FORMATS:
        raise UsageError(
            f"{file}: a log is written to {', '.join(LOG_FORMATS)}; give a name with one of these "
            "endings.",
            code="twin",
        )
    columns = _log_columns(channels, axis)
    units = _units(columns, {str(declared) for declared in axis.columns.values()})
    return LOG_FORMATS[file.suffix](columns, units, f"{mark} {' '.join(about.split())}", file)


def _log_columns(channels: Mapping[str, Array], axis: Axis) -> dict[str, Array]:
    """The columns of a log by their heads, as the axis names them and in its units."""
    heads = {role: _head(role, axis) for role in channels}
    scales = _scales(heads, axis)
    return {heads[role]: _as_logged(values, *scales[role]) for role, values in channels.items()}


def _head(role: str, axis: Axis) -> str:
    """Name and unit, such as ``position [m]``."""
    declared = str(axis.columns.get(role, role))
    name, colon, meaning = declared.rpartition(":")
    told = meaning.strip()
    if colon and is_scaling(told):
        return name.strip()
    if colon and is_unit(told):
        return f"{name.strip()} [{told}]"
    if split_labels([declared])[0][1]:
        return declared
    (unit,) = expected_units(role, axis) or ("",)
    return declared if unit in _WITHOUT_UNIT else f"{declared} [{unit}]"


def _scales(heads: Mapping[str, str], axis: Axis) -> dict[str, tuple[float, float]]:
    """What the numbers of each role are times and plus, to be SI."""
    found = TableBuilder()
    for (name, unit), head in zip(split_labels([*heads.values()]), heads.values(), strict=True):
        found.add(name, _PROBED, unit=unit, label=head)
    try:
        read = role_columns(found.table("a log"), axis, {}).samples
    except AxisidError:
        read = {}
    # A number is of a place in a log, and a head that begins as a comment does may be taken as one.
    lost = [r for r in axis.columns if r in heads and (r not in read or heads[r][0] == "#")]
    if lost:
        declared = ", ".join(f"{axis.columns[role]!r} of its {role}" for role in lost)
        raise ModelError(
            f"axis {axis.name!r} declares the columns {declared}, which a log with heads cannot "
            "have; declare them by their names and units.",
            code="twin",
        )
    return {role: _scale(read[role].values) if role in read else (1.0, 0.0) for role in heads}


def _scale(read: Array) -> tuple[float, float]:
    factor = float((read[-1] - read[0]) / (_PROBED[-1] - _PROBED[0]))
    return factor, float(read[0] - factor * _PROBED[0])


def _as_logged(values: Array, factor: float, offset: float) -> Array:
    if (factor, offset) == (1.0, 0.0):
        return values
    raw = (values - offset) / factor
    whole = np.rint(raw)
    return whole if np.all(np.abs(raw - whole) < _WHOLE) else raw


def _units(columns: Mapping[str, Array], declared: Container[str]) -> list[tuple[str, str]]:
    """Names and units of columns for files that have both; a name with its unit as declared."""
    split = zip(columns, split_labels([*columns]), strict=True)
    return [(head if head in declared else name, unit) for head, (name, unit) in split]


def _csv(columns: Mapping[str, Array], _: Units, about: str, file: Path) -> str:
    # Readers take quotes as they stand, and a line of numbers for no heads.
    if any(set(head) & set(',"\r\n') for head in columns) or all(
        is_number(name) for name, _ in split_labels([*columns])
    ):
        raise ModelError(
            f"{file}: a text with commas cannot have the heads {', '.join(map(repr, columns))}; "
            "write .parquet or .npz, or declare other names.",
            code="twin",
        )
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    lines = (",".join(map(repr, row)) for row in rows)
    return "\n".join([f"# {about}", ",".join(columns), *lines, ""])


def _parquet(columns: Mapping[str, Array], units: Units, about: str, file: Path) -> bytes:
    named = {name: values for (name, _), values in zip(units, columns.values(), strict=True)}
    mark, _, said = about.partition(" ")
    return parquet_bytes(named, dict(units), {"axisid": mark, "about": said}, file)


def _npz(columns: Mapping[str, Array], units: Units, about: str, _: Path) -> bytes:
    named = zip(units, columns.values(), strict=True)
    arrays = {name: values for (name, _), values in named}
    return npz_bytes({**arrays, UNITS_ENTRY: json.dumps(dict(units)), "axisid": about})


#: How a log is written, by the ending of its name.
LOG_FORMATS: Mapping[str, Callable[[Mapping[str, Array], Units, str, Path], str | bytes]] = {
    ".csv": _csv,
    ".parquet": _parquet,
    ".npz": _npz,
}
