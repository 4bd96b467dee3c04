"""Load an axis by its name in the library, or from a user's Python or TOML file.

A Python file is run. A TOML file declares an axis as data, and nothing in it is run: expressions
are text, read by `read_expression`. All mistakes of a TOML file are reported at once.
"""

import contextlib
import inspect
import math
import os
import runpy
import sys
import traceback
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import sympy

from axisid.modeling.declaration import (
    BLOCKS,
    DRIVE_GAIN,
    DRIVES,
    HIDDEN_FROM,
    LAWS,
    ROLES,
    Axis,
    Block,
    ControlLaw,
    Drive,
    Experiment,
    Memory,
    Move,
    back_and_forth,
    formula_drive,
    gain,
    lagrange,
    newton,
)
from axisid.modeling.library import LIBRARY, library_axis
from axisid.modeling.quantities import (
    BALANCED,
    CONTROL,
    FORCE,
    LIMITED_OUTPUT,
    MEASURED_POSITION,
    MEASURED_VELOCITY,
    PERIOD,
    REFERENCE,
    TIME,
    UNLIMITED_OUTPUT,
    Constant,
    ConstantSymbol,
    Coordinate,
    G,
    Parameter,
    Signal,
    SignalSymbol,
    State,
    check_name,
    check_symbol,
)
from axisid.support.checks import refuse
from axisid.support.errors import DeclarationError, ModelError
from axisid.support.files import axis_file
from axisid.support.wording import quoted

from .grammar import Elements, elements_along
from .toml_table import Symbols, TomlTable, read_columns, read_toml


def load_axis(name: str | Path) -> Axis:
    """Return a library axis by name, or the axis declared in a Python or TOML file.

    A Python file is run as a program: load only files that you trust. A TOML file is only read.

    Parameters
    ----------
    name : str or Path
        A name of the library (``emps``), ``FILE.toml``, ``FILE.py`` or ``FILE.py:VARIABLE`` where
        the file declares several axes.

    Raises
    ------
    ModelError
        There is no axis or file of this name, the Python file cannot be run, or it declares no
        axis.
    DeclarationError
        The TOML file cannot be read, or has mistakes; the message lists all mistakes.
    """
    if not isinstance(name, (str, Path)):
        raise ModelError(
            f"the axis is {quoted(name)}. Give the name of an axis of the library, or of a file "
            "that declares an axis."
        )
    name = str(name)
    if name in LIBRARY:
        return library_axis(name)
    file, variable = axis_file(name)
    refuse(
        ModelError,
        (
            file.suffix not in (".py", ".toml"),
            f"there is no axis {name!r}. Give an axis of the library ({', '.join(LIBRARY)}) or a "
            "file that declares an axis, such as my_axis.toml or my_axis.py. `axisid new my_axis` "
            "writes a first file",
        ),
        (
            not os.path.isfile(file),  # False also for a name that no file can have
            f"there is no axis file {str(file)!r}, or it is not a regular file. Check the path",
        ),
        code="axis-file",
    )
    if file.suffix == ".toml":
        return read_toml(file, _axis, DeclarationError)
    return _only_axis(_run(file), file, variable)


def _run(file: Path) -> dict[str, Any]:
    """Run the text of a Python file and return its variables by name.

    The text is run, and not its compiled file, which may be older.

    Raises
    ------
    ModelError
        The file cannot be run; the message names the line.
    """
    folder = str(file.resolve().parent)
    sys.path.insert(0, folder)
    try:
        # The file's own output must not mix with the results on standard output.
        with contextlib.redirect_stdout(sys.stderr):
            return runpy.run_path(str(file), run_name=f"axisid_user_{file.stem}")
    except ModelError as error:
        raise ModelError(f"{file}, {_line(error, file)}: {error}", code="axis-file") from error
    except (Exception, SystemExit) as error:
        raise ModelError(
            f"{file} cannot be imported: {type(error).__name__} at {_line(error, file)}: {error}",
            code="axis-file",
        ) from error
    finally:
        if folder in sys.path:
            sys.path.remove(folder)


def _line(error: BaseException, file: Path) -> str:
    """Return the line of the user's file at which an error occurred, as text: ``line 12``."""
    if isinstance(error, SyntaxError) and error.lineno:
        return f"line {error.lineno}"
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if Path(frame.filename) == file]
    return f"line {lines[-1]}" if lines else "an unknown line"


