"""The control law of a TOML declaration: one of the library, or a difference equation."""

import inspect
from dataclasses import replace
from typing import Any

import sympy

from axisid.modeling.declaration import LAWS, ControlLaw, Memory, gain
from axisid.modeling.quantities import (
    BALANCED,
    MEASURED_POSITION,
    MEASURED_VELOCITY,
    PERIOD,
    REFERENCE,
)

from .mistakes import nearest
from .toml_table import Symbols, Table, checked_name

_INPUTS = {str(s): s for s in (REFERENCE, MEASURED_POSITION, MEASURED_VELOCITY, PERIOD)}
_BETWEEN = "reference_between"


def read_control(root: Table, recorded: Symbols) -> ControlLaw | None:
    """The control law of the table ``control``, if there is one; wrong ones are mistakes.

    Parameters
    ----------
    root : Table
    recorded : mapping of str to sympy.Symbol
        The signals that it may read.
    """
    if "control" not in root.values:
        return None
    table = root.table("control")
    if "law" in table.values:
        return _shipped_law(table)
    table.only("name", "period", "output", "gains", "memory", "delay", "continuous", _BETWEEN)
    table.needs("name", "period", "output")
    gains, memory = table.table("gains"), table.table("memory")
    names = [*gains.values, *memory.values]
    for name in names:
        checked_name(gains if name in gains.values else memory, name, name, "it")
    symbols = {**recorded, **_INPUTS, **{name: gain(name) for name in names}}
    fields = {
        "name": table.text("name"),
        "period": table.values.get("period", 1.0),
        "output": table.expression("output", symbols),
        "gains": {name: gains.number(name) for name in gains.values},
        "memory": [_memory(memory.table(name), name, symbols) for name in memory.values],
        "delay": table.whole("delay", 0),
        "continuous": table.switch("continuous", default=False),
        _BETWEEN: table.text(_BETWEEN),
    }
    neutral = {"name": "law", "period": 1.0, "output": sympy.S.Zero}
    return table.made(ControlLaw, fields, neutral, apart=("period", "delay", _BETWEEN))


def _shipped_law(table: Table) -> ControlLaw | None:
    """A law of the library by its name, with the arguments of its function."""
    name = table.values["law"]
    if not isinstance(name, str) or name not in LAWS:
        like = nearest(name, LAWS) if isinstance(name, str) else ""
        table.say(
            "law",
            f"there is no law {name!r}; there are {', '.join(LAWS)}, or leave out the law and "
            f"write its output.{like}",
        )
        return None
    arguments = inspect.signature(LAWS[name]).parameters
    table.only("law", *arguments, _BETWEEN)
    table.needs(*(key for key, value in arguments.items() if value.default is value.empty))
    fields: dict[str, Any] = {
        key: table.switch(key, default=False)
        if isinstance(arguments[key].default, bool)
        else table.number(key)
        for key in table.values
        if key in arguments
    }
    neutral = {key: 1.0 for key, value in arguments.items() if value.default is value.empty}
    law = table.made(LAWS[name], fields, neutral, apart=("period",))
    if law is None:
        return None
    return table.attempt(_BETWEEN, lambda: replace(law, reference_between=table.text(_BETWEEN)))


def _memory(table: Table, name: str, symbols: Symbols) -> Memory:
    table.only("following", "start")
    table.needs("following", "start")
    at_rest = {str(symbol): symbol for symbol in (MEASURED_POSITION, REFERENCE, BALANCED)}
    return Memory(
        name,
        following=table.expression("following", symbols),
        start=table.expression("start", at_rest),
    )
