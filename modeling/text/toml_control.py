"""The control law of a TOML declaration: one of the library, or a difference equation."""

import inspect
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

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

from .toml_table import Symbols, Table, checked_name

_INPUTS = {str(s): s for s in (REFERENCE, MEASURED_POSITION, MEASURED_VELOCITY, PERIOD)}
_AT_REST = {str(s): s for s in (MEASURED_POSITION, REFERENCE, BALANCED)}


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
    gains, memory = table.table("gains"), table.table("memory")
    for part in (gains, memory):
        for name in part.values:
            part.attempt(name, partial(checked_name, name, "it"))
    names = (*gains.values, *memory.values)
    symbols = {**known, **recorded, **_INPUTS, **{name: gain(name) for name in names}}
    at_rest = {**known, **_AT_REST}
    blocks = _blocks(table.table("blocks"), symbols, at_rest)
    symbols |= {name: block.value for name, block in blocks.items()}
    following = {**symbols, str(LIMITED_OUTPUT): LIMITED_OUTPUT}
    kept = memory.each(Memory, symbols=following, own={"start": at_rest})
    inside = [each for block in blocks.values() for each in block.memory]
    # What is wrong of a gain or a memory has been told, and a gain of 1 stands for it.
    wrong = (name for name in names if kept.get(name) is None)
    given = {
        "gains": {**dict.fromkeys(wrong, 1.0), **gains.read_all(float)},
        "memory": [*filter(None, kept.values()), *inside],
        "positive": (),
    }
    return table.made(ControlLaw, symbols, given=given, beside=("gains", "memory", "blocks"))


def _shipped_law(table: Table, symbols: Symbols) -> ControlLaw | None:
    """A law of the library by its name, with the arguments of its function and its timing."""
    hint = ", or leave out the law and write its output"
    law = table.chosen("law", LAWS, "law", hint)
    if law is None:
        return None
    of_any = inspect.signature(ControlLaw).parameters
    timing = {key: of_any[key] for key in ("delay", "reference_between")}

    def in_time(**fields: Any) -> ControlLaw:
        late = {key: fields.pop(key) for key in timing if key in fields}
        return replace(law(**fields), **late)

    arguments = {**inspect.signature(law).parameters, **timing}
    return table.made(in_time, symbols, arguments=arguments, beside=("law",))


def _blocks(table: Table, symbols: Symbols, at_rest: Symbols) -> dict[str, Block]:
    """The blocks that a law of one's own is made of, by name; each may read those before it."""
    found: dict[str, Block] = {}
    for name in table.values:
        table.attempt(name, partial(checked_name, name, "it"))
        if name in symbols:
            table.say(name, "the law has another symbol of this name; give one of them another.")
        inner = table.table(name)
        make: Callable[..., Block] | None = inner.chosen("block", BLOCKS, "block")
        if make is None:
            continue
        several = "names" in inspect.signature(make).parameters
        given = {"names": (f"{name}1", f"{name}2")} if several else {"name": f"{name}1"}
        known = {**symbols, **{each: block.value for each, block in found.items()}}
        own = {"start": at_rest}
        block = inner.made(make, known, given=given, beside=("block",), own=own)
        found |= {} if block is None else {name: block}
    return found