def _only_axis(variables: dict[str, Any], file: Path, variable: str) -> Axis:
    """Return the axis of a user's file.

    It is the axis of the wanted variable, if a name is given. Otherwise it is the only axis, or the
    variable ``axis`` if there are several axes.

    Parameters
    ----------
    variables : dict of str to object
        Variables of the file by name.
    file : Path
    variable : str
        Name of the wanted variable; empty if no name is given.

    Raises
    ------
    ModelError
        The file declares no axis, or no axis of the wanted name.
    """
    axes = {name: value for name, value in variables.items() if isinstance(value, Axis)}
    is_single = len({id(axis) for axis in axes.values()}) == 1  # possibly under several names
    wanted = variable
    if not wanted:
        wanted = next(iter(axes)) if is_single else "axis"
    refuse(
        ModelError,
        (not axes, f"{file} declares no axis. Assign the result of newton(...) to a name"),
        (
            wanted not in axes,
            f"{file} declares the axes {', '.join(axes)}, and none of them is named {wanted}. "
            f"Choose an axis with {file}:NAME",
        ),
        code="axis-file",
    )
    return axes[wanted]


_INPUTS = {str(s): s for s in (REFERENCE, MEASURED_POSITION, MEASURED_VELOCITY, PERIOD)}
_AT_REST = {str(s): s for s in (MEASURED_POSITION, REFERENCE, BALANCED)}


def read_control(root: TomlTable, recorded: Symbols, constants: Symbols) -> ControlLaw | None:
    """Return the control law of the table ``control``; None without the table.

    A law with mistakes is None too; the mistakes are added to the table.

    Parameters
    ----------
    root : TomlTable
        The whole document.
    recorded : mapping of str to sympy.Symbol
        Recorded signals that the law may read.
    constants : mapping of str to sympy.Symbol
        Constants of the declaration that the law may contain.
    """
    if "control" not in root.values:
        return None
    table = root.table("control")
    # In a law, pi is the plain number and not a constant with a unit.
    known = {name: symbol for name, symbol in constants.items() if name != "pi"}
    if "law" in table.values:
        return _shipped_law(table, {**known, **recorded})
    # A law of the user: check the names, then read the blocks, the memories and the output.
    gains, memory = table.table("gains"), table.table("memory")
    for part in (gains, memory):
        what = "the gain" if part is gains else "the memory"
        for name in part.values:
            part.attempt(name, partial(check_symbol, name, what, control=True))
    names = (*gains.values, *memory.values)
    symbols = {**known, **recorded, **_INPUTS, **{name: gain(name) for name in names}}
    at_rest = {**known, **_AT_REST}
    blocks = _blocks(table.table("blocks"), symbols, at_rest)
    symbols |= {name: block.value for name, block in blocks.items()}
    outputs = {str(output): output for output in (LIMITED_OUTPUT, UNLIMITED_OUTPUT)}
    following = {**symbols, **outputs}
    memories = memory.each(Memory, symbols=following, own={"start": at_rest})
    of_blocks = [each for block in blocks.values() for each in block.memory]
    # A gain of 1 stands for a gain or a memory with a mistake, which is reported already.
    stand_ins = dict.fromkeys((name for name in names if memories.get(name) is None), 1.0)
    given = {
        "gains": {**stand_ins, **gains.read_all(gains.values, float)},
        "memory": [*filter(None, memories.values()), *of_blocks],
        "positive": (),
    }
    return table.made(ControlLaw, symbols, given=given, beside=("gains", "memory", "blocks"))


def _shipped_law(table: TomlTable, symbols: Symbols) -> ControlLaw | None:
    """Return the ready-made law that a table names by ``law``; None after a mistake.

    The other keys of the table are the arguments of the law's function, and ``delay`` and
    ``reference_between`` of `ControlLaw`.
    """
    law = table.chosen("law", LAWS, "law", ", or omit the key law and give the output of the law")
    if law is None:
        return None
    of_any = inspect.signature(ControlLaw).parameters
    timing = {key: of_any[key] for key in ("delay", "reference_between")}

    def with_timing(**fields: Any) -> ControlLaw:
        """Return the law with its delay and its interpolation of the reference, if given."""
        own_timing = {key: fields.pop(key) for key in timing if key in fields}
        return replace(law(**fields), **own_timing)

    arguments = {**inspect.signature(law).parameters, **timing}
    return table.made(with_timing, symbols, arguments=arguments, beside=("law",))


def _blocks(table: TomlTable, symbols: Symbols, at_rest: Symbols) -> dict[str, Block]:
    """Return the blocks of a user's law by name; each may use the blocks before it.

    Parameters
    ----------
    table : TomlTable
    symbols : mapping of str to sympy.Symbol
        Symbols that the blocks may use.
    at_rest : mapping of str to sympy.Symbol
        Symbols that the start values of their memories may use.
    """
    found: dict[str, Block] = {}
    for name in table.values:
        table.attempt(name, partial(check_name, name, "the block"))
        if name in symbols:
            table.say(name, "the law has another symbol of this name. Rename the block.")
        inner = table.table(name)
        make: Callable[..., Block] | None = inner.chosen("block", BLOCKS, "block")
        if make is None:
            continue
        several = "names" in inspect.signature(make).parameters
        given = {"names": (f"{name}1", f"{name}2")} if several else {"name": f"{name}1"}
        known = {**symbols, **{each: block.value for each, block in found.items()}}
        block = inner.made(make, known, given=given, beside=("block",), own={"start": at_rest})
        found |= {} if block is None else {name: block}
    return found


