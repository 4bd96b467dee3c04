"""What a text may say: its functions, its names, how long and how deep it may be."""

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any

import sympy
from sympy.functions.elementary.miscellaneous import Max, Min

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
