"""Logs of a fleet, named by file, pattern, folder, or a manifest: a table of logs."""

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
_LOOKED_AT = 4096  # bytes of a header
_LOGS = {"twin", "twin-manifest"}  # of files that commands write
_BY_PATH = ""  # for a log of which only the path is given


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetItem:
    """A log and its description, without its samples, so that it can be sent anywhere.

    Attributes
    ----------
    log : str
        Path of the file.
    axis : str
        Name in the library, or file that declares it; empty for the axis of the fleet.
    serial : str
        Serial number of its machine; empty if it is not known.
    columns : mapping of str to str
        Columns of this log by role, instead of those of all logs.
    conditions : mapping of str to str or float
        Further known properties of the log, such as a temperature or a date; they are copied into
        the table.
    name : str
        Name of its result, set by the fleet: that of the log, with a mark if two are equal.
    """

    log: str
    axis: str = ""
    serial: str = ""
    columns: Mapping[str, str] = field(default_factory=dict)
    conditions: Mapping[str, Condition] = field(default_factory=dict)
    name: str = field(default="", compare=False)

    @property
    def columns_text(self) -> str:
        """Return the columns in sorted order, so that equal columns give equal texts."""
        return ",".join(f"{role}={name}" for role, name in sorted(self.columns.items()))


def with_names(items: Sequence[FleetItem]) -> list[FleetItem]:
    """Return items with the names of their results.

    The name is that of the log, also if a run.toml is given. If two are equal, a mark is appended
    that depends on the log, its axis and its columns, and is the same in every run.
    """
    stems = [Path(item.log).name.partition(".")[0] for item in items]
    names = [
        (log_of(item.log).name.partition(".")[0] if stem == "run" else stem) or _LOG
        for item, stem in zip(items, stems, strict=True)
    ]
    times = Counter(name.lower() for name in names)  # some file systems ignore case
    for i, item in enumerate(items):
        if times[names[i].lower()] > 1:
            told = "\0".join(filter(None, (f"{item.log}\0{item.axis}", item.columns_text)))
            names[i] += f"-{hashlib.sha256(told.encode(errors='replace')).hexdigest()[:8]}"
    return [replace(item, name=name) for item, name in zip(items, names, strict=True)]


def _heads_of(file: Path) -> list[str]:
    """Return the column names of a table; empty if there are none."""
    kind = file.suffix.lower()
    # An unreadable file is reported by its reader; pyarrow's errors are of these types.
    with suppress(OSError, ValueError, NotImplementedError):
        if kind in _PARQUET:
            return [*_parquet(file).schema_arrow.names]
        if kind in _TEXT:
            with opened_regular(file) as stream:
                text = stream.read(_LOOKED_AT).decode("utf-8-sig", "replace")
            return _heads(text.partition("\n")[0])
    return []


def _manifest_items(file: Path) -> Iterator[tuple[FleetItem, str]]:
    """Yield the logs of a manifest, each with a text that names its row.

    Paths in a manifest are relative to its folder.
    """
    for number, row in enumerate(_rows(file), 1):
        told = {k.strip(): v for k, v in row.items() if k and v not in (None, "")}
        conditions = {k: _condition(v) for k, v in told.items() if k not in _OWN}
        axis, columns = str(told.get("axis", "")), str(told.get("columns", ""))
        pairs = [pair.partition("=") for pair in columns.split(",") if pair.strip()]
        unread = any(not (role.strip() and name.strip()) for role, _, name in pairs)
        refuse(
            DataError,
            (not told.get(_LOG), f"does not name a log. Give its path in the column {_LOG!r}"),
            (unread, f"has {columns!r} as columns. Write ROLE=NAME[:UNIT],..."),
            (
                any(row.get(None) or ()),
                "has more cells than the header has names. Correct the row or the header",
            ),
            before=f"{file}: row {number} ",
            code="manifest",
        )
        item = FleetItem(
            log=str(file.parent / str(told[_LOG])),
            axis=str(file.parent / axis) if ".py" in axis or ".toml" in axis else axis,
            serial=str(told.get("serial", "")),
            columns={role.strip(): name.strip() for role, _, name in pairs},
            conditions={k: v for k, v in conditions.items() if v is not None},
        )
        yield item, f"{file}, row {number},"


