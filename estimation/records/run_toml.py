"""Repairs of a log, and the run.toml of a log, which is read or written as a first draft.

A repair is made on request only, and is reported with the number of changed samples.
"""

import math
import os
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, fields
from functools import partial
from pathlib import Path
from textwrap import wrap
from typing import Any, Literal

import numpy as np

from axisid.estimation.choices import LOG_KEYS
from axisid.estimation.logs import read_table
from axisid.estimation.raw_tables import Table
from axisid.estimation.records.columns import Scale, expected_units, to_si
from axisid.modeling.declaration import INJECTION_POINTS, ROLES, Axis
from axisid.modeling.parsing import TomlTable, nearest, read_columns, read_toml, toml_document
from axisid.modeling.quantities import settle
from axisid.support.arrays import Array
from axisid.support.checks import check_among, is_real, refuse
from axisid.support.errors import DataError, RunFileError, UsageError
from axisid.support.files import toml_text
from axisid.support.mappings import FrozenMapping
from axisid.support.memory import room_for
from axisid.support.settings import setting
from axisid.support.wording import quoted

from .clocks import check_sample_period
from .segments import checked_windows
from .shifts_and_interpolation import Interpolation, checked_between, checked_shifts
from .wrapping import Modulus


@dataclass(frozen=True, slots=True, kw_only=True)
class Repairs:
    """Repairs of a log that is not a valid record as recorded; none by default.

    Attributes
    ----------
    resample : float, "auto" or None
        Resample to an even grid at this rate, Hz; ``auto`` uses the median rate of the position.
    gaps : {"split"} or None
        Cut the log where samples are missing; each piece is filtered and simulated separately.
    wrap : str, float, mapping of str to either, or None
        Modulus after which a position restarts, with a unit (``360:deg``), or as a number as in the
        column. By role, moduli of other columns (``{"control": 65536}``, ``"control=65536"``)
        whose numbers were written without their sign, so that -1 is the modulus minus 1.
    mask : {"clipped"} or None
        Leave out samples of the control or the force that the limit of the drive or of a recorder
        has clipped, with all rows whose filters reach them.
    tail : {"drop"} or None
        Leave out lines at the end of a text file that are not rows: a truncated line, or a footer.
    shift : mapping of str to int, float or str
        Shift of a column to later times relative to other columns, by role: samples, or a time with
        its unit (``"2ms"``). A shift by parts of a sample needs `resample`.
    between : mapping of str to {"spline", "linear", "held"}
        Interpolation by role of a measured velocity, acceleration or force that is written only in
        every few samples; other samples are empty, or have the last value again.

    Raises
    ------
    UsageError
        A setting is not valid for any log.
    """

    resample: float | Literal["auto"] | None = None
    gaps: Literal["split"] | None = None
    wrap: str | float | Mapping[str, str | float] | None = None
    mask: Literal["clipped"] | None = None
    tail: Literal["drop"] | None = None
    shift: Mapping[str, Any] = field(default_factory=dict)
    between: Mapping[str, Interpolation] = field(default_factory=dict)

    def __post_init__(self) -> None:
        rate = self.resample
        if rate not in ("auto", None) and not (is_real(rate) and 0 < rate < math.inf):
            raise UsageError(f"the resampling rate is {quoted(rate)}. Give a rate in Hz, or auto.")
        choices = (
            ("repair of gaps", self.gaps, ("split",)),
            ("mask", self.mask, ("clipped",)),
            ("repair of the end of the log", self.tail, ("drop",)),
        )
        check_among(*(row for row in choices if row[1] is not None))
        settle(
            self,
            wrap=FrozenMapping(self.wrap) if isinstance(self.wrap, Mapping) else self.wrap,
            shift=FrozenMapping(checked_shifts(self.shift)),
            between=FrozenMapping(checked_between(self.between)),
        )

    def moduli(
        self, axis: Axis | None, scales: Mapping[str, Scale] | None = None
    ) -> dict[str, Modulus]:
        """Return the moduli after which columns restart, by role, from the attribute `wrap`.

        Parameters
        ----------
        axis : Axis or None
        scales : mapping of str to Scale, optional
            Scales from the numbers of the log to SI by role, if these differ. A modulus without a
            unit is a number as in the column.

        Raises
        ------
        UsageError
            A modulus is not a positive number, has another unit than its column, or its column
            cannot be wrapped.
        """
        given = self.wrap
        if isinstance(given, str) and "=" in given:
            pairs = (pair.partition("=") for pair in given.split(","))
            given = {role.strip(): modulus for role, _, modulus in pairs}
        elif given is not None and not isinstance(given, Mapping):
            given = {"position": given}
        known = scales or {}
        return {
            role: _modulus(role, str(text), axis, known.get(role, Scale()))
            for role, text in (given or {}).items()
        }


