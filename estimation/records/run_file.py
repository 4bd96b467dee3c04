"""A run.toml: what is said of a log, in a file that stands in the log's place."""

import os
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import Any

from axisid.estimation.choices import LOG_KEYS, check_among
from axisid.modeling.declaration import INJECTION_POINTS, ROLES, Axis
from axisid.modeling.text import Table, nearest, read_columns, read_toml, toml_document
from axisid.support.errors import RunFileError, UsageError, quoted
from axisid.support.memory import room_for

from .clocks import check_sample_period
from .repairs import Repairs
from .windows import checked_windows

_ENDING = ".toml"  # that of no format of logs


def is_run_file(log: object) -> bool:
    """Whether what stands in the place of a log says what the log is."""
    return isinstance(log, (str, Path)) and Path(log).suffix.lower() == _ENDING


def log_of(file: str | Path) -> Path:
    """The log that a run.toml names, as far as it can be told; any other file itself."""
    named = None
    if is_run_file(file):
        with suppress(RunFileError):
            named = toml_document(Path(file), RunFileError).get("log")
    # No path has a NUL.
    told = isinstance(named, str) and "\0" not in named
    return Path(file).parent / str(named) if told else Path(file)


def read_run(
    file: Path,
    axis: Axis | None,
    *,
    columns: Mapping[str, Any],
    repairs: Repairs,
    **given: Any,
) -> tuple[Path, dict[str, Any]]:
    """The log that a run.toml names, and arguments of `read_record` for it.

    Parameters
    ----------
    file : Path
    axis : Axis or None
        Whose signals are roles of columns too.
    columns : mapping
        What goes role by role before what the file says.
    repairs : Repairs
        What goes one by one before it.
    **given
        Further arguments of `read_record`, likewise.

    Raises
    ------
    RunFileError
        It cannot be read, or with all that is wrong in it.
    """
    log, said = read_toml(file, partial(_said, file.parent, axis), RunFileError)
    said |= {
        key: value
        for key, value in given.items()
        if not (value is None or (isinstance(value, tuple) and not value))
    }
    own = {key: said.pop(key) for key in [*said] if LOG_KEYS[key].is_repair}
    asked = {f.name: getattr(repairs, f.name) for f in fields(Repairs)}
    own |= {name: value for name, value in asked.items() if value not in (None, {})}
    joined = {**said.get("columns", {}), **columns}
    return log, {**said, "columns": joined, "repairs": Repairs(**own)}


def _said(folder: Path, axis: Axis | None, table: Table) -> tuple[Path, dict[str, Any]] | None:
    """The log, and the values of the keys that are there."""
    table.only("log", *LOG_KEYS)
    roles = ROLES if axis is None else axis.roles
    said = {
        key: read_columns(table.table(key), roles)
        if key == "columns"
        else _checked(table, key, value, roles, axis)
        for key, value in table.values.items()
        if key in LOG_KEYS
    }
    log = table.attempt("log", partial(_log, folder, table.values.get("log")))
    return None if log is None else (log, said)


def _log(folder: Path, named: object) -> Path:
    if named is None:
        raise UsageError('it is missing; add the log\'s path, as in log = "log.csv".')
    if not isinstance(named, str) or is_run_file(named):
        raise UsageError(f"it is {quoted(named)}; give the path of a log, as from this file.")
    if not os.path.lexists(folder / named):
        there = [file.name for file in folder.iterdir()]
        raise UsageError(f"there is no file {folder / named}.{nearest(named, there)}")
    return folder / named


def _checked(table: Table, key: str, value: Any, roles: Collection[str], axis: Axis | None) -> Any:
    """A value that is one of its key's, as far as that can be told without the log."""
    if isinstance(value, Mapping):
        table.table(key).only(*roles)

    def check() -> Any:
        _ = _CHECKS[key](value) if key in _CHECKS else Repairs(**{key: value}).moduli(axis)
        return value

    return table.attempt(key, check)


_CHECKS: Mapping[str, Callable[[Any], object]] = {
    "windows": checked_windows,
    "injected_at": lambda place: check_among(("place of a test signal", place, INJECTION_POINTS)),
    "sample_period": check_sample_period,
    "max_memory": partial(room_for, ""),
}
