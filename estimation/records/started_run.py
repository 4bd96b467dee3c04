"""A run.toml to start from: what was found in a log, and a comment for each key."""

import json
from pathlib import Path
from textwrap import wrap

import numpy as np

from axisid.estimation.choices import LOG_KEYS
from axisid.estimation.logs import read_table
from axisid.estimation.tables import Table
from axisid.modeling.declaration import ROLES
from axisid.support.arrays import Array
from axisid.support.errors import DataError, quoted

_MOST = 100  # columns that are listed
_LINE = 96  # letters of a comment
#: Names by which columns are known beside those of their roles.
_NAMES = {
    "time": ("t", "timestamp", "time_s", "time_ms", "seconds", "zeit"),
    "position": ("pos", "q", "actual_position", "position_actual"),
    "reference": ("ref", "setpoint", "q_ref", "pos_ref", "position_reference", "position_command"),
    "control": ("u", "control_signal", "command"),
}
_ON_REQUEST = ("velocity", "acceleration", "injected")  # what only bears such a name is left out
_STEPS = (1e-6, 0.05)  # s, between which the step of a log is likely
_UNITS = {"": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


def started_run(log: Path) -> str:
    """The text of a run.toml beside a log: a comment for each key, of roles with what was found.

    Nothing of it is in force until its # is taken away: the axis may know the columns already.

    Raises
    ------
    DataError
        The log cannot be read, or its name is no text.
    """
    table = read_table(log)
    if any("\ud800" <= letter <= "\udfff" for letter in log.name):
        raise DataError(
            f"the name of {quoted(log.name)} is not UTF-8, as TOML has to be; give it another.",
            code="run-file",
        )
    lines = _comment(
        "What is said of a log. This file stands in its place: axisid identify AXIS run.toml. Take "
        "the # away from what is wanted."
    )
    lines += ["", f"log = {_quoted(log.name)}"]
    for key in LOG_KEYS.values():
        if key.name != "columns":
            lines += ["", *_comment(key.said), f"# {key.name} = {key.example}"]
    lines += [
        "",
        "# All but columns stands above this line.",
        "[columns]",
        *_comment(LOG_KEYS["columns"].said),
        *_comment("The log has:"),
    ]
    lines += [f"#   {_described(table, name)}" for name in [*table.columns][:_MOST]]
    lines += [f"#   and {more} more"] if (more := len(table.columns) - _MOST) > 0 else []
    return "\n".join([*lines, *(_role(table, role) for role in ROLES), ""])


def _role(table: Table, role: str) -> str:
    """The line of a role, in which a column is proposed if one has its name."""
    known = {name.casefold(): name for name in table.columns}
    known |= {name: name for name in table.columns}
    wanted = () if role in _ON_REQUEST else (role, *_NAMES.get(role, ()))
    name = next((known[each] for each in wanted if each in known), None)
    if name is None:
        return f'# {role} = "NAME:UNIT"'
    guessed = role == "time" and not table.columns[name].unit
    unit = _guessed(_values(table, name)) if guessed else ""
    said, ending = (f"  # {unit} is guessed from its steps", f":{unit}") if unit else ("", "")
    return f"# {role} = {_quoted(_called(table, name) + ending)}{said}"


def _called(table: Table, name: str) -> str:
    """A column's name, or its number where that cannot be written in one line."""
    return (
        name if name.isprintable() and len(name) < _LINE else f"#{[*table.columns].index(name) + 1}"
    )


def _described(table: Table, name: str) -> str:
    values, unit = _values(table, name), table.columns[name].unit
    finite = values[np.isfinite(values)]
    between = f"{finite.min():.6g} to {finite.max():.6g}" if finite.size else "no numbers"
    said = f"in {unit}" if unit else "in SI unless a unit is said"
    return f"{_quoted(name[:_LINE])}: {between}, {said if unit.isprintable() else ''}"


def _values(table: Table, name: str) -> Array:
    try:
        return np.asarray(table.columns[name].read().values, dtype=np.float64)
    except DataError:
        return np.empty(0)


def _guessed(time: Array) -> str:
    """The unit in which the steps of a time are those of a log; empty for seconds."""
    step = float(np.median(np.diff(time))) if time.size > 1 else 0.0
    low, high = _STEPS
    return next((unit for unit, size in _UNITS.items() if low < step * size < high), "")


def _comment(said: str) -> list[str]:
    return [f"# {line}" for line in wrap(said, _LINE)]


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
