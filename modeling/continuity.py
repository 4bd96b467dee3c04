"""Whether a force jumps where the velocity passes a value.

Steps and choices may still join continuously: ``(dq - v) Heaviside(dq - v)``, or a friction law in
pieces. The values beside each edge are compared in many digits, for numbers in place of all other
symbols that have nothing to do with each other: what is equal there is equal everywhere, but for a
coincidence.
"""

from collections.abc import Iterator

import sympy
from sympy.core.relational import Relational

from .independence import exact
from .symbols import DIRECTION

_POINTS, _PLACES = 6, 101  # a prime, through whose fractions the points walk
_DIGITS, _BESIDE = 60, sympy.Float("1e-30", 60)
_ROUNDING = 1e-12  # what decimals leave, as a share of the force
_AT_REST = sympy.Rational(3, 7)  # the direction on both sides of rest


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
    force, edge = exact(force), exact(edge)
    others = sorted((force.free_symbols | edge.free_symbols) - {velocity, DIRECTION}, key=str)
    jumps: list[float] = []
    for i in range(_POINTS):
        point = _point(others, i)
        there = force.xreplace(point)
        found = [_jump(there, velocity, v) for v in _places(edge.xreplace(point), velocity)]
        jumps += [jump for jump in found if jump is not None]
    return bool(jumps) and max(jumps) < _ROUNDING


def _point(symbols: list[sympy.Symbol], i: int) -> dict[sympy.Symbol, sympy.Rational]:
    """Numbers of sizes from a hundredth to ten; first all positive, then of either sign."""
    steps = [(j + 2) * (7 * i + 37) % _PLACES for j in range(len(symbols))]
    signs = [-1 if i > 1 and step % 2 else 1 for step in steps]
    return {
        s: sign * sympy.Rational(10 + step * step, 1000)
        for s, step, sign in zip(symbols, steps, signs, strict=True)
    }


def _places(edge: sympy.Expr, velocity: sympy.Symbol) -> Iterator[sympy.Float]:
    """Zeros of a function of the velocity and its size, of the second degree or lower."""
    for ahead in (1, -1) if edge.has(sympy.Abs) else (0,):
        function = edge.xreplace({sympy.Abs(velocity): ahead * velocity})
        if not function.is_polynomial(velocity):
            continue
        coefficients = sympy.Poly(function, velocity).all_coeffs()
        for place in _roots([sympy.N(c, _DIGITS) for c in coefficients]):
            if place * ahead >= 0:
                yield place


def _roots(coefficients: list[sympy.Float]) -> list[sympy.Float]:
    """Real zeros of a polynomial of the first or the second degree."""
    match coefficients:
        case [slope, start]:
            return [-start / slope]
        case [a, b, c] if (inside := b * b - 4 * a * c) >= 0:
            return [(-b + side * sympy.sqrt(inside)) / (2 * a) for side in (1, -1)]
    return []


def _jump(force: sympy.Expr, velocity: sympy.Symbol, place: sympy.Float) -> float | None:
    """Jump of a force there, over the force's size; None where it has no value."""
    direction = sympy.sign(place) if place else _AT_REST
    beside, apart = _BESIDE * (abs(place) or 1), 1 + abs(place)
    above, below, *others = (
        sympy.N(force.xreplace({velocity: place + step, DIRECTION: direction}), _DIGITS)
        for step in (beside, -beside, apart, -apart)
    )
    if not (above.is_Number and above.is_finite and below.is_Number and below.is_finite):
        return None
    sizes = [abs(value) for value in (above, below, *others) if value.is_Number and value.is_finite]
    return float(abs(above - below) / (max(sizes) or 1))
