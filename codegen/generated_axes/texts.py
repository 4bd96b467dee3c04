"""The text files of one axis: functions, equations and the manifest that links them.

Every text depends on the declaration alone, so that it is byte-identical on every machine: no time,
no path, no version of a library.
"""

import hashlib
import json
from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import lru_cache

import numpy as np
import sympy

from axisid.codegen.lowering import Output, Program, axis_programs, evaluate
from axisid.codegen.printers import (
    print_c_function,
    print_c_loop,
    print_c_prelude,
    print_c_rows,
    print_function,
    with_loop_header,
)
from axisid.modeling.derivation import AxisModel, derived_sections
from axisid.modeling.library import LIBRARY
from axisid.modeling.quantities import CONTROL, FORCE, Formula, with_numbers, with_own_symbols
from axisid.support.arrays import Array
from axisid.support.errors import ModelError
from axisid.support.missing import Missing

# Samples at which a drive is checked: controls as shares of the limit, positions and velocities in
# SI units. The values have no simple ratios to one another.
_SHARES = np.array([-0.83, -0.31, -0.07, 0.011, 0.29, 0.61, 0.97])
_POSITIONS = np.array([0.317, -0.8137, 0.0113, 2.71, -0.05, 0.2, -1.3])
_VELOCITIES = np.array([0.73, -0.21, -0.013, 3.1, 0.0, -0.4, 0.09])
_RECORDED = np.array([0.91, 1.3, 0.77, 1.9, 0.63, 1.1, 2.3])  # for every signal
_LEAST = 1e-300
# of the largest control, up to which an inverse, which may cancel, undoes the force
_MAX_CONTROL_DIFFERENCE = 1e-9


def check_drive(model: AxisModel, programs: Sequence[Program]) -> None:
    """Refuse a drive whose inverse does not return the control that produced a force.

    The inverse is applied to the forces of several controls and motions. It has to return the
    control, or another control with the same force, as for a force at the limit of the drive.

    Raises
    ------
    ModelError
        The inverse does not return the control, or the gain has a standard deviation but the force
        does not depend on the gain.
    """
    axis, by_name = model.axis, {program.name: program for program in programs}
    largest = axis.drive.limit if np.isfinite(axis.drive.limit) else 1.0
    controls = largest * _SHARES
    motion = {axis.coordinate.name: _POSITIONS, str(axis.coordinate.velocity): _VELOCITIES}
    motion |= {signal.name: _RECORDED for signal in axis.signals}
    force = single_result(by_name["drive_force"], {**motion, str(CONTROL): controls})
    if axis.drive.relative_sd and axis.drive.force_by_gain == 0:
        raise ModelError(
            f"axis {axis.name!r}: the gain of the drive {type(axis.drive).__name__} has a "
            "standard deviation, but its force does not depend on the gain. Define force_by_gain, "
            "or omit relative_sd.",
            code="generated-code",
        )
    inverted = single_result(by_name["drive_control"], {**motion, str(FORCE): force})
    size = np.abs(force)
    is_compared = (size > _LEAST) & np.isfinite(size)  # elsewhere the control is undetermined
    is_wrong = is_compared & ~(np.abs(inverted - controls) <= _MAX_CONTROL_DIFFERENCE * largest)
    # A force at the limit of the drive belongs to many controls, any of which is right.
    force_again = single_result(by_name["drive_force"], {**motion, str(CONTROL): inverted})
    with np.errstate(invalid="ignore"):  # overflowing forces, which are not compared
        is_wrong &= ~(np.abs(force_again - force) <= _MAX_CONTROL_DIFFERENCE * size)
    if not np.any(is_wrong):
        return
    i, unit = int(np.argmax(is_wrong)), axis.drive.unit
    raise ModelError(
        f"axis {axis.name!r}: with a control of {controls[i]:.6g} {unit} the drive "
        f"{type(axis.drive).__name__} produces a force of {force[i]:.6g}, but its inverse returns "
        f"{inverted[i]:.6g} {unit} for this force. Correct the force or the inverse.",
        code="generated-code",
    )


def single_result(program: Program, elements: Mapping[str, Array]) -> Array:
    """Return the result, (N,), of a program with a single scalar result at N points."""
    (values,) = evaluate(program, elements).values()
    return values[:, 0]


#: Version of the generated text's form; part of every signature.
SCHEMA = 6

FUNCTIONS, NATIVE, EQUATIONS, MANIFEST = (
    "functions.py",
    "native.c",
    "equations.txt",
    "manifest.json",
)
_START = "state_start"  # depends on parameters alone, so that it is not evaluated at samples
#: Functions that the native time loop calls.
LOOP = (
    _START,
    "control_start",
    "held_acceleration",
    "plant_step",
    "switching",
    "plant_rate",
    "drive_response",
    "closed_loop_step",
)
#: Functions of one sample that the native code also evaluates at many samples.
ROWS = (
    "inverse_dynamics",
    "idm_regressor",
    "direct_dynamics",
    "ddm_regressor",
    "drive_force",
    "drive_control",
    "control_law",
    "control_terms",
    "wave_number",
)
# Sizes for which the time loop's C is printed: the length of each argument of a step.
_SIZES = {"HELD": "held", "MEMORY": "state", "PARAMETERS": "parameters", "SIDES": "sides"}


