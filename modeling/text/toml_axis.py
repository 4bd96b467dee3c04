"""Declare an axis in TOML: the same as in Python, as data. Nothing in the file is run.

Expressions are text, read by `read_expression`. All mistakes of a file are told at once.
"""

import math
import re
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import sympy

from axisid.modeling.declaration import (
    ROLES,
    Axis,
    Column,
    Drive,
    Experiment,
    Move,
    back_and_forth,
    lagrange,
    newton,
)
from axisid.modeling.quantities import (
    TIME,
    Constant,
    Coordinate,
    G,
    Parameter,
    Signal,
    SignalSymbol,
    State,
    check_symbol,
    parse_unit,
    several,
    signals_in,
)
from axisid.support.errors import DeclarationError, ModelError

from .element_calls import ElementCalls
from .toml_control import read_control
from .toml_drive import read_drive
from .toml_table import Symbols, Table, checked_name, read_parameter

_LARGEST_FILE, _LONGEST_LINE = 50_000, 2500
_COLUMN = ("name", "unit", "scale", "offset", "gear", "resolution")
_PARTS = (
    "coordinate",
    "parameters",
    "constants",
    "signals",
    "states",
    "drive",
    "control",
    "columns",
    "experiment",
)
_FORCE = "generalised_force"
_ENERGIES = ("kinetic", "potential", "dissipation", _FORCE)


def axis_from_toml(file: Path) -> Axis:
    """Return the axis that a TOML file declares.

    Raises
    ------
    DeclarationError
        The file cannot be read, or with all that is wrong in it.
    """
    mistakes: list[str] = []
    axis = _axis(Table("", _document(file), mistakes))
    if axis is None or mistakes:
        count = "a mistake" if len(mistakes) == 1 else f"{len(mistakes)} mistakes"
        raise DeclarationError(f"{file} has {count}:", mistakes)
    return axis


def _document(file: Path) -> dict[str, Any]:
    text = _text(file)
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        place = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
        lines = text.splitlines()
        pointer = []
        if place and int(place[1]) <= len(lines):
            line, column = lines[int(place[1]) - 1], int(place[2]) - 1
            start = max(0, column - 40)
            shown = "".join(c if c.isprintable() else " " for c in line[start : start + 80])
            pointer = [f"{shown}\n{' ' * (column - start)}^"]
        what = "it is nested too deeply" if isinstance(error, RecursionError) else str(error)
        hint = " (text and expressions stand in quotes)" if "Invalid value" in what else ""
        raise DeclarationError(f"{file} is not valid TOML: {what}{hint}.", pointer) from error


def _text(file: Path) -> str:
    try:
        with file.open("rb") as stream:
            content = stream.read(_LARGEST_FILE + 1)
    except OSError as error:
        raise ModelError(f"{file} cannot be read: {error.strerror}.") from error
    if len(content) > _LARGEST_FILE:
        raise ModelError(
            f"{file} is larger than a declaration may be, {_LARGEST_FILE} bytes.",
            code="declaration-size",
        )
    try:
        text = content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise ModelError(
            f"{file} is not UTF-8 text: see byte 0x{content[error.start]:02x} in line {line}. Save "
            "it as UTF-8.",
            code="declaration-encoding",
        ) from error
    for i, line_text in enumerate(text.split("\n"), 1):
        if len(line_text) > _LONGEST_LINE:
            raise ModelError(
                f"{file}: line {i} is longer than {_LONGEST_LINE} characters.",
                code="declaration-line",
            )
    return text


def _axis(root: Table) -> Axis | None:
    """The axis, or None and mistakes; each part is read whatever is wrong with the others."""
    root.only("name", "title", *_PARTS[:5], "newton", "lagrange", *_PARTS[5:])
    root.needs("name", "coordinate", "parameters", "drive")
    name = checked_name(root, "name", root.values.get("name", "axis"), "the axis")
    coordinate, moving = _coordinate(root)
    parameters, unknown = _parameters(root)
    signals, recorded = _signals(root)
    others = {**dict.fromkeys(unknown, "parameter"), **dict.fromkeys(recorded, "signal")}
    constants = _constants(root, others, list(moving))
    fields = {
        "name": name or "axis",
        "title": root.text("title"),
        "coordinate": coordinate,
        "parameters": parameters,
        "signals": signals,
    }
    elements = ElementCalls(coordinate or _stand_in(moving))
    remembered = _states(root, {**constants, **unknown, **moving})
    symbols = {**constants, **unknown, **recorded, **remembered, **moving} if moving else None
    dynamics = _dynamics(root, symbols, elements)
    drive = read_drive(root, {**constants, **recorded, **moving}) or Drive(gain=1.0)
    parts = {
        "drive": drive,
        "control": read_control(root, recorded, constants),
        "columns": _columns(root, list(recorded)),
        "injected_at": _injected_at(root),
        "experiment": _experiment(root, list(unknown), list(recorded)),
    }
    if coordinate is None or parameters is None or signals is None or dynamics is None:
        return None
    declare, energies = dynamics
    axis = root.attempt("", lambda: declare(**fields, **energies, **parts))
    if axis is not None:
        _check_states(root, axis)
    if axis is None and parts["control"] is not None:
        # A name that the control law shares hides what is wrong with the equation of motion.
        mistake = root.mistakes.pop()
        alone = {**fields, "signals": _standing_in(signals, energies, drive)}
        root.attempt("", lambda: declare(**alone, **energies, drive=drive))
        root.mistakes += [mistake] if mistake not in root.mistakes else []
    return axis


