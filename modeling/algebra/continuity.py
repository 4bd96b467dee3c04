"""Whether a force jumps where the velocity passes a value.

Steps and choices may still join continuously: ``(dq - v) Heaviside(dq - v)``, or a friction law in
pieces. The values beside each edge are compared in many digits, for numbers in place of all other
symbols that have nothing to do with each other: what is equal there is equal everywhere, but for a
coincidence.
"""

import contextlib
from collections.abc import Iterator, Mapping
from typing import Any

import sympy
from sympy.core.relational import Relational

from axisid.modeling.quantities import DIRECTION

from .point_value import CANNOT, drawn, numbers, value_at, zero

_POINTS = 6
_STARTS = (-1.5, 0.5)  # velocities from which an edge is looked for, also one of either sign
_BESIDE = numbers.mpf("1e-30")
_ROUNDING = 1e-12  # what decimals leave, as a share of the force
_AT_REST = numbers.mpf(3) / 7  # the direction on both sides of rest

_Point = Mapping[sympy.Symbol, Any]  # numbers of many digits


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
        if velocity in node.args[0].free_symbols:
            yield node.args[0]
        return
    for _, condition in node.args:
        for relation in condition.atoms(Relational):
            if velocity in relation.free_symbols:
                yield relation.lhs - relation.rhs


def _is_continuous(force: sympy.Expr, velocity: sympy.Symbol, edge: sympy.Expr) -> bool:
    """Whether a force has the same value on both sides of an edge, wherever that was found."""
    others = (force.free_symbols | edge.free_symbols) - {velocity, DIRECTION}
    jumps: list[float] = []
    for turn in range(_POINTS):
        point = {s: _number(s, turn) for s in others}
        found = [_jump(force, velocity, point, v) for v in _places(edge, velocity, point)]
        jumps += [jump for jump in found if jump is not None]
    return bool(jumps) and max(jumps) < _ROUNDING


def _number(symbol: sympy.Symbol, turn: int) -> Any:
    """In place of a symbol, first positive, then of either sign."""
    turned = turn > 1 and drawn(turn, "turned", symbol.name) < 1
    return -drawn(turn, symbol.name) if turned else drawn(turn, symbol.name)


def _places(edge: sympy.Expr, velocity: sympy.Symbol, point: _Point) -> list[Any]:
    """Velocities at which a function changes its sign, as far as they are found."""
    found: list[Any] = []

    def value(place: Any) -> Any:
        return value_at(edge, {**point, velocity: place})

    for start in _STARTS:
        with contextlib.suppress(*CANNOT):
            place = zero(value, numbers.mpf(start))
            beside = _beside(place)
            known = any(abs(place - other) < beside for other in found)
            if not known and value(place + beside) * value(place - beside) <= 0:
                found.append(place)
    return found


def _beside(place: Any) -> Any:
    return _BESIDE * max(abs(place), 1)


def _jump(force: sympy.Expr, velocity: sympy.Symbol, point: _Point, place: Any) -> float | None:
    """Jump of a force there, over the force's size; None where it has no value."""
    beside, apart = _beside(place), 1 + abs(place)
    direction = numbers.sign(place) if abs(place) > beside else _AT_REST
    above, below, *others = (
        _value(force, {**point, velocity: place + step, DIRECTION: direction})
        for step in (beside, -beside, apart, -apart)
    )
    if above is None or below is None:
        return None
    sizes = [abs(value) for value in (above, below, *others) if value is not None]
    return float(abs(above - below) / (max(sizes) or 1))


def _value(expression: sympy.Expr, point: _Point) -> Any | None:
    try:
        return value_at(expression, point)
    except CANNOT:
        return None
