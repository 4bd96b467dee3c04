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

#: Text of an expression, and the strength with which its outermost operator binds.
Text = tuple[str, int]

_INFIX = {"add": ("+", 1), "sub": ("-", 1), "mul": ("*", 2), "div": ("/", 2)}
_NEGATION, ATOM = 3, 4  # strengths of a negated operand, and of a name, a number or a call
_WIDTH = 80  # characters of an expression, above which it gets a name


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
        """Return the text `form` with the condition in place of ``{}``."""
        made = super().__new__(cls, form.format(condition))
        made.condition = condition
        return made


def condition(text: str, unequal: str) -> str:
    """Return the text of a condition that is true if a number is not 0.

    For a `BooleanText` it is the condition from which the number was made. Otherwise it is the text
    `unequal`, such as ``{} != 0.0``, with the number in place of ``{}``.
    """
    if isinstance(text, BooleanText):
        return text.condition
    return unequal.format(text)


@dataclass(frozen=True, slots=True, kw_only=True)
class Language:
    """Syntax of a language for operations other than arithmetic.

    Attributes
    ----------
    calls : mapping of str to str or callable
        By name of an operation: the function that it calls, or a callable that returns the text of
        the call for the texts of the operands. A missing operation calls a function of its name.
    variable : callable
        Returns the text of an element of an argument for the element's name.
    name : callable
        Returns the line that assigns an expression to a name, for name and expression.
    constant : callable
        Returns the text of a number for its text in Python.
    temporary : str
        Beginning of the names of expressions; a number follows.
    """

    calls: Mapping[str, str | Callable[..., str]]
    variable: Callable[[str], str]
    name: Callable[[str, str], str]
    constant: Callable[[str], str] = str
    temporary: str = "_"


def print_operations(program: Program, language: Language) -> tuple[list[str], list[str]]:
    """Return the text of every operation, and the lines that assign some of them to names.

    An operation is assigned to a name if it is used more than once, or if its text is long; its
    text is then the name.
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
    """Return the text of an operation; `texts` are those of the operations before it."""
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
    """Return a text as ASCII that no language reads as the end or the beginning of a comment."""
    letters = (c for c in normalize("NFKD", " ".join(text.split())) if not combining(c))
    plain = "".join(letters).encode("ascii", "replace").decode()
    separated = re.sub(r"[/(](?=\*)|\*(?=[/)])", r"\g<0> ", plain)
    return re.sub(r"[\x00-\x1f\x7f]", "?", separated).replace("??", "? ?").replace("\\", "/")


def distinct_names(
    names: Iterable[str],
    legal: Callable[[str], str],
    taken: Collection[str],
) -> dict[str, str]:
    """Return a legal name for each name; no two are equal, even if case is ignored.

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
    """Return an operand's text, in parentheses if it binds less strongly than `strength`."""
    text, own = operand
    return text if own >= strength else f"({text})"
