"""The drive of a TOML declaration: a gain, a motor of its data sheet, or two formulas."""

import inspect
from collections.abc import Mapping
from typing import Any

from axisid.modeling.declaration import DRIVE_GAIN, HIDDEN_FROM, Drive
from axisid.modeling.drives import DRIVES, formula_drive
from axisid.modeling.quantities import CONTROL, FORCE

from .mistakes import nearest
from .toml_table import Symbols, Table, read_parameter

_GAIN = "gain"
_OF_COMMANDS = ("rate_limit", "quantisation", "deadband")
_SHARED = ("unit", "limit", "relative_sd", "delay", "logged", *_OF_COMMANDS)
_LAG = "lag"
_DRIVEN_BY = ("profile", "scaled_by")
_FORMULAS = ("force", "inverse")


def read_drive(root: Table, symbols: Symbols) -> Drive | None:
    """The drive of the table ``drive``, if there is one; wrong ones are mistakes.

    Parameters
    ----------
    root : Table
    symbols : mapping of str to sympy.Symbol
        Constants, recorded signals and the motion.
    """
    if "drive" not in root.values:
        return None
    table = root.table("drive")
    if "kind" in table.values:
        return _ready_drive(table, symbols)
    if any(key in table.values for key in _FORMULAS):
        return _formula_drive(table, symbols)
    keys = (_GAIN, *_SHARED, _LAG)
    table.only(*keys, *_DRIVEN_BY, "kind", *_FORMULAS)
    table.needs(_GAIN)
    fields = _plain(table, keys) | _expressions(table, _DRIVEN_BY, symbols)
    for key in HIDDEN_FROM:
        if isinstance(table.values.get(key), Mapping):
            time = read_parameter(table, key, unit="s")
            # What is wrong with a table is said of it, and not of the drive too.
            fields |= {key: 0.0 if time is None else time}
    # Where the control was logged is told by lag and delay, so that it is not tried alone.
    alone = [key for key in keys if key != "logged"]
    return table.made(Drive, fields, {_GAIN: 1.0}, apart=alone)


def _ready_drive(table: Table, symbols: Symbols) -> Drive | None:
    """A drive of the library by its name, with the arguments of its function."""
    name = table.values["kind"]
    if not isinstance(name, str) or name not in DRIVES:
        like = nearest(name, DRIVES) if isinstance(name, str) else ""
        table.say(
            "kind",
            f"there is no drive {name!r}; there are {', '.join(DRIVES)}, or leave out the kind "
            f"and give a gain, or force and inverse.{like}",
        )
        return None
    parameters = inspect.signature(DRIVES[name]).parameters.values()
    own = [p for p in parameters if p.kind is not p.VAR_KEYWORD]
    # What it makes itself is among the keys, so that it is said of what it is made.
    keys = dict.fromkeys((*(p.name for p in own), *_SHARED, _GAIN, _LAG))
    table.only("kind", *keys, *_DRIVEN_BY)
    table.needs(*(p.name for p in own if p.default is p.empty))
    given = [key for key in keys if key in table.values]
    named = [key for key in given if table.values[key] in symbols] if symbols else []
    expressions = ("reach", *(key for key in named if key not in ("unit", "logged")))
    fields = _plain(table, [key for key in given if key not in expressions])
    fields |= _expressions(table, (*expressions, *_DRIVEN_BY), symbols)
    return table.made(DRIVES[name], fields, {})


def _formula_drive(table: Table, symbols: Symbols) -> Drive | None:
    keys = (_GAIN, *_SHARED, _LAG)
    table.only(*_FORMULAS, *keys, "profile")
    table.needs("force")
    gain = {str(DRIVE_GAIN): DRIVE_GAIN}
    fields = _plain(table, keys) | _expressions(table, ("profile",), symbols)
    for key, given in zip(_FORMULAS, (CONTROL, FORCE), strict=True):
        fields |= _expressions(table, (key,), {**symbols, **gain, str(given): given})
    return table.made(formula_drive, fields, {})


def _plain(table: Table, keys: Any) -> dict[str, Any]:
    return {key: table.values[key] for key in keys if key in table.values}


def _expressions(table: Table, keys: Any, symbols: Symbols) -> dict[str, Any]:
    return {key: table.expression(key, symbols) for key in keys if key in table.values}
