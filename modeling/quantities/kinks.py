"""`Max`, `Min` and their like, made without asking SymPy which argument is the larger.

SymPy asks that of every pair, and of all that is nested in them, each time such an expression is
made again. What was declared is in its final form already.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import sympy
from sympy.functions.elementary.miscellaneous import Max, Min


def extreme(kind: Any, arguments: Sequence[sympy.Expr]) -> sympy.Expr:
    """The largest or smallest of expressions; of the numbers among them, at once."""
    numbers = [argument for argument in arguments if argument.is_Number]
    others = [argument for argument in arguments if not argument.is_Number]
    if numbers:
        others.append(kind(*numbers))
    return kind(*others, evaluate=False)


def within(value: sympy.Expr, limit: sympy.Expr) -> sympy.Expr:
    """A value clipped at plus and minus a limit."""
    return extreme(Max, [extreme(Min, [value, limit]), -limit])


def replaced(value: sympy.Basic, new: Mapping[sympy.Basic, sympy.Basic]) -> sympy.Basic:
    """The same as ``value.xreplace(new)``, but that ``Max`` and ``Min`` stay as they are."""

    def made(node: sympy.Basic, arguments: Sequence[sympy.Basic]) -> sympy.Basic:
        is_extreme = isinstance(node, (Max, Min))
        return extreme(node.func, arguments) if is_extreme else node.func(*arguments)

    return _rebuilt(value, dict(new), made)


def renamed(value: sympy.Expr, new: Mapping[sympy.Basic, sympy.Basic]) -> sympy.Expr:
    """The same with other symbols or numbers, no function of them worked out."""

    def made(node: sympy.Basic, arguments: Sequence[sympy.Basic]) -> sympy.Basic:
        plain = {"evaluate": False} if isinstance(node, (sympy.Function, Max, Min)) else {}
        return node.func(*arguments, **plain)

    return _rebuilt(value, dict(new), made)


def _rebuilt(
    node: sympy.Basic,
    known: dict[sympy.Basic, sympy.Basic],
    made: Callable[[sympy.Basic, Sequence[sympy.Basic]], sympy.Basic],
) -> sympy.Basic:
    """A node made again of what its arguments become, each once wherever it occurs."""
    if node not in known:
        arguments = [_rebuilt(argument, known, made) for argument in node.args]
        same = all(one is other for one, other in zip(arguments, node.args, strict=True))
        known[node] = node if same else made(node, arguments)
    return known[node]
