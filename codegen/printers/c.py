"""C text of programs: functions of one sample, loops over samples and lanes, and the feed-forward.

Functions take scalars by value and vectors by pointer, and write each output through a pointer, row
by row. Inputs end in an underscore and outputs in `_out`, so that no name is a header's macro.
"""

import re
from collections.abc import Iterable, Mapping
from importlib import resources

from axisid.codegen.lowering import (
    PROBE,
    PROBED,
    RESOLVED,
    STEPS_IN_ALL,
    STEPS_OF_EACH,
    FeedForward,
    Input,
    Program,
)

from .shared import Language, comment, print_operations

_INCLUDES = """\
#include <math.h>
#include <stddef.h>
"""
# Helpers that printed functions call in addition to <math.h>, written so that loops vectorise.
_HELPERS = {
    # like fmin and fmax, a NaN is not chosen
    "minimum": "(double a, double b) { return a < b || b != b ? a : b; }",
    "maximum": "(double a, double b) { return a > b || b != b ? a : b; }",
    "sign": "(double a) { return (double)((a > 0.0) - (a < 0.0)); }",
    "less": "(double a, double b) { return (double)(a < b); }",
    "at_most": "(double a, double b) { return (double)(a <= b); }",
    "equal": "(double a, double b) { return (double)(a == b); }",
    "negated": "(double a) { return (double)(a == 0.0); }",
    "both": "(double a, double b) { return (double)(a != 0.0 && b != 0.0); }",
    "either": "(double a, double b) { return (double)(a != 0.0 || b != 0.0); }",
    "select": "(double c, double a, double b) { return c != 0.0 ? a : b; }",
}
#: Parts of the time loop in the order of its text; each calls those before it.
_LOOP = ("modes.c", "events.c", "sample.c", "batch.c", "between.c", "start.c")
_INCLUDE_LOOP = '#include "../loop.h"\n'
#: C syntax of a program.
C = Language(
    calls={
        "abs": "fabs",
        "min": "minimum",
        "max": "maximum",
        "lt": "less",
        "le": "at_most",
        "eq": "equal",
        "not": "negated",
        "and": "both",
        "or": "either",
    },
    variable=lambda element: f"{element}_",
    name=lambda name, expression: f"    const double {name} = {expression};",
)


def print_c_prelude(text: str) -> str:
    """Return the headers, and those helpers that a C text calls."""
    return f"{_INCLUDES}\n{print_c_helpers(text)}"


def print_c_helpers(text: str) -> str:
    """Return those helpers that a C text calls."""
    called = {*re.findall(r"\b(\w+)\(", text)}
    used = [name for name in _HELPERS if name in called]
    return "".join(f"static inline double {name}{_HELPERS[name]}\n" for name in used)


def print_c_function(program: Program) -> str:
    """Return the text of a static inline C function."""
    texts, body = print_operations(program, C)
    used = {op.symbol for op in program.operations if op.name == "input"}
    lines = [f"/* {program.summary} {program.operation_count} operations. */"]
    arguments = [
        f"double {port.name}_" if _is_scalar(port) else f"const double *{port.name}_"
        for port in program.inputs
    ]
    arguments += [f"double *{port.name}_out" for port in program.outputs]
    listed = ",\n    ".join(arguments)
    lines.append(f"static inline void {program.name}(\n    {listed})\n{{")
    for port in program.inputs:
        lines += _unpacked(port, used)
    lines += body
    for result in program.outputs:
        elements = [texts[i] for row in result.rows for i in row]
        lines += [f"    {result.name}_out[{i}] = {text};" for i, text in enumerate(elements)]
        lines += [] if elements else [f"    (void){result.name}_out;"]
    return "\n".join([*lines, "}"]) + "\n"


