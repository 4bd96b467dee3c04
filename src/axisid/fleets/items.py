"""Logs of a fleet, named by file, pattern, folder, or by a manifest, which is a table of logs."""

import csv
import glob
import hashlib
import io
import math
import os
from collections import Counter
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from axisid.estimation.logs import log_endings
from axisid.estimation.records import log_of
from axisid.support.checks import listed, refuse
from axisid.support.errors import DataError, UsageError
from axisid.support.files import kinds_of, opened_regular, read_regular
from axisid.support.libraries import library
from axisid.support.wording import quoted

Condition = str | float
_LOG, _OWN = "log", ("log", "axis", "serial", "columns")
_TEXT, _PARQUET = (".csv", ".tsv", ".txt"), (".parquet", ".pq")
_LOOKED_AT = 4096  # bytes at the beginning of a table, which contain its header
_LOGS = {"twin", "twin-manifest"}  # kinds of output (`kinds_of`) that may be logs
_BY_PATH = ""  # origin of a log of which only the path is given


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetItem:
    """A log and its description, without its samples, so that it is cheap to send to a process.

    Attributes
    ----------
    log : str
        Path of the file.
    axis : str
        Name in the library, or file that declares it; empty for the axis of the fleet.
    serial : str
        Serial number of its machine; empty if it is not known.
    columns : mapping of str to str
        Columns of this log by role. They replace the columns that apply to all logs.
    conditions : mapping of str to str or float
        Further known properties of the log, such as a temperature or a date; they are copied into
        the table.
    name : str
        Name of its result, set by the fleet: the name of the log, with a suffix if two are equal.
    """

    log: str
    axis: str = ""
    serial: str = ""
    columns: Mapping[str, str] = field(default_factory=dict)
    conditions: Mapping[str, Condition] = field(default_factory=dict)
    name: str = field(default="", compare=False)

    @property
    def columns_text(self) -> str:
        """Return the columns as text in sorted order; equal columns give equal texts."""
        return ",".join(f"{role}={name}" for role, name in sorted(self.columns.items()))


def with_names(items: Sequence[FleetItem]) -> list[FleetItem]:
    """Return items with the names of their results.

    The name of a result is the name of the log, also if the log is given by a run.toml. Equal names
    get a suffix: a hash of the log's path, axis and columns, which is the same in every run.
    """
    stems = [Path(item.log).name.partition(".")[0] for item in items]
    names = [
        (log_of(item.log).name.partition(".")[0] if stem == "run" else stem) or _LOG
        for item, stem in zip(items, stems, strict=True)
    ]
    times = Counter(name.lower() for name in names)  # some file systems ignore case
    for i, item in enumerate(items):
        if times[names[i].lower()] > 1:
            parts = "\0".join(filter(None, (f"{item.log}\0{item.axis}", item.columns_text)))
            names[i] += f"-{hashlib.sha256(parts.encode(errors='replace')).hexdigest()[:8]}"
    return [replace(item, name=name) for item, name in zip(items, names, strict=True)]


def _heads_of(file: Path) -> list[str]:
    """Return the column names of a table; empty for a file that is not a table."""
    kind = file.suffix.lower()
    # An unreadable file is reported later, when it is read. The types are those of pyarrow.
    with suppress(OSError, ValueError, NotImplementedError):
        if kind in _PARQUET:
            return [*_parquet(file).schema_arrow.names]
        if kind in _TEXT:
            with opened_regular(file) as stream:
                text = stream.read(_LOOKED_AT).decode("utf-8-sig", "replace")
            return _heads(text.partition("\n")[0])
    return []


def _manifest_items(file: Path) -> Iterator[tuple[FleetItem, str]]:
    """Yield the items of a manifest, each with a text that names its row.

    Paths in a manifest are relative to its folder. Columns other than log, axis, serial and columns
    are conditions.
    """
    for number, row in enumerate(_rows(file), 1):
        cells = {k.strip(): v for k, v in row.items() if k and v not in (None, "")}
        conditions = {k: _condition(v) for k, v in cells.items() if k not in _OWN}
        axis, columns = str(cells.get("axis", "")), str(cells.get("columns", ""))
        pairs = [pair.partition("=") for pair in columns.split(",") if pair.strip()]
        unread = any(not (role.strip() and name.strip()) for role, _, name in pairs)
        refuse(
            DataError,
            (not cells.get(_LOG), f"names no log. Give the path of a log in the column {_LOG!r}"),
            (unread, f"has {columns!r} as columns. Write ROLE=NAME[:UNIT],..."),
            (
                any(row.get(None) or ()),
                "has more cells than the header has names. Correct the row or the header",
            ),
            before=f"{file}: row {number} ",
            code="manifest",
        )
        item = FleetItem(
            log=str(file.parent / str(cells[_LOG])),
            axis=str(file.parent / axis) if ".py" in axis or ".toml" in axis else axis,
            serial=str(cells.get("serial", "")),
            columns={role.strip(): name.strip() for role, _, name in pairs},
            conditions={k: v for k, v in conditions.items() if v is not None},
        )
        yield item, f"{file}, row {number},"


def _rows(file: Path) -> Iterator[Mapping[str | None, Any]]:
    """Yield the rows of a manifest, each a mapping of cells by column name.

    A row of a text file with more cells than the header has the further cells under None.
    """
    if file.suffix.lower() in _PARQUET:
        yield from _parquet(file).read().to_pylist()
        return
    try:
        text = io.StringIO(read_regular(file).decode("utf-8-sig"), newline=None).read()
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"{file} cannot be read: {error}.", code="manifest") from error
    first = text.split("\n", 1)[0]
    if twice := [head for head, times in Counter(_heads(first)).items() if head and times > 1]:
        raise DataError(
            f"{file} has {_heads(first).count(twice[0])} columns named {twice[0]!r}. Keep one of "
            "them, and delete or rename the others.",
            code="manifest",
        )
    yield from csv.DictReader(io.StringIO(text), delimiter=_delimiter(first), skipinitialspace=True)