def _standing_in(
    signals: tuple[Signal, ...], energies: Mapping[str, Any], drive: Drive
) -> tuple[Signal, ...]:
    """The signals without those that the control law alone may have."""
    values = [value for entry in energies.values() for value in several(entry)]
    used = signals_in(*values, drive.force, drive.profile)
    return tuple(signal for signal in signals if signal.symbol in used)


def _coordinate(root: Table) -> tuple[Coordinate | None, Symbols]:
    """The coordinate, and the symbols of its motion even where its unit is wrong."""
    if "coordinate" not in root.values:
        return None, {}
    table = root.table("coordinate")
    table.only("name", "unit")
    table.needs("name")
    name = table.values.get("name", "x")
    checked = checked_name(table, "name", name, "the coordinate", check_symbol)
    fields = {key: value for key, value in table.values.items() if key in ("name", "unit")}
    coordinate = table.made(Coordinate, fields, {"name": checked or "x"}, apart=("unit",))
    if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z]\w{0,30}", name, re.ASCII):
        return None, {}
    motion = (name, f"d{name}", f"dd{name}")
    return coordinate, {symbol: sympy.Symbol(symbol, real=True) for symbol in motion}


def _stand_in(moving: Symbols) -> Coordinate:
    """A coordinate for elements to be read with where the unit of the declared one is wrong."""
    with suppress(ModelError):
        return Coordinate(next(iter(moving), "x"))
    return Coordinate("x")


def _parameters(root: Table) -> tuple[tuple[Parameter, ...] | None, Symbols]:
    """The parameters in the order of the file, and the symbols even of wrong ones."""
    table = root.table("parameters")
    made = [read_parameter(table, name) for name in table.values]
    symbols = {name: sympy.Symbol(name, real=True) for name in table.values}
    good = tuple(p for p in made if p is not None)
    return (good if len(good) == len(made) and table.fine else None), symbols


def _signals(root: Table) -> tuple[tuple[Signal, ...] | None, Symbols]:
    """The recorded signals in the order of the file, and the symbols even of wrong ones."""
    table = root.table("signals")
    made = [_signal(table, name) for name in table.values]
    symbols: Symbols = {name: SignalSymbol(name) for name in table.values}
    good = tuple(signal for signal in made if signal is not None)
    return (good if len(good) == len(made) and table.fine else None), symbols


def _signal(root: Table, name: str) -> Signal | None:
    checked = checked_name(root, name, name, "a signal", check_symbol)
    table = root.table(name)
    table.only("unit", "between", "description")
    table.needs("unit")
    fields: dict[str, Any] = {"description": table.text("description")}
    fields |= {key: table.values[key] for key in ("unit", "between") if key in table.values}
    neutral = {"name": checked or "s", "unit": "1"}
    signal = table.made(Signal, fields, neutral, apart=("unit", "between"))
    return signal if checked else None


def _states(root: Table, symbols: Symbols) -> Symbols:
    """What friction remembers, each state by its equation."""
    table = root.table("states")
    own: Symbols = {name: sympy.Symbol(name, real=True) for name in table.values}
    return {name: _state(table, name, {**symbols, **own}) for name in table.values}


def _check_states(root: Table, axis: Axis) -> None:
    """Say which states stand nowhere, in no force and in no other state's equation."""
    used, table = {state.name for state in axis.states}, root.table("states")
    for name in table.values:
        if name not in used:
            table.say(name, "it stands nowhere; write it into the force, or remove it.")


def _state(root: Table, name: str, symbols: Symbols) -> sympy.Symbol:
    checked = checked_name(root, name, name, "a state", check_symbol)
    table = root.table(name)
    table.only("unit", "following", "limit", "start", "description")
    table.needs("unit", "following")
    fields: dict[str, Any] = {"description": table.text("description")}
    fields |= {"unit": table.values["unit"]} if "unit" in table.values else {}
    for key in ("following", "limit", "start"):
        if key in table.values:
            fields[key] = table.expression(key, symbols)
    neutral = {"name": checked or "z", "unit": "1", "following": sympy.S.Zero}
    state = table.made(State, fields, neutral, apart=("unit",))
    return sympy.Symbol(name, real=True) if state is None else state.symbol


