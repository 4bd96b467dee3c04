"""Expressions that a user writes as text, read without running anything.

Text passes a whitelist of characters, Python's parser, and a whitelist of syntax; what it names
must be declared. Length, nesting, powers and what expanding it would give are bounded, so that no
text takes long. Every refusal says where.
"""

import ast
import re
from collections.abc import Mapping
from types import MappingProxyType

import sympy

from .element_calls import Elements
from .expression_reader import ExpressionReader
from .grammar import DEEPEST, Grammar, nested, not_allowed
from .mistakes import TextError

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<name>[A-Za-z_]\w*)"
    r"|(?P<mark>\*\*|[-+*/(),=])|(?P<other>.))",
    re.ASCII | re.DOTALL,
)
_OPEN_ENDED = ("+", "-", "*", "/", "**", ",", "=")


def read_expression(
    text: str,
    symbols: Mapping[str, sympy.Symbol],
    grammar: Grammar,
    elements: Elements = MappingProxyType({}),
) -> sympy.Expr:
    """Return the expression that a text says.

    Parameters
    ----------
    text : str
    symbols : mapping of str to sympy.Symbol
        What it may name, beside ``pi``.
    grammar : Grammar
    elements : mapping of str to callable, optional
        Friction and loads that it may call; none by default.

    Raises
    ------
    TextError
        It says something else, or too much.
    """
    if len(text) > grammar.longest:
        raise TextError(
            f"it has {len(text)} characters; write {grammar.longest} or fewer.",
            text,
            grammar.longest,
        )
    if not text.strip():
        raise TextError("it is empty.", text, 0)
    _check_characters(text, grammar, has_elements=bool(elements))
    flat = re.sub(r"\s", " ", text)
    start = len(flat) - len(flat.lstrip())
    try:
        tree = ast.parse(flat.strip(), mode="eval").body
    except SyntaxError as error:
        raise TextError(
            "an operator, a number or a name is missing here.",
            text,
            start + (error.offset or 1) - 1,
        ) from error
    except (RecursionError, MemoryError, ValueError) as error:
        raise nested(text, 0) from error
    return ExpressionReader(text, start, symbols, grammar, elements).read(tree)


def _check_characters(text: str, grammar: Grammar, *, has_elements: bool) -> None:
    """Let only numbers, names, operators and balanced parentheses through.

    An equals sign names an argument of an element.
    """
    opened: list[int] = []
    piece = ""
    for token in _TOKEN.finditer(text.rstrip(" \t\r\n\f\v")):
        kind, offset = token.lastgroup, token.start(token.lastgroup or 0)
        piece, following = token[kind or 0], text[token.end() : token.end() + 1]
        if kind == "other" or (piece == "=" and not (has_elements and opened)):
            hint = "; write ** for a power" if piece == "^" else ""
            raise not_allowed(piece, grammar, text, offset, hint)
        if kind == "number" and re.match(r"[\w.]", following, re.ASCII):
            raise TextError(
                f"{piece + following!r} cannot be used: a number runs into what follows; write "
                f"an operator between, as in {piece}*{following}.",
                text,
                offset,
            )
        if piece == "(":
            opened.append(offset)
        if piece == ")" and not opened:
            raise TextError("this parenthesis was never opened.", text, offset)
        if piece == ")":
            opened.pop()
        if len(opened) > 3 * DEEPEST:
            raise nested(text, offset)
    if opened:
        raise TextError("this parenthesis is never closed.", text, opened[-1])
    if piece in _OPEN_ENDED:
        raise TextError("it ends too early.", text, len(text.rstrip()))