def _parquet(file: Path) -> Any:
    """Return an open Parquet file."""
    return library("pyarrow.parquet", "parquet", file).ParquetFile(file)


def _delimiter(line: str) -> str:
    """Return the delimiter that occurs most in the header."""
    return max(",;\t", key=line.count)


def _heads(line: str) -> list[str]:
    """Return the column names in the first line of a table."""
    return [head.strip().strip('"') for head in line.strip().split(_delimiter(line))]


def _condition(given: Any) -> Condition | None:
    """Return a cell as a number if it is one, otherwise as text; None if it is not finite."""
    try:
        number = float(str(given))
    except ValueError:
        return str(given)
    return number if math.isfinite(number) else None


def gather_items(
    logs: str | Path | FleetItem | Iterable[str | Path | FleetItem], out: Path
) -> list[FleetItem]:
    """Return an item for each named log, in the order of the arguments, with the result's name.

    A log that is named several times gives one item. It gives several items if different axes or
    columns are given for it, as for a file of two machines. A path without a description is ignored
    if a manifest or an item describes the same log.

    Parameters
    ----------
    logs : path, FleetItem or iterable of them
        Files, patterns, folders (with the folders and manifests in them), manifests; a run.toml
        among them replaces its log. A manifest is a table with a column ``log``, and optionally
        ``axis``, ``serial`` and ``columns`` (as ``--columns`` takes them); every other column is a
        condition.
    out : Path
        Folder of the results, whose files are not logs.

    Raises
    ------
    UsageError
        There is no log, or an element of `logs` is not a path, a pattern or an item.
    DataError
        A manifest cannot be read, or two rows describe the same columns of a log differently.
    """
    arguments = listed(logs)
    # Each item with its origin: the row of a manifest, the number of an item, or `_BY_PATH`.
    named = [pair for i, each in enumerate(arguments, 1) for pair in _items(each, out, i)]
    runs = ((item.log, log_of(item.log)) for item, _ in named)
    described = {
        *(os.path.abspath(item.log) for item, by in named if by != _BY_PATH),
        *(os.path.abspath(log) for run, log in runs if log != Path(run)),
    }
    found: dict[Hashable, tuple[FleetItem, str]] = {}
    for item, by in named:
        path = os.path.abspath(item.log)
        if by == _BY_PATH and path in described:
            continue
        before, by_before = found.setdefault((path, item.axis, item.columns_text), (item, by))
        for what in ("serial", "conditions"):
            first, second = getattr(before, what), getattr(item, what)
            if first != second:
                raise DataError(
                    f"{by_before} and {by} give different {what} of {item.log}: {_as_text(first)} "
                    f"and {_as_text(second)}. Remove one of the two. If the log contains several "
                    "machines, give the columns of each machine in its row.",
                    code="manifest",
                )
    if not found:
        raise UsageError(
            f"no log was found in {' and '.join(map(str, arguments)) or 'an empty list'}. Name "
            "logs, folders of logs, or manifests.",
            code="fleet",
        )
    return with_names([item for item, _ in found.values()])


def _as_text(given: str | Mapping[str, Condition]) -> str:
    """Return a serial number or conditions as quoted text; ``none`` if empty."""
    text = given if isinstance(given, str) else ", ".join(f"{k}={v}" for k, v in given.items())
    return quoted(text) if text else "none"


def _items(given: object, out: Path, number: int) -> Iterator[tuple[FleetItem, str]]:
    """Yield the items of one argument, each with its origin as text.

    The origin is the row of a manifest, the number of a FleetItem, or `_BY_PATH`.

    Parameters
    ----------
    given : object
        A FleetItem, or a path or pattern.
    out : Path
        Folder of the results.
    number : int
        Number of the argument, for messages.
    """
    if isinstance(given, FleetItem):
        yield given, f"item {number}"
        return
    if not isinstance(given, (str, Path)):
        raise UsageError(
            f"a log is {quoted(given)}. Give a path, a pattern, a folder or a FleetItem.",
            code="fleet",
        )
    path, files = Path(given), [Path(given)]
    if path.is_dir() and not (path / "metadata.yaml").is_file():  # a ROS 2 bag is one log
        files = [file for file in sorted(path.rglob("*")) if _may_be_log(file, out)]
        # A run.toml describes a log; if it has mistakes, they are reported when it is read.
        runs = {f for f in files if f.name == "run.toml" or log_of(f) != f}
        files = [f for f in files if f.suffix.lower() in log_endings() or f in runs]
    elif not path.exists() and glob.has_magic(str(path)):
        matching = map(Path, sorted(glob.glob(str(path), recursive=True)))
        files = [file for file in matching if _may_be_log(file, out)]
    for file in files:
        if file.is_file() and _LOG in _heads_of(file):
            yield from _manifest_items(file)
        else:
            yield FleetItem(log=str(file)), _BY_PATH


def _may_be_log(file: Path, out: Path) -> bool:
    """Return True if a file may be a log: not hidden, not a result, not a table of results.

    A broken link or an unreadable file may be a log; the reason is reported when it is read.
    """
    is_in_out = out.resolve() == file.parent.resolve()
    is_result = is_in_out and (file.suffix == ".json" or file.stem == "fleet")
    if file.name.startswith(".") or is_result or (file.exists() and not file.is_file()):
        return False
    try:
        return not kinds_of(file) - _LOGS
    except OSError:
        return True