def _modulus(role: str, text: str, axis: Axis | None, scale: Scale) -> Modulus:
    """Return the modulus of a column from its text, such as ``360:deg``.

    A modulus without a unit is a number as in the column, which `scale` converts to SI.

    Raises
    ------
    UsageError
        The modulus is not a positive number, has another unit than the column, or the column cannot
        be wrapped.
    """
    number, _, unit = text.partition(":")
    size = math.nan
    with suppress(ValueError):
        size = float(number)
    refuse(
        UsageError,
        (
            role == "time",
            "wrap does not apply to the time. Cut a log whose time restarts "
            f"({setting('gaps', 'split')})",
            "wrap",
        ),
        (
            role == "reference",
            "wrap does not apply to the reference alone. Set wrap for the position, with which the "
            "reference is unwrapped",
            "wrap",
        ),
        (
            not 0 < size < math.inf,
            f"the modulus is {text!r}. Give a positive number in the unit of the column, or a "
            "number with its unit, as in 360:deg or 1:rev",
        ),
    )
    if unit:
        si, _ = to_si(role, np.array([size]), unit, axis, requested=True, source="the modulus")
        return Modulus(si=float(si[0]), factor=float(si[0]) / size, unit=unit.strip())
    factor = abs(scale.factor)
    usual = " or ".join(expected_units(role, axis)) if factor == 1.0 else ""
    return Modulus(si=factor * size, factor=factor, unit=usual)


def is_run_file(log: object) -> bool:
    """Return True if a file given as a log is a run.toml."""
    return isinstance(log, (str, Path)) and Path(log).suffix.lower() == ".toml"


def log_of(file: str | Path) -> Path:
    """Return the path of the log that a run.toml names; any other path unchanged.

    The path of a run.toml that cannot be read, or that names no log, is also returned unchanged.
    """
    with suppress(RunFileError):
        named = toml_document(Path(file), RunFileError).get("log") if is_run_file(file) else None
        if isinstance(named, str) and "\0" not in named:  # no path has a NUL
            return Path(file).parent / named
    return Path(file)


def read_run(
    file: Path,
    axis: Axis | None,
    *,
    columns: Mapping[str, Any],
    repairs: Repairs,
    **given: Any,
) -> tuple[Path, dict[str, Any]]:
    """Return the path of the log that a run.toml names, and the arguments of `read_record`.

    Parameters
    ----------
    file : Path
        Path of the run.toml.
    axis : Axis or None
        Axis whose signals are further roles; None if it is unknown.
    columns : mapping
        Given columns by role, which replace the columns in the file.
    repairs : Repairs
        Given repairs, which replace the repairs in the file.
    **given
        Further given arguments of `read_record`, which replace the values in the file; None or an
        empty tuple or mapping replaces nothing.

    Raises
    ------
    RunFileError
        The file cannot be read, or has mistakes, which are all listed.
    """
    log, arguments = read_toml(file, partial(_log_and_values, file.parent, axis), RunFileError)
    given_repairs = {f.name: getattr(repairs, f.name) for f in fields(Repairs)}
    arguments |= {
        key: value
        for key, value in {**given, **given_repairs}.items()
        if value is not None and (value or not isinstance(value, (tuple, Mapping)))
    }
    chosen = {key: arguments.pop(key) for key in [*arguments] if LOG_KEYS[key].is_repair}
    return log, {
        **arguments,
        "columns": {**arguments.get("columns", {}), **columns},
        "repairs": Repairs(**chosen),
    }


def _log_and_values(
    folder: Path, axis: Axis | None, table: TomlTable
) -> tuple[Path, dict[str, Any]] | None:
    """Return the path of the log and the values of the other keys of a run.toml.

    None if the path of the log is missing or wrong. Mistakes are collected in `table`.

    Parameters
    ----------
    folder : Path
        Folder of the run.toml.
    axis : Axis or None
        Axis whose signals are further roles; None if it is unknown.
    table : TomlTable
        Content of the run.toml.
    """
    table.only("log", *LOG_KEYS)
    roles = ROLES if axis is None else axis.roles
    values: dict[str, Any] = {}
    for key, value in table.values.items():
        if key == "columns":
            values[key] = read_columns(table.table(key), roles)
        elif key in LOG_KEYS:
            values[key] = _checked_value(table, key, value, roles, axis)
    log = table.attempt("log", partial(_log_path, folder, table.values.get("log")))
    return None if log is None else (log, values)


def _log_path(folder: Path, named: object) -> Path:
    """Return the path of the log that a run.toml in a folder names; refuse a missing file."""
    if named is None:
        raise UsageError('the path of the log is missing. Add the path, as in log = "log.csv".')
    if not isinstance(named, str) or is_run_file(named):
        raise UsageError(
            f"the path of the log is {quoted(named)}. Give the path of a log, relative to this "
            "file."
        )
    if not os.path.lexists(folder / named):
        names = [file.name for file in folder.iterdir()]
        raise UsageError(
            f"there is no file {folder / named}. Correct the path.{nearest(named, names)}"
        )
    return folder / named


