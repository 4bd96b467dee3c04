"""Python text of programs: builders of CasADi functions, and the feed-forward in plain Python.

The text that builds CasADi functions is committed and reviewed, and it is the text that runs. The
feed-forward needs only ``math``, and returns the same values as in C, also where Python raises.
"""

import re
from dataclasses import replace

from axisid.codegen.lowering import OPERATIONS, FeedForward, Operation, Output, Program

from .shared import BooleanText, Language, comment, condition, distinct_names, print_operations

_RENAMED = {
    "pow": "power",
    "abs": "fabs",
    "min": "fmin",
    "max": "fmax",
    "not": "logic_not",
    "and": "logic_and",
    "or": "logic_or",
    "select": "if_else",
}
_PYTHON = Language(
    calls={name: f"casadi.{_RENAMED.get(name, name)}" for name in OPERATIONS},
    variable=lambda element: element,
    name=lambda name, expression: f"    {name} = {expression}",
)


def print_function(program: Program) -> str:
    """Return the text of a Python function that builds one CasADi function."""
    texts, body = print_operations(program, _PYTHON)
    lines = [
        f"def {program.name}() -> casadi.Function:",
        f'    """{program.summary} {program.operation_count} operations."""',
    ]
    for port in program.inputs:
        if port.elements == (port.name,):
            lines.append(f'    {port.name} = casadi.SX.sym("{port.name}")')
        else:
            lines.append(f'    {port.name} = casadi.SX.sym("{port.name}", {len(port.elements)})')
            lines += [
                f"    {element} = {port.name}[{index}]"
                for index, element in enumerate(port.elements)
            ]
    lines += body
    lines += [f"    _{port.name} = {_matrix(port, texts)}" for port in program.outputs]
    inputs = [port.name for port in program.inputs]
    outputs = [port.name for port in program.outputs]
    lines += [
        "    return casadi.Function(",
        f'        "{program.name}",',
        f"        [{', '.join(inputs)}],",
        f"        [{', '.join('_' + name for name in outputs)}],",
        f"        [{', '.join(map(_quoted, inputs))}],",
        f"        [{', '.join(map(_quoted, outputs))}],",
        "    )",
    ]
    return "\n".join(lines) + "\n"


def _matrix(port: Output, texts: list[str]) -> str:
    """Return the text of a result as a CasADi scalar, row, column or matrix."""
    rows = [[texts[i] for i in row] for row in port.rows]
    if not rows:
        return "casadi.SX(0, 1)"
    if len(rows) == 1:
        return rows[0][0] if len(rows[0]) == 1 else f"casadi.horzcat({', '.join(rows[0])})"
    if len(rows[0]) == 1:
        return f"casadi.vertcat({', '.join(row[0] for row in rows)})"
    inner = "".join(f"        casadi.horzcat({', '.join(row)}),\n" for row in rows)
    return f"casadi.vertcat(\n{inner}    )"


def _quoted(name: str) -> str:
    """Return a name in double quotes."""
    return f'"{name}"'


_NUMBER = "float({})"
#: Functions that the text calls, and helpers, which begin with an underscore unlike declared names.
_TAKEN = frozenset({"abs", "any", "float", "hasattr", "math", "numpy", "tau"})
_EACH = '''\
def _each(function, *motion):
    """Return values for arrays, element by element, with NumPy."""
    import numpy

    with numpy.errstate(all="ignore"):
        return numpy.vectorize(function, otypes=[float])(*motion)
'''
# Values of C where Python raises. A division by a number other than 0 needs no helper.
_HELPERS = {
    "quotient": '''\
def _quotient(a, b):
    """Return a / b, infinite or NaN if b is 0."""
    if b:
        return a / b
    return math.copysign(math.inf, a) * math.copysign(1.0, b) if a and a == a else math.nan
''',
    "power": '''\
def _power(a, b):
    """Return a to the power of b, infinite or NaN where Python raises."""
    odd = math.isfinite(b) and math.fmod(b, 2.0) in (1.0, -1.0)
    try:
        return math.pow(a, b)
    except OverflowError:
        return -math.inf if a < 0.0 and odd else math.inf
    except ValueError:
        return math.nan if a else math.copysign(math.inf, a) if odd else math.inf
''',
    "exp": '''\
def _exp(a):
    """Return the function's value, infinite if it is too large."""
    try:
        return math.exp(a)
    except OverflowError:
        return math.inf
''',
    "sinh": '''\
def _sinh(a):
    """Return the function's value, infinite if it is too large."""
    try:
        return math.sinh(a)
    except OverflowError:
        return math.copysign(math.inf, a)
''',
    "cosh": '''\
def _cosh(a):
    """Return the function's value, infinite if it is too large."""
    try:
        return math.cosh(a)
    except OverflowError:
        return math.inf
''',
    "log": '''\
def _log(a):
    """Return the logarithm, minus infinity at 0, NaN below."""
    return math.log(a) if a > 0.0 else math.nan if a else -math.inf
''',
    "within": '''\
def _within(function, a):
    """Return a function's value, NaN where it has none."""
    try:
        return function(a)
    except ValueError:
        return math.nan
''',
    "least": '''\
def _least(a, b):
    """Return the smaller number; NaN is not chosen."""
    return a if a < b or b != b else b
''',
    "largest": '''\
def _largest(a, b):
    """Return the larger number; NaN is not chosen."""
    return a if a > b or b != b else b
''',
}
_HELPED = {"quotient": "_quotient", "pow": "_power", "min": "_least", "max": "_largest"} | {
    name: f"_{name}" for name in ("exp", "sinh", "cosh", "log")
}
_WITHIN = ("sqrt", "sin", "cos", "tan", "asin", "acos")  # functions without a value everywhere


