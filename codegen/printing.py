"""What the printers share: operations to expressions of one language.

An operation used once stands where it is used; one used more often gets a name that starts with an
underscore, which no declared name does.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

from .program import Operation, Program

Text = tuple[str, int]  # an expression, and how strongly it binds

_INFIX = {"add": ("+", 1), "sub": ("-", 1), "mul": ("*", 2), "div": ("/", 2)}
_NEGATION, ATOM = 3, 4
_WIDTH = 80


@dataclass(frozen=True, slots=True, kw_only=True)
class Language:
    """How a language writes what is not plain arithmetic.

    Attributes
    ----------
    calls : dict of str to str
        Function that an operation calls; the operation's own name where one is missing.
    variable : callable
        Text of an argument's element by its name.
    name : callable
        Text of a line that names an expression, from name and expression.
    """

    calls: dict[str, str]
    variable: Callable[[str], str]
    name: Callable[[str, str], str]


def print_operations(program: Program, language: Language) -> tuple[list[str], list[str]]:
    """Return the text of every operation, and the lines that name those used more than once."""
    uses = Counter(i for operation in program.operations for i in operation.operands)
    uses.update(i for port in program.outputs for row in port.rows for i in row)
    texts: list[Text] = []
    lines: list[str] = []
    for index, operation in enumerate(program.operations):
        text = _expression(operation, texts, language)
        if operation.operands and (uses[index] > 1 or len(text[0]) > _WIDTH):
            name = f"_{len(lines)}"
            lines.append(language.name(name, text[0]))
            text = (name, ATOM)
        texts.append(text)
    return [text for text, _ in texts], lines


def _expression(operation: Operation, texts: list[Text], language: Language) -> Text:
    if operation.name == "input":
        return language.variable(operation.symbol), ATOM
    if operation.name == "constant":
        return operation.symbol, 0 if operation.symbol.startswith("-") else ATOM
    operands = [texts[i] for i in operation.operands]
    if operation.name == "neg":
        return f"-{_enclosed(operands[0], _NEGATION)}", 2
    if operation.name in _INFIX:
        symbol, strength = _INFIX[operation.name]
        left, right = _enclosed(operands[0], strength), _enclosed(operands[1], strength + 1)
        return f"{left} {symbol} {right}", strength
    function = language.calls.get(operation.name, operation.name)
    return f"{function}({', '.join(text for text, _ in operands)})", ATOM


def _enclosed(operand: Text, strength: int) -> str:
    text, own = operand
    return text if own >= strength else f"({text})"