_FORMULAS = ("force", "inverse")


def read_drive(root: TomlTable, symbols: Symbols) -> Drive | None:
    """Return the drive of the table ``drive``; None without the table.

    A drive with mistakes is None too; the mistakes are added to the table.

    Parameters
    ----------
    root : TomlTable
        The whole document.
    symbols : mapping of str to sympy.Symbol
        Constants, recorded signals and symbols of the motion, which formulas may use.
    """
    if "drive" not in root.values:
        return None
    table = root.table("drive")
    make: Callable[..., Drive] | None = Drive
    if "kind" in table.values:
        make = table.chosen(
            "kind",
            DRIVES,
            "drive",
            ", or omit the key kind and give a gain, or force and inverse",
        )
    elif any(key in table.values for key in _FORMULAS):
        make = formula_drive
    if make is None:
        return None
    # A lag or delay that is a table is a parameter to be estimated.
    times = {
        key: table.table(key).made(partial(Parameter, unit="s"), name=key)
        for key in HIDDEN_FROM
        if isinstance(table.values.get(key), Mapping)
    }
    # A mistake in such a table is reported already: 0 stands for the time.
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
    """Return the arguments of a function that makes a drive, together with those of `Drive`.

    The arguments that only `Drive` has are optional.
    """
    of_any = inspect.signature(Drive).parameters
    shared = {key: each.replace(default=None) for key, each in of_any.items()}
    known = {**shared, **inspect.signature(make).parameters}
    return {key: each for key, each in known.items() if key not in ("estimated", "others")}


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
#: The functions that make an axis from the table of its equation of motion, and the keys there.
_EQUATIONS: Mapping[str, tuple[Callable[..., Axis], tuple[str, ...]]] = {
    "newton": (partial(newton, resistance=()), ("inertia", "resistance")),
    "lagrange": (lagrange, ("kinetic", "potential", "dissipation", "generalised_force")),
}


def _axis(root: TomlTable) -> Axis | None:
    """Return the axis that a TOML document declares; None after a mistake.

    Each part is read even if other parts have mistakes, so that all mistakes are reported. The
    steps are the coordinate, the parameters, signals, constants and states, the equation of motion,
    then drive, columns, control law and experiment.
    """
    root.only("name", "title", *_PARTS[:5], *_EQUATIONS, *_PARTS[5:])
    root.needs("name", "coordinate", "parameters", "drive")
    name = root.values.get("name", "axis")
    title = root.read("title", str) if "title" in root.values else ""
    named = root.attempt("name", lambda: check_name(name, "the axis"))
    count_before = len(root.mistakes)
    coordinate = _coordinate(root)
    motion = (coordinate.symbol, coordinate.velocity, coordinate.acceleration) if coordinate else ()
    moving: Symbols = {str(symbol): symbol for symbol in motion}
    parameters = root.table("parameters").each(Parameter)
    signals = root.table("signals").each(Signal)
    unknown: Symbols = {name: sympy.Symbol(name, real=True) for name in parameters}
    recorded: Symbols = {name: SignalSymbol(name, real=True) for name in signals}
    constants = _constants(root.table("constants"), unknown, recorded, moving)
    # A state may occur in its own equation, so its symbol is made before its equation is read.
    states = root.table("states")
    plain: Symbols = {name: sympy.Symbol(name, real=True) for name in states.values}
    declared_states = states.each(
        State, symbols={**constants, **unknown, **moving, **plain}, given={"parts": ()}
    )
    internal = {
        name: state.symbol if state else plain[name] for name, state in declared_states.items()
    }
    symbols = {**constants, **unknown, **recorded, **internal, **moving} if moving else {}
    declare = _dynamics(root, symbols, elements_along(coordinate) if coordinate else {})
    is_readable = len(root.mistakes) == count_before
    drive = read_drive(root, {**constants, **recorded, **moving}) or Drive(gain=1.0)
    columns = read_columns(root.table("columns"), (*ROLES, *recorded, "injected_at"))
    parts = {
        "control": read_control(root, recorded, constants),
        "injected_at": columns.pop("injected_at", ""),
        "columns": columns,
        "experiment": _experiment(root, unknown, recorded),
    }
    # Make the axis only if everything in its equation of motion could be read.
    if coordinate is None or declare is None or not is_readable:
        return None
    declared = partial(
        declare,
        named or "axis",
        title=title or "",
        coordinate=coordinate,
        parameters=tuple(parameters.values()),
        signals=tuple(signals.values()),
        drive=drive,
        **parts,
    )
    axis = root.attempt("", declared)
    if axis is None:
        return None
    used = {state.name for state in axis.states}
    for name in states.values:
        if name not in used:
            states.say(
                name, "the state is not used. Write the state into the force, or remove the state."
            )
    return axis