def print_c_rows(program: Program) -> str:
    """Return the text of an exported C function that evaluates a program at many samples.

    Scalar arguments become arrays, one value a sample. A vector is followed by its stride from one
    sample to the next: its length, or 0 if it is the same for every sample. Outputs are arrays with
    one row a sample.
    """
    arguments, call = [], []
    for port in program.inputs:
        arguments.append(f"const double *{port.name}_")
        call.append(
            f"{port.name}_[k]" if _is_scalar(port) else f"{port.name}_ + k * {port.name}_step"
        )
        arguments += [] if _is_scalar(port) else [f"ptrdiff_t {port.name}_step"]
    arguments += [f"double *{port.name}_out" for port in program.outputs]
    call += [f"{port.name}_out + k * {sum(map(len, port.rows))}" for port in program.outputs]
    return (
        f"void {program.name}_rows(\n    ptrdiff_t samples, {', '.join(arguments)})\n"
        "{\n    for (ptrdiff_t k = 0; k < samples; ++k)\n"
        f"        {program.name}({', '.join(call)});\n}}\n"
    )


def print_c_loop(
    sizes: Mapping[str, int],
    *,
    continuous: bool,
    response: Mapping[str, float],
) -> str:
    """Return the definitions of one axis's sizes, and the line that includes the time loop.

    Parameters
    ----------
    sizes : mapping of str to int
        ``PARAMETERS``, ``MEMORY``, ``HELD`` and ``SIDES``; ``SIGNALS`` if there are any, and
        ``GAINS`` if those of the law are arguments, the last of the parameters; ``MOVING`` if
        signals move the kinks at which sides change; ``STATES`` for friction with internal states,
        and ``FIRST_LIMIT``, the index of the first side that belongs to a state's limit, if there
        is one; ``WAVES`` if the acceleration has waves over the position.
    continuous : bool
        True if the law is continuous.
    response : mapping of str to float
        Sizes of a drive whose force changes between samples: ``LAGGED`` is 1 for a drive with a lag
        and 0 otherwise; ``SPLIT`` is the part of a sample after which a command begins to act, and
        is missing if it acts at the sample. Empty for any other drive.
    """
    values: dict[str, float] = {**sizes, **response, "CONTINUOUS": int(continuous)}
    # The rates of the motion are given where a loop starts, unless it has sides or states.
    rates = not (sizes["SIDES"] or "STATES" in sizes)
    if sizes["SIDES"]:
        values |= {
            "RESOLVED": RESOLVED,
            "STEPS_IN_ALL": STEPS_IN_ALL,
            "STEPS_OF_EACH": STEPS_OF_EACH,
        }
    elif rates:
        values["PROBE"] = PROBE
        if "WAVES" in sizes:
            values["PROBED"] = PROBED
    values |= {
        "RESPONSE": int(bool(response)),
        "RATES": int(rates),
        "HOLDS_FORCE": int(not (continuous or response or "STATES" in sizes)),
    }
    lines = "".join(f"#define {name} {value}\n" for name, value in values.items())
    if "SIGNALS" in sizes:
        lines += _start_of(sizes["SIGNALS"], by_gains="GAINS" in sizes)
    # Macro that passes the recorded signals to a function, one by one, after its other scalars.
    values_of = "".join(f", (values)[{i}]" for i in range(sizes.get("SIGNALS", 0)))
    return f"{lines}{f'#define WITH(values) {values_of}'.rstrip()}\n{_INCLUDE_LOOP}"


def print_c_loop_header() -> str:
    """Return the text of the time loop, the same for every axis, which native code includes."""
    return _joined("loop", _LOOP)


def with_loop_header(text: str) -> str:
    """Return native code with the text of the time loop in place of the line that includes it."""
    return text.replace(_INCLUDE_LOOP, print_c_loop_header())


def _start_of(signals: int, *, by_gains: bool) -> str:
    """Return the C function that computes the memory at the start of a loop.

    Its array of recorded signals has the value and the rate of each signal; only values are used.
    The gains of the law are an argument if `by_gains` is True.
    """
    values = ", ".join(f"recorded[{2 * i}]" for i in range(signals))
    taken, given = "", ""
    if by_gains:
        taken, given = "const double *gains, ", "gains, "
    return (
        "static inline void start_of(double reference, double measured, const double *recorded, "
        f"{taken}double *memory)\n"
        f"{{\n    control_start(reference, measured, {values}, {given}memory);\n}}\n"
    )


