"""Order the symbols of expressions independently of their names.

Symbols are distinguished by the places where they occur, with colour refinement over the graph of
all operations: a *colour* is a digest of a symbol's occurrences. Two symbols of the same colour may
be exchanged without any change in the expressions.
"""

from collections.abc import Iterable, Sequence
from hashlib import blake2b

import sympy
from sympy.core.operations import LatticeOp
from sympy.logic.boolalg import And, Or

_ROUNDS = 3
_ANY_ORDER = (sympy.Add, sympy.Mul, LatticeOp, And, Or, sympy.Eq, sympy.Ne)


def structural_order(
    expressions: Sequence[sympy.Basic], first: Iterable[sympy.Symbol] = ()
) -> dict[sympy.Symbol, int]:
    """Return a number for each symbol of expressions, by the places where the symbol occurs.

    Parameters
    ----------
    expressions : sequence of sympy.Basic
        The order of the expressions does not matter.
    first : iterable of sympy.Symbol
        Symbols that cannot be exchanged, such as the velocity; each starts with its own colour.
    """
    nodes = _children_first(expressions)
    symbols = [node for node in nodes if node.is_Symbol]
    own = {symbol: str(place) for place, symbol in enumerate(first)}
    sign = {True: "positive", False: "not positive", None: "any"}
    colours = {s: _digest(own.get(s, ""), sign[s.is_positive]) for s in symbols}
    for _ in range(_ROUNDS):
        colours = _refined(nodes, expressions, colours)
    ordered = sorted(symbols, key=lambda symbol: (colours[symbol], symbol.name))
    return {symbol: place for place, symbol in enumerate(ordered)}


def _children_first(expressions: Sequence[sympy.Basic]) -> list[sympy.Basic]:
    """Return each node once, after all nodes that it contains."""
    found: dict[sympy.Basic, None] = {}
    stack = [(expression, False) for expression in expressions]
    while stack:
        node, ready = stack.pop()
        if ready:
            found.setdefault(node)
        elif node not in found:
            stack.append((node, True))
            stack.extend((argument, False) for argument in node.args)
    return list(found)


def _refined(
    nodes: Sequence[sympy.Basic],
    expressions: Sequence[sympy.Basic],
    colours: dict[sympy.Symbol, str],
) -> dict[sympy.Symbol, str]:
    """Return refined colours of the symbols, from their old colours and their occurrences.

    The first pass computes a digest of each node from those of its arguments. The second pass
    computes, from the outside inwards, digests of the places where each node occurs.
    """
    inside: dict[sympy.Basic, str] = {}
    for node in nodes:
        if node.is_Symbol:
            inside[node] = colours[node]
        elif not node.args:
            inside[node] = _digest(str(node))
        else:
            parts = [inside[argument] for argument in node.args]
            parts = sorted(parts) if isinstance(node, _ANY_ORDER) else parts
            inside[node] = _digest(type(node).__name__, *parts)
    around: dict[sympy.Basic, list[str]] = {node: [] for node in nodes}
    for expression in expressions:
        around[expression].append("")
    for node in reversed(nodes):
        if not node.args:
            continue
        here = _digest(inside[node], *sorted(around[node]))
        for place, argument in enumerate(node.args):
            step = "" if isinstance(node, _ANY_ORDER) else str(place)
            around[argument].append(_digest(here, step))
    return {symbol: _digest(colours[symbol], *sorted(around[symbol])) for symbol in colours}


def _digest(*parts: str) -> str:
    """Return a short digest of texts."""
    return blake2b("\n".join(parts).encode(), digest_size=12).hexdigest()
