"""A manifest: a table that names logs and says what is known of each."""

import csv
import io
import math
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from axisid.estimation.logs import log_endings
from axisid.estimation.tables import library
from axisid.support.errors import DataError
from axisid.support.files.regular_file import opened_regular, read_regular

from .item import FleetItem

_LOG, _OWN = "log", ("log", "axis", "serial", "columns")
_TEXT, _PARQUET = (".csv", ".tsv", ".txt"), (".parquet", ".pq")
_LOOKED_AT = 4096  # bytes of a header


def is_manifest(file: Path) -> bool:
    """Whether a table's first column names are those of a manifest: one of them is ``log``."""
    kind = file.suffix.lower()
    try:
        if kind in _TEXT:
            with opened_regular(file) as stream:
                line = stream.read(_LOOKED_AT).decode("utf-8-sig", "replace").split("\n", 1)[0]
            return _LOG in _heads(line)
        return kind in _PARQUET and _LOG in _parquet(file).schema_arrow.names
    except (OSError, DataError):
        return False  # who reads it says what is wrong
    except Exception as error:
        if type(error).__module__.startswith("pyarrow"):
            return False
        raise


def check_no_manifest(file: Path) -> None:
    """Refuse a table that names logs in another column than a manifest does, which is no log.

    Raises
    ------
    DataError
        Its first row has the path of another file.
    """
    if file.suffix.lower() not in _TEXT:
        return
    try:
        with opened_regular(file) as stream:
            lines = stream.read(_LOOKED_AT).decode("utf-8-sig", "replace").splitlines()
    except OSError:
        return  # who reads it says what is wrong
    heads, cells = (_heads(line) for line in (*lines[:2], "", "")[:2])
    paths = [head for head, cell in zip(heads, cells, strict=False) if _names_log(file, cell)]
    if paths:
        raise DataError(
            f"{file} names logs and has no column {_LOG!r}, which a manifest has; it has "
            f"{', '.join(heads)}. Call the column {paths[0]!r} {_LOG!r}.",
            code="manifest-without-log",
        )


def _names_log(file: Path, cell: str) -> bool:
    """Whether a cell is the path of another file whose ending is that of a log."""
    ending, path = Path(cell).suffix.lower(), file.parent / cell
    try:
        return ending in log_endings() and path.is_file() and not path.samefile(file)
    except (OSError, ValueError):
        return False


def manifest_items(file: Path) -> Iterator[FleetItem]:
    """The items of a manifest.

    Its columns are ``log``, and where they are wanted ``axis``, ``serial`` and ``columns`` (as
    ``--columns`` takes them); every other one is a condition. Paths are as from its folder.

    Raises
    ------
    DataError
        It cannot be read, or a row names no log.
    """
    for number, row in enumerate(_rows(file), 1):
        told = {k.strip(): v for k, v in row.items() if k and v not in (None, "")}
        conditions = {k: _value(v) for k, v in told.items() if k not in _OWN}
        if not told.get(_LOG):
            raise DataError(
                f"{file}: row {number} names no log; give its path in the column {_LOG!r}.",
                code="manifest-row",
            )
        yield FleetItem(
            log=_from(file, str(told[_LOG])),
            axis=_axis(file, str(told.get("axis", ""))),
            serial=str(told.get("serial", "")),
            columns=_columns(file, number, str(told.get("columns", ""))),
            conditions={k: v for k, v in conditions.items() if v is not None},
        )


def _rows(file: Path) -> Iterator[Mapping[str, Any]]:
    if file.suffix.lower() in _PARQUET:
        yield from _parquet(file).read().to_pylist()
        return
    try:
        text = read_regular(file).decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"{file} cannot be read: {error}.", code="manifest-not-read") from error
    first = text.split("\n", 1)[0]
    if twice := [head for head, times in Counter(_heads(first)).items() if head and times > 1]:
        raise DataError(
            f"{file} has {_heads(first).count(twice[0])} columns {twice[0]!r}; leave one.",
            code="manifest-column-twice",
        )
    yield from csv.DictReader(io.StringIO(text), delimiter=_delimiter(first), skipinitialspace=True)


def _parquet(file: Path) -> Any:
    return library("pyarrow.parquet", "parquet", file).ParquetFile(file)


def _delimiter(line: str) -> str:
    """The one that the header has most of."""
    return max(",;\t", key=line.count)


def _heads(line: str) -> list[str]:
    return [head.strip().strip('"') for head in line.strip().split(_delimiter(line))]


def _from(file: Path, path: str) -> str:
    """A path as from the manifest's folder."""
    return str(file.parent / path)


def _axis(file: Path, named: str) -> str:
    """An axis's name, or its file as from the manifest's folder."""
    return _from(file, named) if ".py" in named or ".toml" in named else named


def _columns(file: Path, number: int, text: str) -> dict[str, str]:
    pairs = [pair.partition("=") for pair in text.split(",") if pair.strip()]
    if any(not (role.strip() and name.strip()) for role, _, name in pairs):
        raise DataError(
            f"{file}: row {number} has the columns {text!r}; write ROLE=NAME[:UNIT],....",
            code="manifest-columns",
        )
    return {role.strip(): name.strip() for role, _, name in pairs}


def _value(given: Any) -> str | float | None:
    """A condition: a number where it is one; none where that is not finite, as of an empty cell."""
    try:
        number = float(str(given))
    except ValueError:
        return str(given)
    return number if math.isfinite(number) else None