def _coordinate(root: TomlTable) -> Coordinate | None:
    """Return the coordinate of a document; None without the table, or if its name is wrong.

    A coordinate with a mistake is reported, and a coordinate of the same name, in m, replaces it.
    """
    if "coordinate" not in root.values:
        return None
    table = root.table("coordinate")
    with contextlib.suppress(ModelError):
        return table.made(Coordinate) or Coordinate(table.values.get("name", "x"))
    return None


def _constants(table: TomlTable, unknown: Symbols, recorded: Symbols, moving: Symbols) -> Symbols:
    """Return the symbols of the constants by name, including `G` and `pi`.

    `G` may be declared again with another value. The name of another quantity is a mistake.

    Parameters
    ----------
    table : TomlTable
    unknown, recorded, moving : mapping of str to sympy.Symbol
        Symbols of the parameters, of the recorded signals and of the motion.
    """
    symbols = {constant.name: constant.symbol for constant in (G, Constant(math.pi, "1", "pi"))}
    others = {**dict.fromkeys(unknown, "parameter"), **dict.fromkeys(recorded, "signal")}
    others |= dict.fromkeys(moving, "symbol of the motion")
    for name, constant in table.each(Constant).items():
        if name in others:
            table.say(name, f"the constant has the name of a {others[name]}. Rename the constant.")
        if name == "pi":
            table.say(
                name,
                "pi is the number pi in every expression. Omit the constant, or choose another "
                "name.",
            )
        symbols[name] = ConstantSymbol(name, 1.0, "1") if constant is None else constant.symbol
        if constant and name == "G" and not constant.symbol.unit.same_dimension(G.symbol.unit):
            table.say(
                name,
                f"G is the acceleration of gravity, in {G.unit}. Choose another name for the "
                "constant.",
            )
    return symbols


_OF_FORCES = ("inertia", "resistance", "generalised_force")


def _dynamics(root: TomlTable, symbols: Symbols, elements: Elements) -> Callable[..., Axis] | None:
    """Return `newton` or `lagrange` with the expressions of its table as arguments.

    None without symbols, that is without a readable coordinate, and after a mistake.

    Parameters
    ----------
    root : TomlTable
        The whole document.
    symbols : mapping of str to sympy.Symbol
        Symbols that the expressions may name.
    elements : mapping of str to callable
        Elements of friction and load that the forces may call.
    """
    given = [key for key in _EQUATIONS if key in root.values]
    if len(given) != 1:
        root.say(
            "",
            f"the file has {len(given)} of the tables newton and lagrange. Give exactly one of the "
            "two tables.",
        )
        return None
    if not symbols:
        return None
    declare, keys = _EQUATIONS[given[0]]
    known = inspect.signature(declare).parameters
    return root.table(given[0]).made(
        lambda **expressions: partial(declare, **expressions),
        symbols,
        arguments={key: known[key] for key in keys},
        elements=dict.fromkeys(_OF_FORCES, elements),  # an energy may call no element
    )


def _experiment(root: TomlTable, unknown: Symbols, recorded: Symbols) -> Experiment | None:
    """Return the experiment of a document; None without the table, and after a mistake."""
    if "experiment" not in root.values:
        return None
    table = root.table("experiment")
    given = {
        "moves": _moves(table),
        "truth": table.table("truth").read_all(unknown, float),
        "signals": table.table("signals").read_all(recorded, sympy.Expr, {str(TIME): TIME}),
    }
    # The keys that were read above are permitted in the table.
    return table.made(Experiment, given=given, beside=("back_and_forth", *given))


def _moves(table: TomlTable) -> tuple[Move, ...]:
    """Return the moves of an experiment, from the list ``moves`` or from ``back_and_forth``.

    An experiment without moves is a mistake, and a substitute of one move is returned.
    """
    stand_in = Move(1.0, 1.0, 1.0)
    given = [key for key in ("moves", "back_and_forth") if key in table.values]
    if len(given) != 1:
        table.say(
            "",
            f"the table has {len(given)} of the keys moves and back_and_forth. Give exactly one of "
            "the two keys.",
        )
        return (stand_in,)
    found: tuple[Move, ...] | None
    if given == ["moves"]:
        moves = table.items("moves")
        found = tuple(moves.table(key).made(Move) or stand_in for key in moves.values)
    else:
        found = table.table("back_and_forth").made(back_and_forth)
    if found == ():
        table.say(given[0], "the experiment has no moves. Give at least one move.")
    return found or (stand_in,)
