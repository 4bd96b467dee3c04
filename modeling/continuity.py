"""Whether a force jumps where the velocity passes a value.

Steps and choices may still join continuously: ``(dq - v) Heaviside(dq - v)``, or a friction law in
pieces. The values beside each edge are compared in many digits, for numbers in place of all other
symbols that have nothing to do with each other: what is equal there is equal everywhere, but for a
coincidence.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import TypeAlias

import sympy
from sympy.core.relational import Relational

from .independence import exact
from .symbols import DIRECTION

#: Numbers for symbols.
_Point: TypeAlias = Mapping[sympy.Symbol, sympy.Expr]

_POINTS, _PLACES = 5, 101  # a prime, through whose fractions the points walk
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
    told = exact(sympy.Add(*terms))
    others = sorted(told.free_symbols - {velocity, DIRECTION}, key=str)
    points = [_point(others, i) for i in range(_POINTS)] if nodes else []
    forces = [(point, told.xreplace(point)) for point in points]
    for node in sorted(nodes, key=sympy.default_sort_key):
        if not all(_is_continuous(forces, velocity, exact(edge)) for edge in nodes[node]):
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


def _is_continuous(
    theres: Sequence[tuple[_Point, sympy.Expr]], velocity: sympy.Symbol, edge: sympy.Expr
) -> bool:
    """Whether a force has the same value on both sides of an edge, wherever that was found."""
    jumps = [
        _jump(force, velocity, place)
        for point, force in theres
        for place in _places(edge.xreplace(point), velocity)
    ]
    seen = [jump for jump in jumps if jump is not None]
    return bool(seen) and max(seen) < _ROUNDING


def _point(symbols: Sequence[sympy.Symbol], i: int) -> _Point:
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

    def at(step: sympy.Expr) -> sympy.Expr | None:
        return _value(force, {velocity: place + step, DIRECTION: direction})

    beside = _BESIDE * (abs(place) or 1)
    above, below = at(beside), at(-beside)
    if above is None or below is None:
        return None
    jump = abs(above - below)
    if jump <= _ROUNDING * abs(above):
        return 0.0
    apart = (at(step) for step in (1 + abs(place), -1 - abs(place)))
    sizes = [abs(value) for value in (above, below, *apart) if value is not None]
    return float(jump / max(sizes))


def _value(force: sympy.Expr, point: _Point) -> sympy.Expr | None:
    """A force in many digits; of a choice, only what is chosen is looked at."""
    chosen = {
        node: next((value for value, condition in node.args if _holds(condition, point)), node)
        for node in force.atoms(sympy.Piecewise)
    }
    value = sympy.N(force.xreplace(chosen).xreplace(point), _DIGITS)
    return value if value.is_Number and value.is_finite else None


def _holds(condition: sympy.Basic, point: _Point) -> bool:
    """Whether a condition holds at a point."""
    if isinstance(condition, (sympy.StrictLessThan, sympy.LessThan)):  # quicker than by SymPy
        return bool((condition.lhs - condition.rhs).xreplace(point).is_negative)
    return bool(condition.xreplace(point) == sympy.true)
