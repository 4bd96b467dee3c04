"""What a text may say, and what is wrong with one, and where."""

import difflib
import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import sympy
from sympy.functions.elementary.miscellaneous import Max, Min

from axisid.support.errors import UsageError

_SHOWN = 60  # characters around a mistake


class TextError(UsageError):
    """A text cannot be read.

    Parameters
    ----------
    reason : str
        A sentence.
    text : str
        All of it.
    offset : int
        Of the offending character.
    code : str
        Of the mistake.

    Attributes
    ----------
    reason, where, pointer : str
        The sentence; ``column 3``; the line of the text over a caret.
    """

    code = "formula"

    def __init__(self, reason: str, text: str, offset: int, *, code: str = "") -> None:
        place = min(max(offset, 0), len(text))
        before = text[:place].split("\n")
        line, column = len(before), len(before[-1])
        whole = text.split("\n")[line - 1]
        self.where = (f"line {line}, " if "\n" in text.strip() else "") + f"column {column + 1}"
        start = max(0, column - _SHOWN // 2)
        shown = "".join(c if c.isprintable() else "?" for c in whole[start : start + _SHOWN])
        self.pointer = f"{shown}\n{' ' * (column - start)}^" if shown.strip() else ""
        super().__init__(f"{shown.strip()!r} cannot be read at {self.where}: {reason}", code=code)
        self._given = reason, text, offset
        self.reason = reason

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), code=self.code), self._given


def nearest(name: str, names: Collection[str]) -> str:
    """The name that is most like another one, as a question; empty if none is."""
    close = difflib.get_close_matches(name[:50], list(names), 1)
    return f" Did you mean {close[0]!r}?" if close else ""


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


_FUNCTIONS = {
    "sin": Function(sympy.sin, math.sin),
    "cos": Function(sympy.cos, math.cos),
    "tan": Function(sympy.tan, math.tan),
    "asin": Function(sympy.asin, math.asin),
    "acos": Function(sympy.acos, math.acos),
    "atan": Function(sympy.atan, math.atan),
    "atan2": Function(sympy.atan2, math.atan2, 2),
    "sinh": Function(sympy.sinh, math.sinh),
    "cosh": Function(sympy.cosh, math.cosh),
    "tanh": Function(sympy.tanh, math.tanh),
    "exp": Function(sympy.exp, math.exp),
    "log": Function(sympy.log, math.log),
    "sqrt": Function(sympy.sqrt, math.sqrt),
    "abs": Function(sympy.Abs, abs),
    "sign": Function(sympy.sign, lambda x: float((x > 0) - (x < 0))),
    "min": Function(Min, min, 2),
    "max": Function(Max, max, 2),
}

#: Of every expression in a TOML declaration; code is generated for each of its functions.
DYNAMICS = Grammar(
    what="an expression",
    names="name",
    functions=_FUNCTIONS,
    nodes=frozenset({sympy.Add, sympy.Mul, sympy.Pow, *(f.symbolic for f in _FUNCTIONS.values())}),
    longest=2000,
)


def not_allowed(piece: str, grammar: Grammar, text: str, offset: int, hint: str = "") -> TextError:
    """What is said of a piece of text that no expression has."""
    return TextError(
        f"{piece!r} cannot be used in {grammar.what}; write numbers, {grammar.names}s, pi, "
        f"+ - * / **, parentheses and functions such as sqrt(...){hint}.",
        text,
        offset,
    )


def nested(text: str, offset: int) -> TextError:
    """What is said of a text that is nested too deeply."""
    return TextError(
        f"it is nested deeper than {DEEPEST} levels; write it flatter.",
        text,
        offset,
    )