def _rows(file: Path) -> Iterator[Mapping[str | None, Any]]:
    """Yield the rows of a manifest, by column name."""
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
            f"{file} has {_heads(first).count(twice[0])} columns named {twice[0]!r}. Keep one.",
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
    """Return all named logs, each once, in their order, with names for their results.

    A log occurs several times if several axes or columns are given for it, as for a file of two
    machines. If a manifest or an item describes it, its bare path adds nothing.

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
        There is no log, or an item is not a path.
    DataError
        A manifest cannot be read, or the same columns of a log are assigned to two machines.
    """
    places = listed(logs)
    told = [each for place, one in enumerate(places, 1) for each in _items(one, out, place)]
    runs = ((item.log, log_of(item.log)) for item, _ in told)
    described = {
        *(os.path.abspath(item.log) for item, by in told if by != _BY_PATH),
        *(os.path.abspath(log) for run, log in runs if log != Path(run)),
    }
    found: dict[Hashable, tuple[FleetItem, str]] = {}
    for item, by in told:
        place = os.path.abspath(item.log)
        if by == _BY_PATH and place in described:
            continue
        before, by_before = found.setdefault((place, item.axis, item.columns_text), (item, by))
        for what in ("serial", "conditions"):
            first, second = getattr(before, what), getattr(item, what)
            if first != second:
                raise DataError(
                    f"{by_before} and {by} give different {what} of {item.log}: {_as_text(first)} "
                    f"and {_as_text(second)}. Remove one of the two. If the log contains several "
                    "machines, give each row its own columns.",
                    code="manifest",
                )
    if not found:
        raise UsageError(
            f"no log was found in {' and '.join(map(str, places)) or 'an empty list'}. Name logs, "
            "folders of logs, or manifests.",
            code="fleet",
        )
    return with_names([item for item, _ in found.values()])


def _as_text(told: str | Mapping[str, Condition]) -> str:
    """Return a serial number or conditions as text."""
    text = told if isinstance(told, str) else ", ".join(f"{k}={v}" for k, v in told.items())
    return quoted(text) if text else "none"


def _items(given: object, out: Path, place: int) -> Iterator[tuple[FleetItem, str]]:
    """Yield the logs that one argument names, each with a text that names where it was given.

    Parameters
    ----------
    given : object
        A FleetItem, or a path or pattern.
    out : Path
        Folder of the results.
    place : int
        Number of the argument, for messages.
    """
    if isinstance(given, FleetItem):
        yield given, f"item {place}"
        return
    if not isinstance(given, (str, Path)):
        raise UsageError(
            f"a log is {quoted(given)}. Give a path, a pattern, a folder or a FleetItem.",
            code="fleet",
        )
    path, files = Path(given), [Path(given)]
    if path.is_dir() and not (path / "metadata.yaml").is_file():  # a ROS 2 bag is one log
        files = [file for file in sorted(path.rglob("*")) if _may_be_log(file, out)]
        # A file of that name describes a log, even if it is wrong.
        runs = {f for f in files if f.name == "run.toml" or log_of(f) != f}
        files = [f for f in files if f.suffix.lower() in log_endings() or f in runs]
    elif not path.exists() and glob.has_magic(str(path)):
        named = map(Path, sorted(glob.glob(str(path), recursive=True)))
        files = [file for file in named if _may_be_log(file, out)]
    for file in files:
        if file.is_file() and _LOG in _heads_of(file):
            yield from _manifest_items(file)
        else:
            yield FleetItem(log=str(file)), _BY_PATH


def _may_be_log(file: Path, out: Path) -> bool:
    """Return whether a file may be a log: not hidden, not a result, not a table of results.

    A broken link may be a log; the reason is reported when it is read.
    """
    own = out.resolve() == file.parent.resolve() and (
        file.suffix == ".json" or file.stem == "fleet"
    )
    if file.name.startswith(".") or own or (file.exists() and not file.is_file()):
        return False
    try:
        return not kinds_of(file) - _LOGS
    except OSError:  # the reason is reported for the log
        return True
