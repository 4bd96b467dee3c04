"""Changes of the parameters that no motion shows.

What parameters do to the force may be one function of the motion, or functions that add up to
nothing. No experiment separates them then: only combinations of them are identifiable.
"""

import contextlib
import math
from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from typing import TypeAlias

import sympy
from sympy.polys.matrices import DomainMatrix

from .base_terms import force_terms, reduced_rows
from .independence import exact
from .inverse import Regressor
from .symbols import DIRECTION, Coordinate, Parameter

#: Maps parameters to the weights of a change that no motion shows.
Direction: TypeAlias = dict[sympy.Symbol, sympy.Expr]

#: Numbers for parameters.
Point: TypeAlias = Mapping[sympy.Symbol, sympy.Expr]

_PLACES, _STEPS = 101, (37, 59)  # a prime, and how two points walk through its fractions
_MOST = 3  # motions that determine a direction in symbols
_NEAR = 1e-9


def null_space(
    jacobian: sympy.Matrix,
    parameters: Sequence[sympy.Symbol],
    known: AbstractSet[sympy.Symbol] = frozenset(),
) -> tuple[Direction, ...]:
    """Directions that a Jacobian maps to nothing at a generic point, those known held.

    Parameters
    ----------
    jacobian : sympy.Matrix, (b, p)
        Of polynomials.
    parameters : sequence of sympy.Symbol
        Length p.
    known : set of sympy.Symbol
    """
    free = [j for j, p in enumerate(parameters) if p not in known]
    if not free:
        return ()
    matrix = DomainMatrix.from_Matrix(jacobian.extract(list(range(jacobian.rows)), free))
    vectors = matrix.to_field().nullspace().to_Matrix()
    return tuple(
        _direction({parameters[j]: weight for j, weight in zip(free, vectors.row(i), strict=True)})
        for i in range(vectors.rows)
    )


def hidden_directions(
    regressor: Regressor, parameters: Sequence[Parameter], coordinate: Coordinate
) -> tuple[Direction, ...]:
    """Null space, over all motions, of the regressor of a partially linear axis.

    Its columns have parameters in them, so that ``exp(b) dq`` and ``a exp(b) dq`` look like two
    functions of the motion. They are compared where numbers stand for the parameters, at more than
    one point, as two may be alike at one by accident; the directions found hold at every point.
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
    columns = {
        p.symbol: exact(column) for p, column in zip(parameters, regressor.columns, strict=True)
    }
    slide = {sympy.sign(coordinate.velocity): DIRECTION}  # differentiating |dq / v| brings it
    found: list[tuple[Point, tuple[Direction, ...]]] = []
    for point in generic_points(parameters):
        there = {p: column.xreplace(point).xreplace(slide) for p, column in columns.items()}
        if all(map(_is_real, there.values())):
            found.append((point, _independent_of_motion(there, coordinate.velocity)))
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


def _is_real(column: sympy.Expr) -> bool:
    nodes = sympy.preorder_traversal(column)
    return not column.has(sympy.nan) and all(n.is_real is not False for n in nodes if n.is_number)


def _independent_of_motion(
    columns: Mapping[sympy.Symbol, sympy.Expr], velocity: sympy.Symbol
) -> tuple[Direction, ...]:
    """Combinations of columns without parameters that are zero as functions of the motion."""
    symbols = tuple(columns)
    force = sympy.Add(*(p * column for p, column in columns.items()))
    terms = force_terms(force, velocity, symbols)
    rows, _ = reduced_rows(terms.weights)
    matrix = sympy.zeros(len(rows), len(symbols))
    for j, exponents in enumerate(terms.monomials):
        for i, row in enumerate(rows):
            matrix[i, exponents.index(1)] = sympy.Rational(row[j].numerator, row[j].denominator)
    return null_space(matrix, symbols)


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
    symbols, others = tuple(direction), len(direction) - 1
    closed = _from_motions([columns[p] for p in symbols], coordinate) if others <= _MOST else []
    values = [_number(weight.xreplace(point)) for weight in closed]
    if any(values) and all(
        math.isclose(value, weight * values[-1], rel_tol=_NEAR)
        for value, weight in zip(values, map(float, direction.values()), strict=True)
    ):
        with contextlib.suppress(sympy.PolynomialError):
            return _direction(dict(zip(symbols, closed, strict=True)))
    return {p: sympy.Float(weight) for p, weight in direction.items()}


def _from_motions(columns: Sequence[sympy.Expr], coordinate: Coordinate) -> list[sympy.Expr]:
    """Weights of the combination that one motion less than there are columns does not show."""
    motions = [_motion(coordinate, i) for i in range(len(columns) - 1)]
    rows = [[column.xreplace(motion) for column in columns] for motion in motions]
    square = sympy.Matrix([[0] * len(columns), *rows])
    return [square.cofactor(0, j) for j in range(len(columns))]


def _number(value: sympy.Expr) -> float:
    number = sympy.N(value)
    return float(number) if number.is_real else math.nan


def _motion(coordinate: Coordinate, i: int) -> dict[sympy.Symbol, sympy.Expr]:
    """A motion unlike the others, forwards and backwards in turn."""
    ahead = sympy.Integer(-1) ** i
    return {
        coordinate.symbol: sympy.Rational(i + 1, 3),
        coordinate.velocity: ahead * (i + 1),
        coordinate.acceleration: sympy.Rational(2 * i + 1, i + 2),
        DIRECTION: ahead,
    }


def _direction(weights: Direction) -> Direction:
    """Weights without quotients; where they are numbers, the last is 1."""
    pairs = {p: w for p, w in weights.items() if w != 0}
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
