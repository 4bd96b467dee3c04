"""Whether a force jumps where the velocity passes a value.

Steps and choices may still join continuously: ``(dq - v) Heaviside(dq - v)``, or a friction law in
pieces. The values beside each edge are compared in many digits, for numbers in place of all other
symbols that have nothing to do with each other: what is equal there is equal everywhere, but for a
coincidence.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import sympy
from sympy.core.relational import Relational

from axisid.modeling.quantities import DIRECTION

from .point_value import CANNOT, numbers, value_at

_POINTS, _PLACES = 6, 101  # a prime, through whose fractions the points walk
_BESIDE = numbers.mpf("1e-30")
_ROUNDING = 1e-12  # what decimals leave, as a share of the force
_EXACT = numbers.mpf("1e-40")
_AT_REST = numbers.mpf(3) / 7  # the direction on both sides of rest

_Point = Mapping[sympy.Symbol, Any]  # numbers of many digits


def jumping_node(force: sympy.Expr, velocity: sympy.Symbol) -> sympy.Expr | None:
    """The first step or choice at which the force jumps with the velocity; None if there is none.

    An edge that cannot be found, as none of a quadratic function of the velocity or simpler, is
    taken for a jump.

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
    others = sorted((force.free_symbols | edge.free_symbols) - {velocity, DIRECTION}, key=str)
    jumps: list[float] = []
    for i in range(_POINTS):
        point = _point(others, i)
        found = [_jump(force, velocity, point, v) for v in _places(edge, velocity, point)]
        jumps += [jump for jump in found if jump is not None]
    return bool(jumps) and max(jumps) < _ROUNDING


def _point(symbols: list[sympy.Symbol], i: int) -> _Point:
    """Numbers of sizes from a hundredth to ten; first all positive, then of either sign."""
    steps = [(j + 2) * (7 * i + 37) % _PLACES for j in range(len(symbols))]
    signs = [-1 if i > 1 and step % 2 else 1 for step in steps]
    return {
        s: sign * numbers.mpf(10 + step * step) / 1000
        for s, step, sign in zip(symbols, steps, signs, strict=True)
    }


def _places(edge: sympy.Expr, velocity: sympy.Symbol, point: _Point) -> Iterator[Any]:
    """Zeros of a function of the velocity and its size, of the second degree or lower."""
    ways = ((0, 1, 2, 3), (0, -1, -2, -3)) if edge.has(sympy.Abs) else ((0, 1, -1, 2),)
    for speeds in ways:
        values = [_value(edge, {**point, velocity: numbers.mpf(v)}) for v in speeds]
        if None in values:
            continue
        for place in _roots(speeds, values):
            if len(ways) == 1 or place * speeds[1] >= 0:
                yield place


def _roots(speeds: Sequence[int], values: Sequence[Any]) -> list[Any]:
    """Real zeros of the polynomial through four points; none if it is of the third degree."""
    first, second, third = _divided(speeds, values)
    sizes = sum(map(abs, values))
    if abs(third) > _EXACT * sizes:
        return []
    start, here, there = values[0], *speeds[:2]
    slope = first - second * (here + there)
    if abs(second) > _EXACT * sizes:
        inside = slope * slope - 4 * second * start
        root = numbers.sqrt(inside) if inside >= 0 else None
        return [] if root is None else [(side * root - slope) / (2 * second) for side in (1, -1)]
    return [-start / slope] if slope else []


def _divided(speeds: Sequence[int], values: Sequence[Any]) -> list[Any]:
    """Newton's divided differences from the first point on."""
    row, found = list(values), []
    for gap in range(1, len(speeds)):
        row = [(row[k + 1] - row[k]) / (speeds[k + gap] - speeds[k]) for k in range(len(row) - 1)]
        found.append(row[0])
    return found


def _jump(force: sympy.Expr, velocity: sympy.Symbol, point: _Point, place: Any) -> float | None:
    """Jump of a force there, over the force's size; None where it has no value."""
    direction = numbers.sign(place) if place else _AT_REST
    beside, apart = _BESIDE * (abs(place) or 1), 1 + abs(place)
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
