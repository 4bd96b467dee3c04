"""What a text may say: its functions, its names, how long and how deep it may be."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any

from .mistakes import TextError

#: Levels that a text may be nested.
DEEPEST = 15


@dataclass(frozen=True, slots=True)
class Function:
    """A function that text may call.

    Attributes
    ----------
    symbolic : callable
        Of SymPy expressions.
    number : callable
        The same of floats.
    arguments : int
        How many.
    """

    symbolic: Callable[..., Any]
    number: Callable[..., float]
    arguments: int = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Grammar:
    """What a text may say.

    Attributes
    ----------
    what : str
        What it is, for messages: ``a function of the parameters``.
    names : str
        What its names are, for messages: ``parameter``.
    functions : mapping of str to Function
    nodes : collection of type
        SymPy classes that may come out.
    longest : int
        Characters.
    """

    what: str
    names: str
    functions: Mapping[str, Function]
    nodes: Collection[Any]
    longest: int


def not_allowed(piece: str, grammar: Grammar, text: str, offset: int, hint: str = "") -> TextError:
    """What is said of a piece of text that no expression has."""
    return TextError(
        f"{piece!r} cannot be used in {grammar.what}; write numbers, {grammar.names}s, pi, "
        f"+ - * / **, parentheses and functions such as sqrt(...){hint}.",
        text,
        offset,
        code="text-not-allowed",
    )


def nested(text: str, offset: int) -> TextError:
    """What is said of a text that is nested too deeply."""
    return TextError(
        f"it is nested deeper than {DEEPEST} levels; write it flatter.",
        text,
        offset,
        code="text-nested",
    )