def _constants(root: Table, declared: Mapping[str, str], motion: list[str]) -> Symbols:
    """Known numbers with a unit; `G` and `pi` too, of which `G` may be another gravity."""
    table = root.table("constants")
    built_in = (G, Constant(math.pi, "1", "pi"))
    symbols = {constant.name: constant.symbol for constant in built_in}
    for name in table.values:
        checked = checked_name(table, name, name, "a constant")
        if name in declared:
            table.say(name, f"it is a {declared[name]} too; give one of them another name.")
        if name in motion:
            table.say(name, "it is a symbol of the motion too; give one of them another name.")
        if name == "pi":
            table.say(name, "it is the number pi already; leave it out, or choose another name.")
        entry = table.table(name)
        entry.only("value", "unit")
        entry.needs("value", "unit")
        fields: dict[str, Any] = {"value": entry.number("value")}
        fields |= {"unit": entry.values["unit"]} if "unit" in entry.values else {}
        neutral = {"value": 1.0, "unit": "1", "name": checked or "c"}
        constant = entry.made(
            Constant, {**fields, "name": checked or "c"}, neutral, apart=("unit",)
        )
        if constant is not None:
            symbols[name] = constant.symbol
            if name == "G" and not parse_unit(constant.unit).same_dimension(parse_unit(G.unit)):
                table.say(name, f"it is a gravity, in {G.unit}; choose another name.")
    return symbols


def _dynamics(
    root: Table, symbols: Symbols | None, elements: ElementCalls
) -> tuple[Any, dict[str, Any]] | None:
    """`newton` or `lagrange`, and what it takes; without symbols no expression can be read."""
    given = [key for key in ("newton", "lagrange") if key in root.values]
    if len(given) != 1:
        root.say("", f"give one of the tables newton and lagrange, not {len(given)}.")
        return None
    if symbols is None:
        return None
    table = root.table(given[0])
    if given == ["newton"]:
        table.only("inertia", "resistance")
        table.needs("inertia")
        resistance = table.expressions("resistance", symbols, elements)
        fields: dict[str, Any] = {
            "inertia": table.expression("inertia", symbols, elements),
            "resistance": resistance,
        }
        return (newton, fields) if table.fine else None
    table.only(*_ENERGIES)
    table.needs("kinetic")
    fields = {
        key: table.expression(key, symbols, elements if key == _FORCE else None)
        for key in _ENERGIES
    }
    return (lagrange, fields) if table.fine else None


def _injected_at(root: Table) -> str:
    table = root.table("columns")
    return table.text("injected_at") if "injected_at" in table.values else ""


def _columns(root: Table, signals: list[str]) -> dict[str, str]:
    table, roles = root.table("columns"), dict.fromkeys((*ROLES, *signals))
    table.only(*roles, "injected_at")
    found = {role: _column(table, role) for role in roles if role in table.values}
    return {role: text for role, text in found.items() if text}


def _column(table: Table, role: str) -> str:
    """A column as a text, or as a table of what it means."""
    if not isinstance(table.values[role], Mapping):
        return table.text(role)
    inner = table.table(role)
    inner.only(*_COLUMN)
    inner.needs("name")
    fields = {key: inner.values[key] for key in _COLUMN if key in inner.values}
    made = inner.attempt("", lambda: Column(**fields)) if inner.fine else None
    return "" if made is None else str(made)


def _experiment(root: Table, names: list[str], recorded: list[str]) -> Experiment | None:
    if "experiment" not in root.values:
        return None
    table = root.table("experiment")
    noise = ("position_noise", "resolution", "seed")
    table.only("moves", "back_and_forth", "truth", *noise, "signals")
    signals = table.table("signals")
    signals.only(*recorded)
    truth = table.table("truth")
    truth.only(*names)
    fields: dict[str, Any] = {
        "moves": _moves(table),
        "truth": {name: truth.number(name) for name in truth.values if name in names},
        "position_noise": table.number("position_noise"),
        "resolution": table.number("resolution"),
        "seed": table.whole("seed", 1),
        "signals": {
            name: signals.expression(name, {str(TIME): TIME})
            for name in signals.values
            if name in recorded
        },
    }
    neutral = {"moves": (Move(1.0, 1.0, 1.0),)}
    return table.made(Experiment, fields, neutral, apart=noise)


def _moves(table: Table) -> tuple[Move, ...]:
    """Moves one by one, or back and forth; none and a mistake if neither or both are given."""
    given = [key for key in ("moves", "back_and_forth") if key in table.values]
    if len(given) != 1:
        table.say("", f"give one of moves and back_and_forth, not {len(given)}.")
        return ()
    if given == ["moves"]:
        made = [_move(move) for move in table.tables("moves")]
        return tuple(move for move in made if move is not None)
    pattern = table.table("back_and_forth")
    pattern.only("speeds", "acceleration", "seconds", "repeat", "dwell")
    pattern.needs("speeds", "acceleration", "seconds")
    fields = {
        "speeds": tuple(pattern.numbers("speeds")),
        "acceleration": pattern.number("acceleration"),
        "seconds": pattern.number("seconds"),
        "repeat": pattern.whole("repeat", 1),
        "dwell": pattern.number("dwell"),
    }
    neutral = {"speeds": (1.0,), "acceleration": 1.0, "seconds": 1.0}
    return pattern.made(back_and_forth, fields, neutral, apart=tuple(fields)) or ()


def _move(table: Table) -> Move | None:
    keys = ("distance", "speed", "acceleration")
    table.only(*keys, "dwell")
    table.needs(*keys)
    return table.made(Move, {key: table.number(key) for key in (*keys, "dwell")}, {})
