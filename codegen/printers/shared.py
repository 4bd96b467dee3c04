"""Shared parts of the printers: operations to expressions of one language.

An operation that is used once is written where it is used; one that is used more often gets a name
that starts with an underscore, which no declared name does.
"""

import re
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from unicodedata import combining, normalize

from axisid.codegen.lowering import Operation, Program

Text = tuple[str, int]  # an expression, and the strength of its binding

_INFIX = {"add": ("+", 1), "sub": ("-", 1), "mul": ("*", 2), "div": ("/", 2)}
_NEGATION, ATOM = 3, 4
_WIDTH = 80


class BooleanText(str):
    """Text of a number that is 1 if a condition holds and 0 otherwise.

    Attributes
    ----------
    condition : str
        Text of the condition itself.
    """

    __slots__ = ("condition",)
    condition: str

    def __new__(cls, condition: str, form: str) -> "BooleanText":
        """Insert the condition into a form, in place of ``{}``."""
        made = super().__new__(cls, form.format(condition))
        made.condition = condition
        return made


def condition(text: str, unequal: str) -> str:
    """Return the text of a number as a condition.

    It is the condition from which the number was made, otherwise ``number != 0`` in the form
    `unequal`.
    """
    return text.condition if isinstance(text, BooleanText) else unequal.format(text)


@dataclass(frozen=True, slots=True, kw_only=True)
class Language:
    """Syntax of a language for operations other than arithmetic.

    Attributes
    ----------
    calls : mapping of str to str or callable
        Function that an operation calls, or a callable that makes the call from the texts of its
        operands; if missing, the operation's own name.
    variable : callable
        Text of an argument's element by its name.
    name : callable
        Text of a line that names an expression, from name and expression.
    constant : callable
        Text of a number, from Python's.
    temporary : str
        Beginning of the name of an expression; a number follows.
    """

    calls: Mapping[str, str | Callable[..., str]]
    variable: Callable[[str], str]
    name: Callable[[str, str], str]
    constant: Callable[[str], str] = str
    temporary: str = "_"


def print_operations(program: Program, language: Language) -> tuple[list[str], list[str]]:
    """Return the text of every operation, and the lines that give names to some.

    An operation gets a name if it is used more than once, or if its text is long.
    """
    uses = Counter(i for operation in program.operations for i in operation.operands)
    uses.update(i for port in program.outputs for row in port.rows for i in row)
    texts: list[Text] = []
    lines: list[str] = []
    for index, operation in enumerate(program.operations):
        text = _expression(operation, texts, language)
        if operation.operands and (uses[index] > 1 or len(text[0]) > _WIDTH):
            name = f"{language.temporary}{len(lines)}"
            lines.append(language.name(name, text[0]))
            text = (name, ATOM)
        texts.append(text)
    return [text for text, _ in texts], lines


def _expression(operation: Operation, texts: list[Text], language: Language) -> Text:
    """Return the text of an operation from those of its operands."""
    if operation.name == "input":
        return language.variable(operation.symbol), ATOM
    if operation.name == "constant":
        negative = operation.symbol.startswith("-")
        return language.constant(operation.symbol), 0 if negative else ATOM
    operands = [texts[i] for i in operation.operands]
    if operation.name == "neg":
        return f"-{_enclosed(operands[0], _NEGATION)}", 2
    if operation.name in _INFIX:
        symbol, strength = _INFIX[operation.name]
        left, right = _enclosed(operands[0], strength), _enclosed(operands[1], strength + 1)
        return f"{left} {symbol} {right}", strength
    function = language.calls.get(operation.name, operation.name)
    arguments = [text for text, _ in operands]
    if callable(function):
        return function(*arguments), ATOM
    return f"{function}({', '.join(arguments)})", ATOM


def comment(text: str) -> str:
    """Return a text for a comment, in ASCII, that no language reads as the end of the comment."""
    letters = (c for c in normalize("NFKD", " ".join(text.split())) if not combining(c))
    plain = "".join(letters).encode("ascii", "replace").decode()
    apart = re.sub(r"[/(](?=\*)|\*(?=[/)])", r"\g<0> ", plain)
    return re.sub(r"[\x00-\x1f\x7f]", "?", apart).replace("??", "? ?").replace("\\", "/")


def distinct_names(
    names: Iterable[str],
    legal: Callable[[str], str],
    taken: Collection[str],
) -> dict[str, str]:
    """Return a legal name for each name; no two are equal, even ignoring case.

    Parameters
    ----------
    names : iterable of str
    legal : callable
        Returns the name in a form that the language permits.
    taken : collection of str
        Names in use, in lower case.
    """
    used, chosen = set(taken), {}
    for name in names:
        made, number = legal(name), 2
        while made.lower() in used:
            made, number = f"{legal(name)}_{number}", number + 1
        used.add(made.lower())
        chosen[name] = made
    return chosen


def _enclosed(operand: Text, strength: int) -> str:
    """Return an operand's text, in parentheses if it binds less strongly than required."""
    text, own = operand
    return text if own >= strength else f"({text})"
