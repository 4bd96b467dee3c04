"""The table of a fleet: a row for each log, as Parquet, CSV or NumPy's arrays."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from axisid.estimation.tables import UNITS_ENTRY, npz_bytes, parquet_bytes, split_labels
from axisid.presentation.saved import schema_of
from axisid.support.errors import UsageError
from axisid.support.files.csv_text import csv_text
from axisid.support.files.regular_file import write_file
from axisid.support.quoting import quoted

from .ledger import FleetRow
from .outliers import Outlier

Cell = str | float | None
Columns = dict[str, list[Cell]]
Units = Mapping[str, str]
#: Its names where it is given none.
TABLES = ("fleet.parquet", "fleet.csv")


def write_table(
    rows: Sequence[FleetRow], outliers: Sequence[Outlier], folder: Path, file: Path | None
) -> Path:
    """Write the table of all logs; see `Fleet.write`."""
    if file is None:
        file = folder / TABLES[find_spec("pyarrow") is None]
    if file.suffix not in _WRITERS:
        raise UsageError(
            f"the table is {quoted(str(file))}; give a name that ends in {', '.join(_WRITERS)}.",
            code="fleet",
        )
    columns, units = columns_of(rows, outliers), units_of(rows)
    return write_file(file, _WRITERS[file.suffix](columns, units, file))


def columns_of(rows: Sequence[FleetRow], outliers: Sequence[Outlier]) -> Columns:
    """The table by column: what a log is, how it ended, its parameters, how far it is out."""
    out = {each.name: each for each in outliers}
    columns: Columns = {
        name: [getattr(row, name) for row in rows]
        for name in ("name", "log", "axis", "serial", "status", "reason", "code", "method")
    }
    columns["verdict"] = [row.verdict for row in rows]
    columns["failing"] = ["; ".join(row.failing) for row in rows]
    columns |= _of_conditions(rows)
    for name in _each(row.parameters for row in rows):
        columns |= _of_parameter(name, rows)
    columns["outlier_distance"] = [_figure(out, row.name, "distance") for row in rows]
    columns["outlier_p"] = [_figure(out, row.name, "p_value") for row in rows]
    columns["seconds"] = [row.seconds for row in rows]
    return columns


def _each(mappings: Iterator[Mapping[str, object]] | Sequence[Mapping[str, object]]) -> list[str]:
    """Names in any of them, in the order in which they come."""
    return list(dict.fromkeys(name for each in mappings for name in each))


def _of_conditions(rows: Sequence[FleetRow]) -> Columns:
    """Conditions; numbers where all of one are, else texts, since a column has one kind."""
    found: Columns = {}
    for name in _each([row.conditions for row in rows]):
        values = [row.conditions.get(name) for row in rows]
        numeric = all(value is None or isinstance(value, float) for value in values)
        cells: list[Cell] = [v if v is None or numeric else str(v) for v in values]
        found[f"condition.{name}"] = cells
    return found


def _of_parameter(name: str, rows: Sequence[FleetRow]) -> Columns:
    values = [row.parameters.get(name) for row in rows]
    columns: Columns = {
        name: [None if v is None else v.value for v in values],
        f"{name}.sd": [None if v is None else v.sd for v in values],
        f"{name}.low": [None if v is None else v.interval_95[0] for v in values],
        f"{name}.high": [None if v is None else v.interval_95[1] for v in values],
    }
    if _unit(name, rows) is None:  # of axes that call different things the same
        columns[f"{name}.unit"] = [None if v is None else v.unit for v in values]
    return columns


def _unit(name: str, rows: Sequence[FleetRow]) -> str | None:
    """The unit of a parameter; None where its rows have several."""
    units = {row.parameters[name].unit for row in rows if name in row.parameters}
    return units.pop() if len(units) == 1 else None


def units_of(rows: Sequence[FleetRow]) -> dict[str, str]:
    """Units of the columns that have one."""
    found: dict[str, str] = {}
    for name in _each(row.parameters for row in rows):
        if unit := _unit(name, rows):
            found |= dict.fromkeys((name, f"{name}.sd", f"{name}.low", f"{name}.high"), unit)
    of_conditions = {
        f"condition.{name}": split_labels([name])[0][1]
        for name in _each([row.conditions for row in rows])
    }
    found |= {name: unit for name, unit in of_conditions.items() if unit}
    return {**found, "outlier_distance": "1", "outlier_p": "1", "seconds": "s"}


def _figure(outliers: Mapping[str, Outlier], name: str, what: str) -> float | None:
    return getattr(outliers[name], what) if name in outliers else None


def _csv(columns: Columns, units: Units, _: Path) -> str:
    heads = [_head(name, units.get(name, "")) for name in columns]
    return csv_text([heads, *zip(*columns.values(), strict=True)])


def _head(name: str, unit: str) -> str:
    """A name with its unit, which that of a condition may have already."""
    return f"{name} [{unit}]" if unit and not name.endswith(("]", ")")) else name


def _parquet(columns: Columns, units: Units, file: Path) -> bytes:
    return parquet_bytes(columns, units, {"axisid": schema_of(FleetRow)}, file)


def _npz(columns: Columns, units: Units, _: Path) -> bytes:
    arrays = {
        name: np.array(["" if cell is None else cell for cell in cells])
        if any(isinstance(cell, str) for cell in cells)
        else np.array(cells, dtype=np.float64)
        for name, cells in columns.items()
    }
    return npz_bytes({**arrays, UNITS_ENTRY: json.dumps(units)})


_WRITERS: Mapping[str, Callable[[Columns, Units, Path], str | bytes]] = {
    ".parquet": _parquet,
    ".csv": _csv,
    ".npz": _npz,
}
