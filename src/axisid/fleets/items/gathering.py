"""Logs by name, pattern, folder or manifest, a table that says what is known of each."""

import csv
import glob
import hashlib
import io
import math
import os
from collections import Counter
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from axisid.estimation.logs import log_endings
from axisid.estimation.records import log_of
from axisid.estimation.tables import library
from axisid.support.errors import DataError, UsageError
from axisid.support.files.regular_file import opened_regular, read_regular
from axisid.support.quoting import quoted

Condition = str | float
_LOG, _OWN = "log", ("log", "axis", "serial", "columns")
_TEXT, _PARQUET = (".csv", ".tsv", ".txt"), (".parquet", ".pq")
_LOOKED_AT = 4096  # bytes of a header
_RESULTS = ".json"  # a log's ending too
_FLEET, _RUN = "fleet", "run"  # ledger and table; what is said of a log
_BY_PATH = ""  # where nothing but the path of a log is told


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetItem:
    """A log and what is said of it; never its samples, so that it can be sent anywhere.

    Attributes
    ----------
    log : str
        Path of the file.
    axis : str
        Name in the library, or file that declares it; empty for the fleet's.
    serial : str
        Which machine it is of; empty where nothing says so.
    columns : mapping of str to str
        Columns of this log by role, in place of those of all.
    conditions : mapping of str to str or float
        What else is known of the log: a temperature, a date. It goes on into the table.
    """

    log: str
    axis: str = ""
    serial: str = ""
    columns: Mapping[str, str] = field(default_factory=dict)
    conditions: Mapping[str, Condition] = field(default_factory=dict)

    @property
    def columns_text(self) -> str:
        """The columns in an order of their own, the same where they are the same."""
        return ",".join(f"{role}={name}" for role, name in sorted(self.columns.items()))


def result_names(items: Sequence[FleetItem]) -> list[str]:
    """Names of the items' results: those of the logs, with a mark where two have the same."""
    plain = [_stem(item.log) or _LOG for item in items]
    times = Counter(name.lower() for name in plain)  # some file systems know no case
    marked = [
        name if times[name.lower()] == 1 else f"{name}-{_mark(item)}"
        for name, item in zip(plain, items, strict=True)
    ]
    return list(_apart(marked))


def _stem(log: str) -> str:
    """The name of a log; that of a run.toml says nothing, and gives way to its log's."""
    stem = Path(log).name.partition(".")[0]
    return log_of(log).name.partition(".")[0] if stem == _RUN else stem


def _mark(item: FleetItem) -> str:
    """Of a log, its axis and its columns, the same in every run."""
    told = "\0".join(filter(None, (f"{item.log}\0{item.axis}", item.columns_text)))
    return hashlib.sha256(told.encode(errors="replace")).hexdigest()[:8]


def _apart(names: list[str]) -> list[str]:
    """Names with a number where the same log stands there again."""
    seen: Counter[str] = Counter()
    told = []
    for name in names:
        seen[name.lower()] += 1
        number = seen[name.lower()]
        told.append(name if number == 1 else f"{name}-{number}")
    return told


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
            code="manifest",
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
                code="manifest",
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
        raise DataError(f"{file} cannot be read: {error}.", code="manifest") from error
    first = text.split("\n", 1)[0]
    if twice := [head for head, times in Counter(_heads(first)).items() if head and times > 1]:
        raise DataError(
            f"{file} has {_heads(first).count(twice[0])} columns {twice[0]!r}; leave one.",
            code="manifest",
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
            code="manifest",
        )
    return {role.strip(): name.strip() for role, _, name in pairs}


def _value(given: Any) -> str | float | None:
    """A condition: a number where it is one; none where that is not finite, as of an empty cell."""
    try:
        number = float(str(given))
    except ValueError:
        return str(given)
    return number if math.isfinite(number) else None


