"""The control law of a TOML declaration: one of the library, or a difference equation."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import sympy

from axisid.modeling.declaration import ControlLaw, Memory, gain
from axisid.modeling.laws import BLOCKS, LAWS, Block
from axisid.modeling.quantities import (
    BALANCED,
    LIMITED_OUTPUT,
    MEASURED_POSITION,
    MEASURED_VELOCITY,
    PERIOD,
    REFERENCE,
)

from .mistakes import nearest
from .toml_table import Symbols, Table, checked_name

_INPUTS = {str(s): s for s in (REFERENCE, MEASURED_POSITION, MEASURED_VELOCITY, PERIOD)}
_BETWEEN = "reference_between"


_OWN = ("name", "period", "output", "gains", "memory", "blocks", "delay", "continuous", _BETWEEN)


def read_control(root: Table, recorded: Symbols, constants: Symbols) -> ControlLaw | None:
    """The control law of the table ``control``, if there is one; wrong ones are mistakes.

    Parameters
    ----------
    root : Table
    recorded : mapping of str to sympy.Symbol
        The signals that it may read.
    constants : mapping of str to sympy.Symbol
        Those of the declaration, which it may have.
    """
    if "control" not in root.values:
        return None
    table = root.table("control")
    # The number pi is a number in a law.
    known = {name: symbol for name, symbol in constants.items() if name != "pi"}
    if "law" in table.values:
        return _shipped_law(table, {**known, **recorded})
    table.only(*_OWN)
    table.needs("name", "period", "output")
    gains, memory = table.table("gains"), table.table("memory")
    names = [*gains.values, *memory.values]
    for name in names:
        checked_name(gains if name in gains.values else memory, name, name, "it")
    symbols = {**known, **recorded, **_INPUTS, **{name: gain(name) for name in names}}
    blocks = _blocks(table.table("blocks"), symbols, known)
    symbols |= {name: block.value for name, block in blocks.items()}
    following = {**symbols, str(LIMITED_OUTPUT): LIMITED_OUTPUT}
    kept = [_memory(memory.table(name), name, following, known) for name in memory.values]
    kept += [each for block in blocks.values() for each in block.memory]
    fields = {
        "name": table.text("name"),
        "period": table.values.get("period", 1.0),
        "output": table.expression("output", symbols),
        "gains": {name: gains.number(name) for name in gains.values},
        "memory": kept,
        "delay": table.whole("delay", 0),
        "continuous": table.switch("continuous", default=False),
        _BETWEEN: table.text(_BETWEEN),
    }
    neutral = {"name": "law", "period": 1.0, "output": sympy.S.Zero}
    return table.made(ControlLaw, fields, neutral, apart=("period", "delay", _BETWEEN))


def _shipped_law(table: Table, symbols: Symbols) -> ControlLaw | None:
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
    table.only("law", *arguments, "delay", _BETWEEN)
    fields, neutral = _arguments(table, arguments, symbols)
    law = table.made(LAWS[name], fields, neutral, apart=("period",))
    if law is None:
        return None
    return _in_time(table, law)


def _in_time(table: Table, law: ControlLaw) -> ControlLaw | None:
    """The same with its delay, and with how the reference runs between samples."""
    late, between = table.whole("delay", 0), table.text(_BETWEEN)
    delayed = table.attempt("delay", lambda: replace(law, delay=late))
    if delayed is None:
        return None
    return table.attempt(_BETWEEN, lambda: replace(delayed, reference_between=between))


def _arguments(
    table: Table, arguments: Mapping[str, inspect.Parameter], symbols: Symbols
) -> tuple[dict[str, Any], dict[str, Any]]:
    """What the table has of a function's arguments, each by its kind, and what it would take."""
    needed = [key for key, value in arguments.items() if value.default is value.empty]
    table.needs(*needed)
    readers: dict[Any, Callable[[str], Any]] = {
        bool: lambda key: table.switch(key, default=False),
        str: table.text,
        float: table.number,
        float | None: table.number,
    }
    fields = {}
    for key in table.values:
        if key in arguments:
            reader = readers.get(arguments[key].annotation)
            fields[key] = reader(key) if reader else table.expression(key, symbols)
    return fields, dict.fromkeys(needed, 1.0)


def _blocks(table: Table, symbols: Symbols, constants: Symbols) -> dict[str, Block]:
    """The blocks that a law of one's own is made of, by name; each may read those before it."""
    found: dict[str, Block] = {}
    for name in table.values:
        checked_name(table, name, name, "it")
        if name in symbols:
            table.say(name, "the law has another symbol of this name; give one of them another.")
        inner = table.table(name)
        known = {**symbols, **{each: block.value for each, block in found.items()}}
        block = _block(inner, name, known, constants)
        if block is not None:
            found[name] = block
    return found


def _block(table: Table, name: str, symbols: Symbols, constants: Symbols) -> Block | None:
    kind = table.values.get("block")
    if not isinstance(kind, str) or kind not in BLOCKS:
        like = nearest(kind, BLOCKS) if isinstance(kind, str) else ""
        table.say("block", f"there is no block {kind!r}; there are {', '.join(BLOCKS)}.{like}")
        return None
    arguments = {
        key: value
        for key, value in inspect.signature(BLOCKS[kind]).parameters.items()
        if key not in ("name", "names")
    }
    table.only("block", *arguments)
    table.needs(*(key for key, value in arguments.items() if value.default is value.empty))
    fields: dict[str, Any] = {
        key: table.expression(key, _at_rest(constants) if key == "start" else symbols)
        for key in table.values
        if key in arguments
    }
    if not table.fine:
        return None
    memory = (
        {"names": (f"{name}1", f"{name}2")}
        if kind == "reference_acceleration"
        else {"name": f"{name}1"}
    )
    return table.attempt("", lambda: BLOCKS[kind](**fields, **memory))


def _at_rest(constants: Symbols) -> Symbols:
    """What the start of a memory may be made of."""
    starts = (MEASURED_POSITION, REFERENCE, BALANCED)
    return {**constants, **{str(symbol): symbol for symbol in starts}}


def _memory(table: Table, name: str, symbols: Symbols, constants: Symbols) -> Memory:
    table.only("following", "start")
    table.needs("following", "start")
    return Memory(
        name,
        following=table.expression("following", symbols),
        start=table.expression("start", _at_rest(constants)),
    )