def axis_artefacts(model: AxisModel) -> dict[str, str]:
    """Return the text of every generated file of an axis, by file name.

    Raises
    ------
    ModelError
        The axis cannot be lowered, or its drive's inverse does not undo its force.
    """
    programs = axis_programs(model)
    check_drive(model, programs)
    mark = signature(model)
    header = _header(model.axis.name, mark)
    texts = {
        FUNCTIONS: functions_text(model.axis.name, header, programs),
        NATIVE: _native(model, header, programs),
        EQUATIONS: _equations(model, mark),
    }
    texts[MANIFEST] = json.dumps(_manifest(model, mark, programs, texts), indent=2) + "\n"
    return texts


def by_gains_artefacts(model: AxisModel) -> tuple[str, str]:
    """Return the Python and C texts of an axis whose functions take the law's gains as arguments.

    They do not depend on the values of the gains, and are not written to files.
    """
    programs = axis_programs(model, by_gains=True)
    about = "The gains of its control law are arguments.\n"
    return (
        functions_text(model.axis.name, about, programs),
        _native(model, about, programs, by_gains=True),
    )


def signature(model: AxisModel) -> str:
    """Return the SHA-256 of the schema and of all content on which the generated text depends."""
    axis, law = model.axis, model.axis.control
    content = {
        "schema": SCHEMA,
        "axis": [axis.name, axis.title],
        "coordinate": [axis.coordinate.name, axis.coordinate.unit],
        "parameters": [[p.name, p.unit] for p in axis.parameters],
        "force": _with_numbers(axis.force),
        "drive": [
            _as_text(axis.drive.force),
            _as_text(axis.drive.inverse),
            {str(symbol): repr(float(v)) for symbol, v in axis.drive.constants.items()},
            axis.drive.unit,
            repr(float(axis.drive.limit)),
            *([] if axis.drive.profile == 1 else [_with_numbers(axis.drive.profile)]),
        ],
        "control": law
        and {
            "period": repr(float(law.period)),
            "gains": {name: repr(float(value)) for name, value in law.gains.items()},
            "delay": law.delay,
            "continuous": law.continuous,
            "output": _with_numbers(law.output),
            "memory": [
                [m.name, _with_numbers(m.following), _with_numbers(m.start)] for m in law.memory
            ],
        },
    }
    times = () if axis.response is None else (axis.drive.lag, axis.drive.delay)
    # Entries that are empty are not part of the signature.
    further: dict[str, Collection[object]] = {
        "response": [repr(float(time)) for time in times],
        "path": {name: repr(x) for name, x in axis.drive.path.declared.items()},
        "states": [
            [s.name, s.unit, *(_with_numbers(with_own_symbols(value)) for value in s.values)]
            for s in axis.states
        ],
        "signals": [[s.name, s.unit, s.between] for s in axis.signals],
    }
    content |= {name: value for name, value in further.items() if value}
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _with_numbers(value: sympy.Expr) -> str:
    """Return an expression as text, with each constant replaced by its number."""
    return _as_text(with_numbers(value))


# Axes that differ only in gains, of which there may be hundreds, have the same expressions.
@lru_cache(maxsize=128)
def _as_text(value: sympy.Expr) -> str:
    """Return an expression as text that represents it exactly."""
    return str(sympy.srepr(value))


def _header(name: str, mark: str) -> str:
    """Return the heading of generated files: the command that writes them, and the signature."""
    # An axis outside the library is generated from its file, which its name does not give.
    command = f"axisid generate {name}" if name in LIBRARY else "axisid generate"
    of = "" if name in LIBRARY else f" from the file that declares the axis {name}"
    return (
        f"Generated by `{command}`{of}; do not edit: change the axis and run it again.\n"
        f"signature {mark}, schema {SCHEMA}\n"
    )


def functions_text(name: str, header: str, programs: tuple[Program, ...]) -> str:
    """Return the text of a Python module that builds CasADi functions.

    Its ``FUNCTIONS`` maps the name of each program to the function that builds it.
    """
    operations = sum(program.operation_count for program in programs)
    about = f"CasADi functions of the axis {name}.\n\n{header}{operations} operations"
    names = "".join(f'    "{program.name}": {program.name},\n' for program in programs)
    return (
        f'"""{about}\n"""\n\nimport casadi\n\n\n'
        + "\n\n".join(map(print_function, programs))
        + f"\n\nFUNCTIONS = {{\n{names}}}\n"
    )


