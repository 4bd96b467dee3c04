"""Programs to Python text that builds CasADi functions.

The text is committed and reviewed, and it is the text that runs: `execute` runs what is printed
here.
"""

from axisid.codegen.lowering import OPERATIONS, Output, Program

from .shared import Language, print_operations

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
    return f'"{name}"'
