"""Changes of the parameters that no motion shows.

What parameters do to the force may be one function of the motion, or functions that add up to
nothing. No experiment separates them then: only combinations of them are identifiable.
"""

import contextlib
import math
from collections.abc import Iterator, Mapping, Sequence, Set as AbstractSet
from fractions import Fraction
from functools import reduce
from typing import TypeAlias

import sympy
from sympy import QQ
from sympy.polys.domains import PolynomialRing
from sympy.polys.matrices import DomainMatrix
from sympy.polys.rings import PolyElement

from axisid.modeling.algebra import (
    CANNOT,
    NotRealError,
    Row,
    exact,
    reduced_functions,
    reduced_rows,
    value_at,
)
from axisid.modeling.quantities import DIRECTION, Coordinate, Parameter, signals_in

from .base_terms import Exponents
from .inverse import Regressor

#: Maps parameters to the weights of a change that no motion shows.
Direction: TypeAlias = dict[sympy.Symbol, sympy.Expr]

#: Numbers for parameters.
Point: TypeAlias = Mapping[sympy.Symbol, sympy.Expr]

_PLACES, _STEPS = 101, (37, 59)  # a prime, and how two points walk through its fractions
_MOST = 3  # motions that determine a direction in symbols
_NEAR = 1e-9
_MOST_PRODUCTS = 20_000  # of one term of each sum, above which no direction is found in symbols
_MOST_NODES, _MOST_SYMBOLS, _MOST_ROOTS = 150, 8, 12  # of weights that are written as quotients


def null_space(
    rows: Sequence[Row],
    monomials: Sequence[Exponents],
    parameters: Sequence[Parameter],
    known: AbstractSet[sympy.Symbol] = frozenset(),
) -> tuple[Direction, ...]:
    """Directions in which sums of products of parameters do not change, those known held.

    Parameters
    ----------
    rows : sequence of (k,) rows
        Weights of each sum.
    monomials : sequence of tuple of int
        Length k, with exponents by parameter.
    parameters : sequence of Parameter
        Length p.
    known : set of sympy.Symbol

    Returns
    -------
    tuple of dict
        In the parameters; with numbers at a point near the nominal one where that is too large.
    """
    free = [p.symbol for p in parameters if p.symbol not in known]
    ring = QQ[tuple(p.symbol for p in parameters)]
    sums = [
        ring.ring.from_dict(
            {e: QQ(w.numerator, w.denominator) for e, w in zip(monomials, row, strict=True) if w}
        )
        for row in rows
    ]
    slopes = [[total.diff(ring.from_sympy(p)) for p in free] for total in sums]
    if math.prod(map(len, sums)) <= _MOST_PRODUCTS:
        return tuple(map(_direction, _kernel(slopes, free, ring)))
    point = [Fraction(x.p, x.q) for x in generic_points(parameters)[0].values()]
    numbers = [[_at(slope, point) for slope in row] for row in slopes]
    return _null_space_of_numbers(*reduced_rows(numbers), free)


def _at(polynomial: PolyElement, point: Sequence[Fraction]) -> Fraction:
    """The value of a polynomial at a point."""
    terms = (
        Fraction(int(weight.numerator), int(weight.denominator))
        * math.prod(x**e for x, e in zip(point, powers, strict=True) if e)
        for powers, weight in polynomial.terms()
    )
    return sum(terms, Fraction(0))


def _kernel(
    rows: Sequence[Sequence[PolyElement]], symbols: Sequence[sympy.Symbol], ring: PolynomialRing
) -> Iterator[Direction]:
    """What rows of polynomials map to nothing, in polynomials that share no factor."""
    field = ring.get_field()
    table = [[field.convert_from(slope, ring) for slope in row] for row in rows]
    basis = DomainMatrix(table, (len(table), len(symbols)), field).to_sparse().nullspace()
    for vector in basis.to_dense().rep.to_list():
        shared = reduce(ring.lcm, (weight.denom for weight in vector))
        whole = [weight.numer * shared.exquo(weight.denom) for weight in vector]
        common = reduce(ring.gcd, whole)
        weights = (ring.to_sympy(weight.exquo(common)) for weight in whole)
        yield dict(zip(symbols, weights, strict=True))


def _null_space_of_numbers(
    reduced: Sequence[Row], pivots: Sequence[int], symbols: Sequence[sympy.Symbol]
) -> tuple[Direction, ...]:
    """What rows in echelon form map to nothing; the last weight of each direction is 1."""
    found = []
    for free in (j for j in range(len(symbols)) if j not in pivots):
        weights = {j: -row[free] for j, row in zip(pivots, reduced, strict=True) if row[free]}
        weights[free] = Fraction(1)
        last = weights[max(weights)]
        found.append({symbols[j]: weights[j] / last for j in sorted(weights)})
    return tuple(
        {s: sympy.Rational(w.numerator, w.denominator) for s, w in direction.items()}
        for direction in found
    )


def unidentifiable_directions(
    regressor: Regressor, parameters: Sequence[Parameter], coordinate: Coordinate
) -> tuple[Direction, ...]:
    """Null space, over all motions, of the regressor of a partially linear axis.

    Its columns have parameters in them, so that ``exp(b) dq`` and ``a exp(b) dq`` look like two
    functions of the motion. They are compared where numbers stand for the parameters, at more than
    one point, as two may be alike at one by accident; the directions found hold near the nominal
    values, where a parameter that another one hides (``max(a, b)``) is not seen.
    For a linear axis base parameters tell what is hidden.

    Parameters
    ----------
    regressor : Regressor
        Linearised about the parameters.
    parameters : sequence of Parameter
        One for each column.
    coordinate : Coordinate
    """
    if not regressor.nonlinear:
        return ()
    columns = {p.symbol: c for p, c in zip(parameters, regressor.columns, strict=True)}
    found: list[tuple[Point, tuple[Direction, ...]]] = []
    for point in generic_points(parameters):
        with contextlib.suppress(NotRealError):
            found.append((point, _independent_of_motion(columns, coordinate.velocity, point)))
    if not found:
        return ()
    best, directions = min(found, key=lambda pair: len(pair[1]))
    return tuple(_in_parameters(d, columns, coordinate, best) for d in directions)