def _native(
    model: AxisModel,
    header: str,
    programs: tuple[Program, ...],
    *,
    by_gains: bool = False,
) -> str:
    """Return the C text of an axis: functions of one sample, loops over samples, and time loop.

    The gains of the law are arguments if `by_gains` is True.
    """
    law = model.axis.control
    by_name = {program.name: program for program in programs}
    looped = [*LOOP] if law is not None else []
    printed = [print_c_function(by_name[name]) for name in (*ROWS, *looped) if name in by_name]
    at_samples = [name for name in (*ROWS, *looped) if name != _START]
    printed += [print_c_rows(by_name[name]) for name in at_samples if name in by_name]
    if law is not None:
        ports = {port.name: port for port in by_name["plant_step"].inputs}
        ports |= {port.name: port for port in by_name["closed_loop_step"].inputs}
        sizes = {
            size: len(ports[name].elements) if name in ports else 0 for size, name in _SIZES.items()
        }
        deciding = by_name["switching"].inputs if sizes["SIDES"] else ()
        limited = sum(state.limit is not None for state in model.states)
        # A size that an axis lacks is not defined at all; the first of the limits may be 0.
        further = {
            "GAINS": len(law.gains) if by_gains else None,
            "SIGNALS": len(model.axis.signals) or None,
            "MOVING": 1 if "held" in [port.name for port in deciding] else None,
            "STATES": len(model.states) or None,
            "FIRST_LIMIT": sizes["SIDES"] - limited if limited else None,
            "WAVES": 1 if "wave_number" in by_name else None,
        }
        sizes |= {name: size for name, size in further.items() if size is not None}
        response, following = model.axis.response, dict[str, float]()
        if response is not None and not response.is_held:
            following = {"LAGGED": int(response.keeps_force)}
            following |= {"SPLIT": response.share} if response.share else {}
        printed.append(print_c_loop(sizes, continuous=law.continuous, response=following))
    head = "".join(f"   {line}\n" for line in header.splitlines())
    body = "\n".join(printed)
    return (
        f"/* Native code of the axis {model.axis.name}.\n\n{head}*/\n\n"
        f"{print_c_prelude(with_loop_header(body))}\n{body}"
    )


def _equations(model: AxisModel, mark: str) -> str:
    """Return the text of ``equations.txt``: the derived models, section by section."""
    q = model.axis.coordinate
    lines = [
        f"Axis {model.axis.name}: {model.axis.title}".rstrip(": "),
        "",
        _header(model.axis.name, mark).rstrip(),
    ]
    for section in derived_sections(model):
        lines += ["", section.title]
        lines += [
            f"  {line.text(q) if isinstance(line, Formula) else line}" for line in section.lines
        ]
    return "\n".join(lines) + "\n"


def _manifest(
    model: AxisModel, mark: str, programs: tuple[Program, ...], texts: Mapping[str, str]
) -> dict[str, object]:
    """Return the manifest: names and units, functions with their shapes, and digests of files."""
    mapping, drive = model.parameter_map, model.axis.drive
    timing = {"lag": drive.lag, "delay": drive.delay, "logged": drive.logged, **drive.path.declared}
    is_immediate = model.axis.response is None and drive.path.is_plain
    return {
        "axis": model.axis.name,
        "schema": SCHEMA,
        "signature": mark,
        "parameters": [{"name": p.name, "unit": p.unit} for p in model.axis.parameters],
        **_listed("signals", model.axis.signals, ("name", "unit", "between")),
        **_listed("states", model.axis.states, ("name", "unit")),
        **({} if is_immediate else {"drive": timing}),
        "ddm_parameters": None
        if isinstance(mapping, Missing)
        else [
            {"name": str(symbol), "expression": str(value), "unit": str(unit)}
            for symbol, value, unit in zip(
                mapping.symbols, mapping.forward, mapping.units, strict=True
            )
        ],
        "functions": [
            {
                "name": program.name,
                "inputs": ", ".join(
                    port.name + ("" if port.elements == (port.name,) else f"[{len(port.elements)}]")
                    for port in program.inputs
                ),
                "outputs": ", ".join(f"{port.name}{_shape(port)}" for port in program.outputs),
                "operations": program.operation_count,
            }
            for program in programs
        ],
        "files": {name: hashlib.sha256(text.encode()).hexdigest() for name, text in texts.items()},
    }


def _listed(key: str, items: Iterable[object], names: Iterable[str]) -> dict[str, object]:
    """Return a manifest entry with attributes, given by their names, of items.

    The mapping is empty without items.
    """
    listed = [{name: getattr(item, name) for name in names} for item in items]
    return {key: listed} if listed else {}


def _shape(port: Output) -> str:
    """Return the shape of an output as text, ``[2, 3]``; empty for a scalar."""
    shape = (len(port.rows), len(port.rows[0]) if port.rows else 1)
    return "" if shape == (1, 1) else f"[{shape[0]}, {shape[1]}]"
