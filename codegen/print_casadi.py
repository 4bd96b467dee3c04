"""Programs to Python text that builds CasADi functions.

The text is committed and reviewed, and it is the text that runs: `load` executes what is printed
here. An operation used once stands where it is used; one used more often gets a name that starts
with an underscore, which no declared name does.
"""

from collections import Counter

from .program import Operation, Output, Program

_INFIX = {"add": ("+", 1), "sub": ("-", 1), "mul": ("*", 2), "div": ("/", 2)}
_CALLS = {
    "pow": "casadi.power",
    "abs": "casadi.fabs",
    "min": "casadi.fmin",
    "max": "casadi.fmax",
    "lt": "casadi.lt",
    "le": "casadi.le",
    "eq": "casadi.eq",
    "not": "casadi.logic_not",
    "and": "casadi.logic_and",
    "or": "casadi.logic_or",
    "select": "casadi.if_else",
}
_ATOM = 4
_WIDTH = 96


def print_function(program: Program) -> str:
    """Return the text of a Python function that builds one CasADi function."""
    names, body = _assignments(program)
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
    lines += [f"    _{port.name} = {_matrix(port, names)}" for port in program.outputs]
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


def _assignments(program: Program) -> tuple[list[tuple[str, int]], list[str]]:
    """Text and binding strength of every operation, and the lines that name the shared ones."""
    uses = Counter(i for operation in program.operations for i in operation.operands)
    uses.update(i for port in program.outputs for row in port.rows for i in row)
    texts: list[tuple[str, int]] = []
    lines: list[str] = []
    for index, operation in enumerate(program.operations):
        text, strength = _text(operation, texts)
        if operation.operands and (uses[index] > 1 or len(text) > _WIDTH):
            name = f"_{len(lines)}"
            lines.append(f"    {name} = {text}")
            text, strength = name, _ATOM
        texts.append((text, strength))
    return texts, lines


def _text(operation: Operation, texts: list[tuple[str, int]]) -> tuple[str, int]:
    if not operation.operands:
        return operation.symbol, 3 if operation.symbol.startswith("-") else _ATOM
    operands = [texts[i] for i in operation.operands]
    if operation.name == "neg":
        return f"-{_enclosed(operands[0], 3)}", 2
    if operation.name in _INFIX:
        symbol, strength = _INFIX[operation.name]
        left, right = _enclosed(operands[0], strength), _enclosed(operands[1], strength + 1)
        return f"{left} {symbol} {right}", strength
    name = _CALLS.get(operation.name, f"casadi.{operation.name}")
    return f"{name}({', '.join(text for text, _ in operands)})", _ATOM


def _enclosed(operand: tuple[str, int], strength: int) -> str:
    text, own = operand
    return text if own >= strength else f"({text})"


def _matrix(port: Output, texts: list[tuple[str, int]]) -> str:
    rows = [[texts[i][0] for i in row] for row in port.rows]
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