def _unpacked(port: Input, used: set[str]) -> list[str]:
    """Return the lines that assign the used elements of an argument to names.

    For an argument without used elements, the line tells the compiler that it is unused.
    """
    if _is_scalar(port):
        return [] if port.name in used else [f"    (void){port.name}_;"]
    lines = [
        f"    const double {element}_ = {port.name}_[{index}];"
        for index, element in enumerate(port.elements)
        if element in used
    ]
    return lines or [f"    (void){port.name}_;"]


def _is_scalar(port: Input) -> bool:
    """Return True for a scalar argument, whose only element has its name."""
    return port.elements == (port.name,)


def print_c99(export: FeedForward) -> str:
    """Return the text of a C file with the functions for force and control."""
    force, control = export.functions
    arguments = ", ".join(f"double {name}_" for name in export.motion)
    passed = ", ".join(f"{name}_" for name in export.motion)
    constants = [
        f"    static const double {c.name}_ = {c.value!r}; /* {comment(c.comment)} */"
        for c in export.constants
    ]
    ports = [*export.motion, *(c.name for c in export.constants)]
    functions = "\n".join(
        (
            f"/* {comment(export.force.summary)} */\ndouble {force}({arguments})\n{{",
            *constants,
            *_body(export.force, ports),
            f"}}\n\n/* {comment(export.control.summary)} */\ndouble {control}({arguments})\n{{",
            f"    const double tau_ = {force}({passed});",
            *_body(export.control, ["tau"]),
            "}\n",
        )
    )
    helpers = print_c_helpers(functions)
    # The names of helpers begin with that of the function: other code may have a `select`.
    for name in re.findall(r"static inline double (\w+)\(", helpers):
        helpers, functions = (
            re.sub(rf"\b{name}\(", f"{force}_{name}(", text) for text in (helpers, functions)
        )
    about = "\n   ".join(map(comment, export.about))
    units = ", ".join(f"{name} in {unit}" for name, unit in export.motion.items())
    return (
        f"/* {about}\n*/\n\n#include <math.h>\n\n"
        + (f"{helpers}\n" if helpers else "")
        + f"/* {comment(units)}. */\n"
        f"double {force}({arguments});\ndouble {control}({arguments});\n\n{functions}"
    )


def _body(program: Program, elements: list[str]) -> list[str]:
    """Return the lines of a function: unused arguments, operations, and its return."""
    texts, lines = print_operations(program, C)
    used = {op.symbol for op in program.operations if op.name == "input"}
    unused = [f"    (void){name}_;" for name in elements if name not in used]
    return [*unused, *lines, f"    return {texts[program.outputs[0].rows[0][0]]};"]


#: Parts in the order of the text; each calls those before it.
_PARTS = ("sections.c", "motion.c", "rows.c", "products.c", "turns.c")
_FILTER = ("sections.c", "filter.c")
_HEADERS = "#include <math.h>\n#include <stddef.h>\n#include <stdint.h>\n#include <string.h>\n"


def print_c_lanes(native: str, parameters: int) -> str:
    """Return the C text that makes regression rows of many simulations of an axis.

    Parameters
    ----------
    native : str
        Native code of the axis, with the functions of one sample first.
    parameters : int
        Number of parameters.
    """
    functions = native[: native.index("\nvoid ")]
    functions = re.sub(r"^#include .*\n", "", functions, flags=re.MULTILINE)
    known = int(has_known_part(native))
    sizes = f"#define WIDE 8\n#define PARAMETERS {parameters}\n#define KNOWN {known}\n"
    return f"{_HEADERS}{sizes}\n{functions}\n{_joined('batched_rows', _PARTS)}"


def print_c_filter() -> str:
    """Return the C text that filters columns, independent of an axis."""
    return f"{_HEADERS}#define WIDE 4\n\n{_joined('batched_rows', _FILTER)}"


def _joined(name: str, parts: Iterable[str]) -> str:
    """Return the joined text of the files `parts` in the folder `name` next to this module."""
    folder = resources.files(__package__) / name
    return "".join((folder / part).read_text() for part in parts)


def has_known_part(native: str) -> bool:
    """Return True if the inverse model of native code has a part that no parameter scales."""
    begin = native.index("static inline void idm_regressor(")
    return "known_out[0] = 0.0;" not in native[begin : native.index("\n}\n", begin)]