def gather_items(
    logs: str | Path | FleetItem | Iterable[str | Path | FleetItem], out: Path
) -> list[FleetItem]:
    """Items of all that is named, each once, in their order.

    A log is there several times where other axes or columns are told of it, as of a file of two
    machines. Where a manifest or an item tells what it is, its bare path adds nothing.

    Parameters
    ----------
    logs : path, FleetItem or iterable of them
        Files, patterns, folders (with the folders and manifests in them), manifests; a run.toml
        among them stands in the place of its log.
    out : Path
        Folder of the results, whose files are no logs.

    Raises
    ------
    UsageError
        There is none, or something is no path.
    DataError
        A manifest cannot be read, or the same columns of a log are told to be of another machine.
    """
    if not isinstance(logs, (str, Path, FleetItem, Iterable)):
        raise UsageError(
            f"the logs are {quoted(logs)}; give files, patterns, folders or manifests.",
            code="fleet",
        )
    listed = [logs] if isinstance(logs, (str, Path, FleetItem)) else list(logs)
    told = [each for place, one in enumerate(listed, 1) for each in _items(one, out, place)]
    described = {_place(item) for item, by in told if by != _BY_PATH}
    runs = ((item.log, log_of(item.log)) for item, _ in told)
    described |= {os.path.abspath(log) for run, log in runs if log != Path(run)}
    found: dict[Hashable, tuple[FleetItem, str]] = {}
    for item, by in told:
        if by == _BY_PATH and _place(item) in described:
            continue
        before = found.setdefault((_place(item), item.axis, item.columns_text), (item, by))
        _check_alike(before, (item, by))
    if not found:
        said = " and ".join(map(str, listed))
        raise UsageError(f"there is no log in {said or 'nothing'}; name some.", code="fleet")
    return [item for item, _ in found.values()]


def _place(item: FleetItem) -> str:
    """Where a log is, however it is named."""
    return os.path.abspath(item.log)


def _check_alike(before: tuple[FleetItem, str], again: tuple[FleetItem, str]) -> None:
    """Refuse what tells other things of the same columns of a log: one of the two is wrong."""
    (item, by), (other, by_other) = before, again
    for what in ("serial", "conditions"):
        first, second = getattr(item, what), getattr(other, what)
        if first != second:
            raise DataError(
                f"{by} and {by_other} tell other {what} of {item.log}: {_said(first)} and "
                f"{_said(second)}. Leave one out, or give each its own columns where the log is of "
                "several machines.",
                code="manifest",
            )


def _said(told: object) -> str:
    """A serial number or conditions, as they are told."""
    pairs = told.items() if isinstance(told, Mapping) else ()
    text = ", ".join(f"{k}={v}" for k, v in pairs) if pairs else str(told or "none")
    return quoted(text) if text != "none" else text


def _items(given: object, out: Path, place: int) -> Iterator[tuple[FleetItem, str]]:
    """Items, each with who tells of it."""
    if isinstance(given, FleetItem):
        yield given, f"item {place}"
        return
    if not isinstance(given, (str, Path)):
        raise UsageError(
            f"a log is {quoted(given)}; give a path, a pattern, a folder or a FleetItem.",
            code="fleet",
        )
    path = Path(given)
    if path.is_dir() and not (path / "metadata.yaml").is_file():  # that of a ROS 2 bag is one log
        for file in _logs_in(path, out):
            if is_manifest(file):
                yield from _told_by(file)
            else:
                yield FleetItem(log=str(file)), _BY_PATH
    elif not path.exists() and glob.has_magic(str(path)):
        for name in sorted(glob.glob(str(path), recursive=True)):
            if _may_be_log(Path(name), out):
                yield from _items_of(Path(name))
    else:
        yield from _items_of(path)


def _items_of(file: Path) -> Iterator[tuple[FleetItem, str]]:
    """The item of a log, or those of a manifest."""
    if not file.is_file() or not is_manifest(file):
        check_no_manifest(file)
        yield FleetItem(log=str(file)), _BY_PATH
        return
    yield from _told_by(file)


def _told_by(manifest: Path) -> Iterator[tuple[FleetItem, str]]:
    for number, item in enumerate(manifest_items(manifest), 1):
        yield item, f"{manifest}, row {number},"


def _logs_in(folder: Path, out: Path) -> list[Path]:
    endings = log_endings()
    return sorted(
        file
        for file in folder.rglob("*")
        if (file.suffix.lower() in endings or _is_run(file)) and _may_be_log(file, out)
    )


def _is_run(file: Path) -> bool:
    """Whether a file says what a log is; one of that name does, though it be wrong."""
    return file.name == f"{_RUN}.toml" or log_of(file) != file


def _may_be_log(file: Path, out: Path) -> bool:
    """Whether it is no hidden file, and nothing that a fleet wrote; a link to nothing may be."""
    own = out.resolve() == file.parent.resolve() and (
        file.suffix == _RESULTS or file.stem == _FLEET
    )
    return (file.is_file() or not file.exists()) and not file.name.startswith(".") and not own
