"""Differentiate expressions with kinks, and find jumps of expressions.

SymPy differentiates a kink (`Max`, `Min`, `Abs`) to a step (``Heaviside``, ``sign``) and a step to
an impulse (``DiracDelta``). A step is 1/2 (a sign 0) at the kink, so that the slope there is the
mean of the slopes on both sides.

An expression with steps or pieces may still be continuous: ``(dq - v) Heaviside(dq - v)``, or a
friction law in pieces. The values on both sides of each *edge*, where a step or a piece begins, are
compared in many digits, with independent numbers in place of all other symbols: values that are
equal there are equal everywhere, except by coincidence.
"""

import contextlib
import math
from collections.abc import Iterator, Mapping
from itertools import permutations
from typing import Any

import sympy
from sympy.core.relational import Relational
from sympy.functions.elementary.miscellaneous import Max, Min

from axisid.support.errors import ModelError

from .constants import extreme
from .point_value import CANNOT, deciding, drawn, float_at, numbers, value_at, zero
from .symbols import DIRECTION

_POINTS = 6
_STARTS = (-1.5, 0.5)  # velocities from which an edge is searched, one of either sign
_RELATIVE_DISTANCE = numbers.mpf("1e-30")  # of the sides of an edge, relative to its velocity
_ROUNDING = 1e-12  # jump due to rounded decimals, as a share of the force
_AT_REST = numbers.mpf(3) / 7  # friction direction on both sides of rest

_Point = Mapping[sympy.Symbol, Any]  # numbers of many digits


