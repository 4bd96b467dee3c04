"""The drive of a TOML declaration: a gain, a motor of its data sheet, or two formulas."""

import inspect
from collections.abc import Callable, Mapping
from functools import partial

from axisid.modeling.declaration import DRIVE_GAIN, HIDDEN_FROM, Drive
from axisid.modeling.drives import DRIVES, formula_drive
from axisid.modeling.quantities import CONTROL, FORCE, Parameter

from .toml_table import Symbols, Table

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
    make: Callable[..., Drive] | None = Drive
    if "kind" in table.values:
        hint = ", or leave out the kind and give a gain, or force and inverse"
        make = table.chosen("kind", DRIVES, "drive", hint)
    elif any(key in table.values for key in _FORMULAS):
        make = formula_drive
    if make is None:
        return None
    times = {
        key: table.table(key).made(partial(Parameter, unit="s"), name=key)
        for key in HIDDEN_FROM
        if isinstance(table.values.get(key), Mapping)
    }
    # What is wrong with a table is said of it, and not of the drive too.
    given = {key: 0.0 if time is None else time for key, time in times.items()}
    formulas = {**symbols, str(DRIVE_GAIN): DRIVE_GAIN}
    return table.made(
        make,
        symbols,
        arguments=_arguments(make),
        given=given,
        beside=("kind", *_FORMULAS, *given) if make is Drive else ("kind", *given),
        own={
            "force": {**formulas, str(CONTROL): CONTROL},
            "inverse": {**formulas, str(FORCE): FORCE},
        },
    )


def _arguments(make: Callable[..., Drive]) -> dict[str, inspect.Parameter]:
    """What a drive is told, with what it hands on to `Drive`, of which none is needed.

    What it makes itself is among these, so that it is said of what it is made.
    """
    own = inspect.signature(make).parameters
    shared = dict(inspect.signature(Drive).parameters)
    if make is not Drive:
        shared = {key: each.replace(default=None) for key, each in shared.items()}
    unused = ("estimated", "scaled_by") if make is formula_drive else ("estimated",)
    return {key: each for key, each in {**shared, **own}.items() if key not in (*unused, "others")}