def generic_points(parameters: Sequence[Parameter]) -> tuple[Point, ...]:
    """Numbers for the parameters that have nothing to do with each other, several times."""
    return tuple(
        {p.symbol: _generic(p, (i + 1) * step) for i, p in enumerate(parameters)} for step in _STEPS
    )


def _generic(parameter: Parameter, place: int) -> sympy.Rational:
    """A number within the bounds, near the nominal value if there is one."""
    lower, upper = parameter.lower, parameter.upper
    near = parameter.nominal or (min(1.0, upper) if upper > 0 else max(-1.0, lower))
    low, high = sorted((near / 2, 2 * near))
    start, end = (sympy.Rational(str(x)) for x in (max(low, lower), min(high, upper)))
    return start + (end - start) * sympy.Rational(place % _PLACES, _PLACES)


def _independent_of_motion(
    columns: Mapping[sympy.Symbol, sympy.Expr], velocity: sympy.Symbol, point: Point
) -> tuple[Direction, ...]:
    """Combinations of columns that are zero as functions of the motion at a point."""
    found = reduced_functions(tuple(columns.values()), velocity, point)
    return _null_space_of_numbers(*found, tuple(columns))


def _in_parameters(
    direction: Direction,
    columns: Mapping[sympy.Symbol, sympy.Expr],
    coordinate: Coordinate,
    point: Point,
) -> Direction:
    """A direction found at a point as a function of the parameters.

    As many motions as it takes determine it: the minors of their rows are its weights. Where they
    do not, in a few motions or in closed form, it stays as it is at the point.
    """
    weights = {p: sympy.Float(weight) for p, weight in direction.items()}
    if len(direction) - 1 > _MOST or not all(_is_tame(columns[p]) for p in direction):
        return weights
    with contextlib.suppress(sympy.PolynomialError, *CANNOT):
        closed = _from_motions([exact(columns[p]) for p in direction], coordinate)
        values = [float(value_at(weight, point)) for weight in closed]
        if any(values) and all(
            math.isclose(value, weight * values[-1], rel_tol=_NEAR)
            for value, weight in zip(values, map(float, direction.values()), strict=True)
        ):
            return _direction(dict(zip(direction, closed, strict=True)))
    return weights


def _from_motions(columns: Sequence[sympy.Expr], coordinate: Coordinate) -> list[sympy.Expr]:
    """Weights of the combination that one motion less than there are columns does not show."""
    recorded = sorted(signals_in(*columns), key=str)
    motions = [
        {**_motion(coordinate, i), **{s: _recorded(i, j) for j, s in enumerate(recorded)}}
        for i in range(len(columns) - 1)
    ]
    rows = [[column.xreplace(motion) for column in columns] for motion in motions]
    square = sympy.Matrix([[0] * len(columns), *rows])
    return [square.cofactor(0, j) for j in range(len(columns))]


def _is_tame(*weights: sympy.Expr) -> bool:
    """Whether expressions are small enough for quotients of them to be reduced."""
    nodes = [node for weight in weights for node in sympy.preorder_traversal(weight)]
    powers = [sympy.Rational(str(n.exp)) for n in nodes if n.is_Pow and n.exp.is_Number]
    symbols = {node for node in nodes if node.is_Symbol}
    return (
        len(nodes) <= _MOST_NODES
        and len(symbols) <= _MOST_SYMBOLS
        and all(power.q <= _MOST_ROOTS and abs(power.p) <= _MOST_ROOTS for power in powers)
    )


def _motion(coordinate: Coordinate, i: int) -> dict[sympy.Symbol, sympy.Expr]:
    """A motion unlike the others, forwards and backwards in turn."""
    ahead = sympy.Integer(-1) ** i
    return {
        coordinate.symbol: sympy.Rational(i + 1, 3),
        coordinate.velocity: ahead * (i + 1),
        coordinate.acceleration: sympy.Rational(2 * i + 1, i + 2),
        DIRECTION: ahead,
    }


def _recorded(i: int, j: int) -> sympy.Rational:
    """A recorded signal beside a motion, unlike the others."""
    return sympy.Rational(3 * i + 2, i + j + 4)


def _direction(weights: Direction) -> Direction:
    """Weights without quotients; where they are numbers, the last is 1."""
    pairs = {p: w for p, w in weights.items() if w != 0}
    if not _is_tame(*pairs.values()):
        return pairs
    last = list(pairs.values())[-1]
    ratios = [sympy.cancel(w / last) for w in pairs.values()]
    if all(ratio.is_number for ratio in ratios):
        return dict(zip(pairs, ratios, strict=True))
    shared = sympy.S.One
    for ratio in ratios:
        shared = sympy.lcm(shared, sympy.fraction(sympy.together(ratio))[1])
    whole = [sympy.cancel(ratio * shared) for ratio in ratios]
    sign = -1 if whole[0].could_extract_minus_sign() else 1
    return {p: sympy.expand(sign * w) for p, w in zip(pairs, whole, strict=True)}