def jumping_node(force: sympy.Expr, velocity: sympy.Symbol) -> sympy.Expr | None:
    """Return the first step or choice at which the force jumps with the velocity; None without one.

    An edge that cannot be found is treated as a jump.

    Parameters
    ----------
    force : sympy.Expr
        Force as a function of the friction direction. At rest it counts as continuous if it is
        continuous for the same direction on both sides.
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
    """Yield functions of the velocity that are 0 where a step or a Piecewise may jump."""
    kinks = node.atoms(Relational) if isinstance(node, sympy.Piecewise) else [node]
    yield from (x for kink in kinks for x in deciding(kink) if velocity in x.free_symbols)


def _is_continuous(force: sympy.Expr, velocity: sympy.Symbol, edge: sympy.Expr) -> bool:
    """Return whether a force has equal values on both sides of an edge.

    The edge is where the function `edge` of the velocity is 0. It is searched at several points of
    the other symbols. The result is False if no edge is found.
    """
    others = (force.free_symbols | edge.free_symbols) - {velocity, DIRECTION}
    jumps: list[float] = []
    for turn in range(_POINTS):
        point = {s: _number(s, turn) for s in others}
        jumps += [_jump(force, velocity, point, v) for v in _places(edge, velocity, point)]
    found = [jump for jump in jumps if not math.isnan(jump)]
    return bool(found) and max(found) < _ROUNDING


def _number(symbol: sympy.Symbol, turn: int) -> Any:
    """Return a number for a symbol at point `turn`: positive at the first two, then of any sign."""
    turned = turn > 1 and drawn(turn, "turned", symbol.name) < 1
    return -drawn(turn, symbol.name) if turned else drawn(turn, symbol.name)


def _places(edge: sympy.Expr, velocity: sympy.Symbol, point: _Point) -> list[Any]:
    """Return the velocities at which a function changes its sign, as far as they are found.

    Parameters
    ----------
    edge : sympy.Expr
        The function.
    velocity : sympy.Symbol
    point : mapping of sympy.Symbol to number
        Numbers of all other symbols.
    """
    found: list[Any] = []

    def value(place: Any) -> Any:
        """Return the function at a velocity."""
        return value_at(edge, {**point, velocity: place})

    for start in _STARTS:
        with contextlib.suppress(*CANNOT):
            place = zero(value, numbers.mpf(start))
            distance = _distance(place)
            is_known = any(abs(place - other) < distance for other in found)
            if not is_known and value(place + distance) * value(place - distance) <= 0:
                found.append(place)
    return found


def _distance(place: Any) -> Any:
    """Return the distance from a velocity at which the two sides of an edge are evaluated."""
    return _RELATIVE_DISTANCE * max(abs(place), 1)


def _jump(force: sympy.Expr, velocity: sympy.Symbol, point: _Point, place: Any) -> float:
    """Return the jump of a force at a velocity, relative to the size of the force nearby.

    It is NaN if the force has no value there.
    """
    distance, far = _distance(place), 1 + abs(place)
    direction = numbers.sign(place) if abs(place) > distance else _AT_REST
    above, below, *others = (
        float_at(force, {**point, velocity: place + step, DIRECTION: direction})
        for step in (distance, -distance, far, -far)
    )
    sizes = [abs(value) for value in (above, below, *others) if not math.isnan(value)]
    return abs(above - below) / (max(sizes, default=0.0) or 1.0)


def slope(value: sympy.Expr, variable: sympy.Symbol, what: str) -> sympy.Expr:
    """Return the derivative of a continuous expression.

    Parameters
    ----------
    value : sympy.Expr
    variable : sympy.Symbol
    what : str
        Description of the expression, for messages.

    Raises
    ------
    ModelError
        The expression jumps at some value of the variable.
    """
    derivative = _derivative(value, variable, {})
    impulses = derivative.atoms(sympy.DiracDelta)
    for impulse in impulses:
        if not _is_continuous(value, variable, impulse.args[0]):
            raise ModelError(
                f"{what} jumps with {variable} where {impulse.args[0]} is 0, so it has no "
                f"derivative: see {value}. Write a continuous expression, such as max(0, x)**2 for "
                "a one-sided spring.",
                code="equation",
            )
    derivative = derivative.xreplace(dict.fromkeys(impulses, sympy.S.Zero))
    return derivative.replace(
        lambda node: node.is_Mul and node.has(sympy.Heaviside), _without_needless_steps
    )


def plain_slope(value: sympy.Expr, variable: sympy.Symbol) -> sympy.Expr:
    """Return the derivative of an expression, without the impulses at its jumps."""
    derivative = _derivative(value, variable, {})
    return derivative.xreplace(dict.fromkeys(derivative.atoms(sympy.DiracDelta), sympy.S.Zero))


def _derivative(
    value: sympy.Expr, variable: sympy.Symbol, known: dict[sympy.Expr, sympy.Expr]
) -> sympy.Expr:
    """Return a derivative by the chain rule; the derivative of each node is computed once.

    Before SymPy differentiates, each node with a kink is replaced by a symbol, because SymPy would
    try to decide which argument is the larger, and whether the arguments are real.

    Parameters
    ----------
    value : sympy.Expr
    variable : sympy.Symbol
    known : dict of sympy.Expr to sympy.Expr
        Derivatives computed so far, by node; new derivatives are added.
    """
    if variable not in value.free_symbols:
        return sympy.S.Zero
    if value not in known:
        product = value.is_Mul and any(factor.is_Pow for factor in value.args)
        power = value.is_Pow and variable not in value.exp.free_symbols
        if product or power or isinstance(value, _KINKS):
            slopes = {argument: _derivative(argument, variable, known) for argument in value.args}
            terms = [s * _partial(value, argument) for argument, s in slopes.items() if s != 0]
            known[value] = sympy.Add(*terms)
        else:
            kinks = {node: sympy.Dummy(real=True) for node in _outermost_kinks(value)}
            outer = value.xreplace(kinks)
            slopes = {size: _derivative(node, variable, known) for node, size in kinks.items()}
            terms = [outer.diff(size) * s for size, s in slopes.items() if s != 0]
            inside = {size: node for node, size in kinks.items()}
            known[value] = sympy.Add(outer.diff(variable), *terms).xreplace(inside)
    return known[value]


def _partial(value: sympy.Expr, argument: sympy.Expr) -> sympy.Expr:
    """Return the derivative of a product, power or kink with respect to one of its arguments."""
    others = [other for other in value.args if other != argument]
    if value.is_Mul:
        return sympy.Mul(*others)
    if value.is_Pow:
        # SymPy writes base**exp / base, which has no value where the base is 0.
        return value.exp * value.base ** (value.exp - 1)
    if isinstance(value, (Max, Min)):
        sign = 1 if isinstance(value, Max) else -1
        return sympy.Heaviside(sign * (argument - extreme(value.func, others)), evaluate=False)
    return _RATES[value.func](argument)


_RATES = {
    sympy.Abs: sympy.sign,
    sympy.sign: lambda inside: 2 * sympy.DiracDelta(inside, evaluate=False),
    sympy.Heaviside: lambda inside: sympy.DiracDelta(inside, evaluate=False),
}
_KINKS = (Max, Min, *_RATES)


def _outermost_kinks(value: sympy.Expr) -> Iterator[sympy.Expr]:
    """Yield the kinks of an expression that are not inside other kinks."""
    walk = sympy.preorder_traversal(value)
    for node in walk:
        if isinstance(node, _KINKS):
            walk.skip()
            yield node


def _without_needless_steps(product: sympy.Mul) -> sympy.Expr:
    """Return a product with ``Max(0, x)`` in place of ``Heaviside(x) Max(0, x)``.

    The same applies to ``Heaviside(-x) Min(0, x)``.
    """
    powers = [factor.as_base_exp() for factor in product.args]
    hinges = [base for base, exponent in powers if exponent.is_positive]
    needless = {
        sympy.Heaviside(sign * inside)
        for kind, sign in ((Max, 1), (Min, -1))
        for hinge in hinges
        if isinstance(hinge, kind) and len(hinge.args) == 2
        for inside, other in permutations(hinge.args)
        if other.is_zero
    }
    return sympy.Mul(*(base**e for base, e in powers if base not in needless))