def _checked_value(
    table: TomlTable, key: str, value: Any, roles: Collection[str], axis: Axis | None
) -> Any:
    """Return the value of a key, checked as far as possible without the log.

    Mistakes are collected in `table`. `roles` are the roles that a value by role may have.
    """
    if isinstance(value, Mapping):
        table.table(key).only(*roles)

    def check_repair(repair: Any) -> object:
        """Return the moduli of a repair; refuse a wrong repair."""
        return Repairs(**{key: repair}).moduli(axis)

    table.attempt(key, partial(_CHECKS.get(key, check_repair), value))
    return value


#: Checks of the keys that are not repairs; a check raises an error for a wrong value.
_CHECKS: Mapping[str, Callable[[Any], object]] = {
    "windows": checked_windows,
    "injected_at": lambda place: check_among(("injection point", place, INJECTION_POINTS)),
    "sample_period": check_sample_period,
    "max_memory": partial(room_for, ""),
}


_LINE = 96  # largest number of characters in a line of a comment
#: Usual names of columns, besides their roles.
_NAMES = {
    "time": ("t", "timestamp", "time_s", "time_ms", "seconds", "zeit"),
    "position": ("pos", "q", "actual_position", "position_actual"),
    "reference": ("ref", "setpoint", "q_ref", "pos_ref", "position_reference", "position_command"),
    "control": ("u", "control_signal", "command"),
}


def started_run(log: Path) -> str:
    """Return the text of a first run.toml for a log, with a comment for each key and each role.

    All keys except `log` are commented out, as the axis may already name the columns.

    Raises
    ------
    DataError
        The log cannot be read, or its name is not UTF-8.
    """
    table = read_table(log)
    if any("\ud800" <= letter <= "\udfff" for letter in log.name):
        raise DataError(
            f"the name of the log {quoted(log.name)} is not UTF-8, which TOML requires. Rename the "
            "log.",
            code="run-file",
        )
    keys = [
        line
        for key in LOG_KEYS.values()
        if key.name != "columns"
        for line in ("", *_comment(key.said), f"# {key.name} = {key.example}")
    ]
    more = len(table.columns) - 100
    lines = [
        *_comment(
            "Description of a log. Give this file instead of the log: axisid identify AXIS "
            "run.toml. Remove the # from the lines that you need."
        ),
        "",
        f"log = {toml_text(log.name)}",
        *keys,
        "",
        "# Keep all keys except columns above this line.",
        "[columns]",
        *_comment(LOG_KEYS["columns"].said),
        *_comment("The log has:"),
        *(f"#   {_column_description(table, name)}" for name in [*table.columns][:100]),
        *([f"#   and {more} more"] if more > 0 else []),
        *(_role_line(table, role) for role in ROLES),
        "",
    ]
    return "\n".join(lines)


def _role_line(table: Table, role: str) -> str:
    """Return the line of a run.toml that names the column of a role, commented out.

    If the log has a column with the name of the role, or with a usual name of the role, the line
    names this column. The unit of a time without a unit is assumed from its steps.
    """
    # The column of the role; upper and lower case are equal unless the log distinguishes them.
    names = {**{name.casefold(): name for name in table.columns}, **{n: n for n in table.columns}}
    name = next((names[n] for n in (role, *_NAMES.get(role, ())) if n in names), None)
    # A column with the name of these roles need not be such a measurement.
    if name is None or role in ("velocity", "acceleration", "injected"):
        return f'# {role} = "NAME:UNIT"'
    unit = ""
    if role == "time" and not table.columns[name].unit:
        # The first unit in which the time steps have the usual size of a log: 1 us to 50 ms.
        time, units = _values(table, name), {"": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
        step = float(np.median(np.diff(time))) if time.size > 1 else 0.0
        unit = next((unit for unit, size in units.items() if 1e-6 < step * size < 0.05), "")
    guessed, ending = (f"  # {unit}: assumed from the time steps", f":{unit}") if unit else ("", "")
    if not name.isprintable() or len(name) >= _LINE:
        name = f"#{[*table.columns].index(name) + 1}"
    return f"# {role} = {toml_text(name + ending)}{guessed}"


def _column_description(table: Table, name: str) -> str:
    """Return a text on a column of a log: its name, the range of its numbers, and its unit."""
    column, values = table.columns[name], _values(table, name)
    finite = values[np.isfinite(values)]
    between = f"{finite.min():.6g} to {finite.max():.6g}" if finite.size else "no numbers"
    unit = f"in {column.unit}" if column.unit else "in SI unless a unit is given"
    content = column.holds or f"{between}, {unit if unit.isprintable() else ''}"
    return f"{toml_text(name[:_LINE])}: {content}"


def _values(table: Table, name: str) -> Array:
    """Return the numbers of a column, (N,); empty if it has none."""
    samples = table.columns[name].samples
    return np.empty(0) if isinstance(samples, DataError) else samples.values


def _comment(text: str) -> list[str]:
    """Return a text as comment lines of a TOML file."""
    return [f"# {line}" for line in wrap(text, _LINE)]
