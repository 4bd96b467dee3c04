"""A record as a file that `read_record` reads back as it is."""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from axisid.estimation.records import Record
from axisid.estimation.records.columns import RoleColumns, expected_units, is_scaling
from axisid.estimation.tables import TableBuilder, is_unit, parquet_bytes, split_labels
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array
from axisid.support.errors import AxisidError, ModelError

#: What the file of a twin's log says it is.
MARK = "axisid.twin/1"
_PROBED = np.array([1.0, 2.0, 6.0])  # what is read of them tells a column's scale and offset
_WHOLE = 1e-6  # of a count: what arithmetic leaves
_WITHOUT_UNIT = ("", "1")


def log_columns(record: Record, axis: Axis) -> dict[str, Array]:
    """The columns of a log by their heads, as the axis names them and in its units.

    Raises
    ------
    ModelError
        The axis names a column in a way that no log with heads can have.
    """
    channels = record.channels()
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
        read = RoleColumns(found.table("a twin's log"), axis, {}).samples
    except AxisidError:
        read = {}
    # A number is of a place in a log, and a head that begins as a comment does may be taken as one.
    lost = [r for r in axis.columns if r in heads and (r not in read or heads[r][0] == "#")]
    if lost:
        declared = ", ".join(f"{axis.columns[role]!r} of its {role}" for role in lost)
        raise ModelError(
            f"axis {axis.name!r} declares the columns {declared}, which a twin's log cannot have; "
            "declare them by their names and units.",
            code="twin-column",
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


def _csv(columns: Mapping[str, Array], about: str, _: Path) -> str:
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    lines = (",".join(map(repr, row)) for row in rows)
    return "\n".join([f"# {MARK} {about}", ",".join(columns), *lines, ""])


def _parquet(columns: Mapping[str, Array], about: str, file: Path) -> bytes:
    split = dict(zip(columns, split_labels([*columns]), strict=True))
    named = {split[head][0]: values for head, values in columns.items()}
    return parquet_bytes(named, dict(split.values()), {"axisid": MARK, "about": about}, file)


#: How a log is written, by the ending of its name: columns, what is said of it, and the file.
LOG_FORMATS: Mapping[str, Callable[[Mapping[str, Array], str, Path], str | bytes]] = {
    ".csv": _csv,
    ".parquet": _parquet,
}


def log_content(record: Record, axis: Axis, file: Path) -> str | bytes:
    """The content of a log with the units of its columns and the truth of its twin.

    Raises
    ------
    ModelError
        As `log_columns`.
    DataError
        The file is Parquet and pyarrow is not installed.
    """
    units = {parameter.name: parameter.unit for parameter in axis.parameters}
    truth = {name: record.provenance.truth[name] for name in units}
    told = ", ".join(f"{name} = {value:.9g} {units[name]}" for name, value in truth.items())
    about = f"{record.provenance.source}; true values {told}"
    return LOG_FORMATS[file.suffix](log_columns(record, axis), about, file)