def print_python(export: FeedForward) -> str:
    """Return the text of a Python module with the two functions."""
    force, control = export.functions
    taken = {*_TAKEN, force.lower(), control.lower()}
    names = distinct_names([*export.motion, *(c.name for c in export.constants)], str, taken)
    language = _language({**names, "tau": "tau"})
    about = "\n".join(map(comment, export.about)).replace('"', "'")
    units = ", ".join(f"{names[name]} in {unit}" for name, unit in export.motion.items())
    passed = ", ".join(names[name] for name in export.motion)
    arguments = ", ".join(f"{names[name]}: float" for name in export.motion)
    constants = [f"{names[c.name]} = {c.value!r}  # {comment(c.comment)}" for c in export.constants]
    functions: list[str] = []
    for name, program, first in (
        (force, export.force, []),
        (control, export.control, [f"    tau = {force}({passed})"]),
    ):
        functions += [
            f"\n\ndef {name}({arguments}) -> float:",
            f'    """{comment(program.summary)}\n\n'
            f'    {comment(units)}; numbers or arrays.\n    """',
            f'    if any(hasattr(number, "__len__") for number in ({passed})):',
            f"        return _each({name}, {passed})",
            f"    {passed} = {', '.join(f'float({names[n]})' for n in export.motion)}",
            *first,
            *_body(program, language),
        ]
    body = "\n".join(functions)
    helpers = [text for name, text in _HELPERS.items() if re.search(rf"\b_{name}\(", body)]
    defined = "".join(f"\n\n{text}" for text in [*helpers, _EACH]).rstrip("\n")
    used = "import math\n\n" if "math." in f"{body}{defined}" else ""
    lines = "\n".join(constants)
    return f'"""{about}\n"""\n\n{used}{lines}\n{defined}\n{body}\n'


def _body(program: Program, language: Language) -> list[str]:
    """Return the lines of a function's operations and its return."""
    texts, lines = print_operations(_with_quotients(program), language)
    return [*lines, f"    return {texts[program.outputs[0].rows[0][0]]}"]


def _with_quotients(program: Program) -> Program:
    """Return a program whose divisions by a value that may be 0 are called ``quotient``."""

    def named(operation: Operation) -> Operation:
        """Return an operation, with the name ``quotient`` if it is such a division."""
        if operation.name != "div":
            return operation
        divisor = program.operations[operation.operands[1]]
        safe = divisor.name == "constant" and divisor.value
        return operation if safe else replace(operation, name="quotient")

    return replace(program, operations=tuple(map(named, program.operations)))


def _language(names: dict[str, str]) -> Language:
    """Return the syntax of plain Python, with a legal name for each argument."""
    return Language(
        calls={
            **{name: f"math.{name}" for name in OPERATIONS},
            **_HELPED,
            **{name: f"_within(math.{name}, {{}})".format for name in _WITHIN},
            "abs": "abs",
            "sign": lambda a: f"float(({a} > 0.0) - ({a} < 0.0))",
            "lt": lambda a, b: BooleanText(f"{a} < {b}", _NUMBER),
            "le": lambda a, b: BooleanText(f"{a} <= {b}", _NUMBER),
            "eq": lambda a, b: BooleanText(f"{a} == {b}", _NUMBER),
            "not": lambda a: BooleanText(f"not ({_if(a)})", _NUMBER),
            "and": lambda a, b: BooleanText(f"({_if(a)}) and ({_if(b)})", _NUMBER),
            "or": lambda a, b: BooleanText(f"({_if(a)}) or ({_if(b)})", _NUMBER),
            "select": lambda c, a, b: f"({a} if {_if(c)} else {b})",
        },
        variable=lambda element: names[element],
        name=lambda name, expression: f"    {name} = {expression}",
    )


def _if(text: str) -> str:
    """Return the condition that a number, given as text, is not 0."""
    return condition(text, "{} != 0.0")
