"""Repairs of a log, and its run.toml, which is read, or written as a first draft.

A repair is made on request only, and reported with its number.
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
from axisid.support.wording import quoted

from .clocks import check_sample_period
from .segments import checked_windows
from .shifts_and_interpolation import Interpolation, checked_between, checked_shifts
from .wrapping import Modulus


@dataclass(frozen=True, slots=True, kw_only=True)
class Repairs:
    """Repairs of a log that is not a valid record as recorded.

    Attributes
    ----------
    resample : float, "auto" or None
        Resample to an even grid at this rate, Hz; ``auto`` uses the median rate of the position.
    gaps : {"split"} or None
        Cut the log where samples are missing; each piece is filtered and simulated separately.
    wrap : str, float, mapping of str to either, or None
        Modulus after which a position restarts, with a unit (``360:deg``), or in the column's own
        numbers. By role, moduli of other columns (``{"control": 65536}``, ``"control=65536"``)
        whose numbers were written without their sign, so that -1 is the modulus minus 1.
    mask : {"clipped"} or None
        Leave out samples of the control or the force that the limit of the drive or of a recorder
        has clipped, with all rows whose filters reach them.
    tail : {"drop"} or None
        Leave out lines at the end of a text file that are no rows: a truncated line, or a footer.
    shift : mapping of str to int, float or str
        Shift of a column to later times relative to the others, by role: samples, or a time with
        its unit (``"2ms"``). A shift by parts of a sample needs `resample`.
    between : mapping of str to {"spline", "linear", "held"}
        Interpolation by role of a measured velocity, acceleration or force that is written only in
        every few samples; the others are empty, or have the last value again.

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
        ways = (
            ("repair of gaps", self.gaps, ("split",)),
            ("mask", self.mask, ("clipped",)),
            ("repair of the end of the log", self.tail, ("drop",)),
        )
        check_among(*(row for row in ways if row[1] is not None))
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
            Scales from the column's own numbers to SI by role, if these differ. A modulus without a
            unit is in the column's own numbers.

        Raises
        ------
        UsageError
            A modulus is no positive number, has another unit than its column, or its column cannot
            be wrapped.
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

    Without a unit the number is in the column's own numbers, which `scale` converts to SI.
    """
    number, _, unit = text.partition(":")
    size = math.nan
    with suppress(ValueError):
        size = float(number)
    refuse(
        UsageError,
        (
            role in ("time", "reference"),
            f"wrap does not apply to the {role} alone. The reference is unwrapped with the "
            "position, and a time that restarts is cut with gaps",
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
    """Return the log that a run.toml names, if it can be read; any other file unchanged."""
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
    """Return the log that a run.toml names, and arguments of `read_record` for it.

    Parameters
    ----------
    file : Path
    axis : Axis or None
        Axis whose signals are further roles.
    columns : mapping
        Columns by role that replace those of the file.
    repairs : Repairs
        Repairs that replace those of the file.
    **given
        Further arguments of `read_record` that replace those of the file.

    Raises
    ------
    RunFileError
        The file cannot be read, or has mistakes, which are all listed.
    """
    log, said = read_toml(file, partial(_said, file.parent, axis), RunFileError)
    asked = {f.name: getattr(repairs, f.name) for f in fields(Repairs)}
    said |= {
        key: value
        for key, value in {**given, **asked}.items()
        if value is not None and (value or not isinstance(value, (tuple, Mapping)))
    }
    chosen = {key: said.pop(key) for key in [*said] if LOG_KEYS[key].is_repair}
    return log, {
        **said,
        "columns": {**said.get("columns", {}), **columns},
        "repairs": Repairs(**chosen),
    }


def _said(folder: Path, axis: Axis | None, table: TomlTable) -> tuple[Path, dict[str, Any]] | None:
    """Return the path of the log and the values of the keys of a run.toml; None for a wrong path.

    Mistakes are collected in `table`. `folder` is the folder of the file.
    """
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
    """Return the path of the log that a run.toml in a folder names; refuse a missing file."""
    if named is None:
        raise UsageError('it is missing. Add the path of the log, as in log = "log.csv".')
    if not isinstance(named, str) or is_run_file(named):
        raise UsageError(f"it is {quoted(named)}. Give the path of a log, relative to this file.")
    if not os.path.lexists(folder / named):
        names = [file.name for file in folder.iterdir()]
        raise UsageError(f"there is no file {folder / named}.{nearest(named, names)}")
    return folder / named


def _checked(
    table: TomlTable, key: str, value: Any, roles: Collection[str], axis: Axis | None
) -> Any:
    """Return the value of a key, checked as far as possible without the log."""
    if isinstance(value, Mapping):
        table.table(key).only(*roles)

    check = _CHECKS.get(key, lambda repair: Repairs(**{key: repair}).moduli(axis))
    table.attempt(key, partial(check, value))
    return value


_CHECKS: Mapping[str, Callable[[Any], object]] = {
    "windows": checked_windows,
    "injected_at": lambda place: check_among(("injection point", place, INJECTION_POINTS)),
    "sample_period": check_sample_period,
    "max_memory": partial(room_for, ""),
}


_LINE = 96  # characters of a comment
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
            f"the name of {quoted(log.name)} is not UTF-8, which TOML requires. Rename the log.",
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
        *(f"#   {_described(table, name)}" for name in [*table.columns][:100]),
        *([f"#   and {more} more"] if more > 0 else []),
        *(_role(table, role) for role in ROLES),
        "",
    ]
    return "\n".join(lines)


def _role(table: Table, role: str) -> str:
    """Return the line of a run.toml that names the column of a role, commented out.

    The line names a column of the log with the name of the role or a usual name of it, if there is
    one, and the unit of a time as far as its steps show it.
    """
    names = {**{name.casefold(): name for name in table.columns}, **{n: n for n in table.columns}}
    name = next((names[n] for n in (role, *_NAMES.get(role, ())) if n in names), None)
    # A column with the name of these roles need not be such a measurement.
    if name is None or role in ("velocity", "acceleration", "injected"):
        return f'# {role} = "NAME:UNIT"'
    unit = ""
    if role == "time" and not table.columns[name].unit:  # the unit with usual steps of a log
        time, units = _values(table, name), {"": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
        step = float(np.median(np.diff(time))) if time.size > 1 else 0.0
        unit = next((unit for unit, size in units.items() if 1e-6 < step * size < 0.05), "")
    guessed, ending = (f"  # {unit}: assumed from the time steps", f":{unit}") if unit else ("", "")
    if not name.isprintable() or len(name) >= _LINE:
        name = f"#{[*table.columns].index(name) + 1}"
    return f"# {role} = {toml_text(name + ending)}{guessed}"


def _described(table: Table, name: str) -> str:
    """Return a text on a column of a log: its name, the range of its numbers, and its unit."""
    column, values = table.columns[name], _values(table, name)
    finite = values[np.isfinite(values)]
    between = f"{finite.min():.6g} to {finite.max():.6g}" if finite.size else "no numbers"
    unit = f"in {column.unit}" if column.unit else "in SI unless a unit is given"
    held = column.holds or f"{between}, {unit if unit.isprintable() else ''}"
    return f"{toml_text(name[:_LINE])}: {held}"


def _values(table: Table, name: str) -> Array:
    """Return the numbers of a column, (N,); empty if it has none."""
    samples = table.columns[name].samples
    return np.empty(0) if isinstance(samples, DataError) else samples.values


def _comment(said: str) -> list[str]:
    """Return a text as comment lines of a TOML file."""
    return [f"# {line}" for line in wrap(said, _LINE)]
