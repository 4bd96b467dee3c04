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
from .grammar import Grammar, nested, not_allowed
from .mistakes import TextError

# Of any text a number that runs into a name, such as ``2x``; and what no expression has.
_RUN_ON = re.compile(r"(?<![\w.])((?:\d++\.?+\d*+|\.\d++)(?:[eE][+-]?\d++)?+)([\w.])", re.ASCII)
_FOREIGN = re.compile(r"[^\w\s.+\-*/(),=]", re.ASCII)


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
    if foreign := _FOREIGN.search(text):
        hint = "; write ** for a power" if foreign[0] == "^" else ""
        raise not_allowed(foreign[0], grammar, text, foreign.start(), hint)
    if run_on := _RUN_ON.search(text):
        raise TextError(
            f"{run_on[0]!r} cannot be used: a number runs into what follows; write an operator "
            f"between, as in {run_on[1]}*{run_on[2]}.",
            text,
            run_on.start(),
        )
    flat = re.sub(r"\s", " ", text)
    start = len(flat) - len(flat.lstrip())
    try:
        tree = ast.parse(flat.strip(), mode="eval").body
    except SyntaxError as error:
        raise TextError(
            f"an operator, a number or a name is missing here, or too many ({error.msg}).",
            text,
            start + (error.offset or len(flat.strip()) + 1) - 1,
        ) from error
    except (RecursionError, MemoryError, ValueError) as error:
        raise nested(text, 0) from error
    return ExpressionReader(text, start, symbols, grammar, elements).read(tree)
