"""Whether a force jumps where the velocity passes a value.

Steps and choices may still join continuously: ``(dq - v) Heaviside(dq - v)``, or a friction law in
pieces. The values beside each edge are compared in many digits, for numbers in place of all other
symbols that have nothing to do with each other: what is equal there is equal everywhere, but for a
coincidence.
"""

import contextlib
from collections.abc import Iterator
from functools import partial
from random import Random
from typing import Any

import sympy
from sympy.core.relational import Relational

from axisid.modeling.quantities import DIRECTION

from .point_value import CANNOT, numbers, value_at, zero

_POINTS = 6
_STARTS = (-1.5, 0.5)  # velocities from which an edge is looked for, also one of either sign
_BESIDE = numbers.mpf("1e-30")
_ROUNDING = 1e-12  # what decimals leave, as a share of the force
_AT_REST = numbers.mpf(3) / 7  # the direction on both sides of rest


def jumping_node(force: sympy.Expr, velocity: sympy.Symbol) -> sympy.Expr | None:
    """The first step or choice at which the force jumps with the velocity; None if there is none.

    An edge that cannot be found is taken for a jump.

    Parameters
    ----------
    force : sympy.Expr
        By the friction direction: at rest it is continuous if it is with the same direction.
    velocity : sympy.Symbol
    """
    kinds = (sympy.sign, sympy.Heaviside, sympy.Piecewise)
    nodes = {node: list(_edges(node, velocity)) for node in force.atoms(*kinds)}
    nodes = {node: edges for node, edges in nodes.items() if edges}
    terms = [term for term in sympy.Add.make_args(force) if term.atoms(*kinds) & nodes.keys()]
    for node in sorted(nodes, key=sympy.default_sort_key):
        if not all(_is_continuous(sympy.Add(*terms), velocity, edge) for edge in nodes[node]):
            return node
    return None


def _edges(node: sympy.Expr, velocity: sympy.Symbol) -> Iterator[sympy.Expr]:
    """Functions whose zeros are where a step or a choice may jump with the velocity."""
    if not isinstance(node, sympy.Piecewise):
        inside = [node.args[0]]
    else:
        relations = (r for _, condition in node.args for r in condition.atoms(Relational))
        inside = [relation.lhs - relation.rhs for relation in relations]
    yield from (edge for edge in inside if velocity in edge.free_symbols)


def _is_continuous(force: sympy.Expr, velocity: sympy.Symbol, edge: sympy.Expr) -> bool:
    """Whether a force has the same value on both sides of an edge, wherever that was found."""
    others = sorted((force.free_symbols | edge.free_symbols) - {velocity, DIRECTION}, key=str)
    jumps: list[float] = []
    for turn in range(_POINTS):
        source = Random(turn)  # noqa: S311
        signs = (1,) if turn < 2 else (1, -1)  # first positive, then of either sign
        point: dict[sympy.Symbol, Any] = {
            s: source.choice(signs) * source.uniform(0.5, 1.5) for s in others
        }

        def of(what: sympy.Expr, place: Any, *, point: Any = point) -> Any:
            return value_at(what, {**point, velocity: place})

        for start in _STARTS:
            with contextlib.suppress(*CANNOT):
                place = zero(partial(of, edge), start)
                beside, apart = _BESIDE * max(abs(place), 1), 1 + abs(place)
                if of(edge, place + beside) * of(edge, place - beside) > 0:
                    continue
                point[DIRECTION] = numbers.sign(place) if abs(place) > beside else _AT_REST
                steps = (beside, -beside, apart, -apart)
                above, below, *far = (of(force, place + step) for step in steps)
                size = max(map(abs, (above, below, *far)))
                jumps.append(float(abs(above - below) / (size or 1)))
    return bool(jumps) and max(jumps) < _ROUNDING
