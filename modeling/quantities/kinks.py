"""`Max`, `Min` and their like, made without asking SymPy which argument is the larger.

SymPy asks that of every pair, and of all that is nested in them, each time such an expression is
made again. What was declared is in its final form already.
"""

from collections.abc import Mapping, Sequence
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
    return _Replacement(new)(value)


class _Replacement:
    """Replaces nodes, each once wherever it occurs."""

    def __init__(self, new: Mapping[sympy.Basic, sympy.Basic]) -> None:
        self._made = dict(new)

    def __call__(self, node: sympy.Basic) -> sympy.Basic:
        if node not in self._made:
            arguments = [self(argument) for argument in node.args]
            same = all(one is other for one, other in zip(arguments, node.args, strict=True))
            self._made[node] = node if same else self._rebuilt(node, arguments)
        return self._made[node]

    def _rebuilt(self, node: sympy.Basic, arguments: Sequence[sympy.Basic]) -> sympy.Basic:
        if isinstance(node, (Max, Min)):
            return extreme(node.func, arguments)
        return node.func(*arguments)


class _Renaming(_Replacement):
    """Replaces symbols by others, so that no function can come out another."""

    def _rebuilt(self, node: sympy.Basic, arguments: Sequence[sympy.Basic]) -> sympy.Basic:
        if isinstance(node, (sympy.Function, Max, Min)):
            return node.func(*arguments, evaluate=False)
        return node.func(*arguments)


def renamed(value: sympy.Expr, new: Mapping[sympy.Basic, sympy.Basic]) -> sympy.Expr:
    """The same with other symbols or numbers, no function of them worked out."""
    return _Renaming(new)(value)
