"""Linear dependences between functions: found at points, and used only with evidence.

Functions that agree at a few points need not be equal. A dependence holds by algebra, if it holds
with independent numbers in place of all functions; otherwise it must hold at points that cover the
functions and were not used to find it. If that cannot be shown, the functions are kept, and the
doubt is reported.
"""

import contextlib
from collections.abc import Collection, Iterable, Mapping, Sequence, Set as AbstractSet
from fractions import Fraction
from functools import cached_property
from operator import itemgetter
from typing import Any, NamedTuple, TypeAlias

import sympy

from axisid.support.errors import ModelError

from .constants import replaced
from .covering_points import CoveringPoints
from .features import Feature
from .point_value import (
    CANNOT,
    NOTHING,
    DrawnPoint,
    Points,
    Value,
    drawn,
    exactly,
    is_decimal,
    is_nothing,
    numbers,
    off_as_decimal,
    rounding,
)
from .symbols import DIRECTION

#: An exact number, or one with all available digits.
Row: TypeAlias = list[Fraction]
_Row: TypeAlias = list[Value]
#: Rows by the column in which they have a 1 and all others a 0.
_Echelon: TypeAlias = dict[int, _Row]

_MOST_STEPS = 2_000_000  # numbers that are computed
_SPARE_ROWS = 3  # beyond one for each column
_FAILURES = 40  # consecutive points at which a function may have no value
_MOST_CYCLES = 12
_FEW = 3
_OPAQUE_TURNS = 10**9  # of points with numbers in place of functions
_NOTHING_LEFT = 30  # times the change by rounding
_SIMPLE, _SAME = 10**15, 40  # the largest divisor of a simple fraction, and its digits
_SHORT = 10**35  # the largest product of its numbers, of a fraction that is no coincidence
_LARGEST = 1000  # binary digits of a number, beyond which all are equal
_EXACT = 1e-30  # share of the terms of a sum, up to which they cancel
_ROUNDED = 1e-12  # likewise if decimals may be products that the user rounded,
_MOST_CANCELLED = 100  # of terms that are not larger than the function by more than this


class NotRealError(ModelError):
    """A part of an expression is no finite real number, whatever the motion."""

    code = "formula"


class Reduced(NamedTuple):
    """Reduced row echelon form of functions.

    Attributes
    ----------
    rows : list of list of Fraction
        Without zero rows.
    pivots : list of int
        The column that each row begins with.
    doubts : list of tuple of int
        Columns between which a dependence holds at all evaluated points (a single column: which is
        0 at all of them), but for which no points were found that would show a difference. The last
        of each has its own row.
    rounded : bool
        Whether a dependence holds only up to products of decimals that the user rounded.
    """

    rows: list[Row]
    pivots: list[int]
    doubts: list[tuple[int, ...]]
    rounded: bool = False


def reduced_rows(rows: Sequence[Row]) -> tuple[list[Row], list[int]]:
    """Return the reduced row echelon form without its zero rows, and its pivot columns.

    Where weights cancel, a remainder no larger than rounding counts as zero: a product of decimals
    computed in floating point is not the product of these decimals.

    Raises
    ------
    ModelError
        There are too many weights to be computed.
    """
    columns = max(map(len, rows), default=0)
    _check_size(len(rows), columns)
    found = _echelon([[off_as_decimal(x) for x in row] for row in rows], range(columns))
    pivots = sorted(found)
    return [[_fraction(x) if x else Fraction(0) for x, _ in found[j]] for j in pivots], pivots


def reduced_functions(
    functions: Sequence[sympy.Expr],
    velocity: sympy.Symbol,
    given: Mapping[sympy.Symbol, sympy.Rational] | None = None,
    differing: Sequence[Mapping[sympy.Symbol, Any]] = (),
) -> Reduced:
    """Return the reduced row echelon form of functions: the combinations that are 0 everywhere.

    Parameters
    ----------
    functions : sequence of sympy.Expr
    velocity : sympy.Symbol
        Velocity; the friction direction is its sign.
    given : mapping of sympy.Symbol to sympy.Rational, optional
        Symbols that have the same numbers at all points.
    differing : sequence of mapping of sympy.Symbol to number
        Points that count as evidence from the start.

    Raises
    ------
    NotRealError
        A function has no finite value.
    ModelError
        There are too many functions.
    """
    numbered = {s: exactly(numbers.mpf(x.p) / x.q) for s, x in (given or {}).items()}
    multiples = [function.as_coeff_Mul(rational=True) for function in functions]
    distinct = list(dict.fromkeys(function for share, function in multiples if share))
    _check_size(len({f.as_coeff_Mul()[1] for f in distinct}), len(functions))
    if not distinct:
        return Reduced([], [], [])
    found = _Reduction(distinct, velocity, numbered, differing).result()
    shares = [Fraction(int(share.p), int(share.q)) for share, _ in multiples]
    return _of_multiples(found, shares, [distinct.index(f) if s else 0 for s, f in multiples])


def _of_multiples(distinct: Reduced, shares: Sequence[Fraction], places: Sequence[int]) -> Reduced:
    """Return the reduced form of multiples, each a share of the function in its place."""
    first: dict[int, int] = {}
    for j, (share, place) in enumerate(zip(shares, places, strict=True)):
        if share:
            first.setdefault(place, j)
    rows = []
    for pivot, row in zip(distinct.pivots, distinct.rows, strict=True):
        lead = shares[first[pivot]]
        rows.append(
            [row[place] * share / lead for share, place in zip(shares, places, strict=True)]
        )
    pivots = [first[pivot] for pivot in distinct.pivots]
    doubts = [tuple(first[place] for place in group) for group in distinct.doubts]
    return Reduced(rows, pivots, doubts, distinct.rounded)


def unmerged(reduced: Reduced, size: int) -> Reduced:
    """Return the functions with a row for each; a former sum of others becomes a doubt."""
    doubts = list(reduced.doubts)
    for j in range(size):
        if j not in reduced.pivots:
            others = (p for p, row in zip(reduced.pivots, reduced.rows, strict=True) if row[j])
            doubts.append((*others, j))
    return Reduced([_unit(j, size) for j in range(size)], list(range(size)), doubts)


def vanishes(expression: sympy.Expr) -> bool:
    """Return whether an expression is 0; False without a finite value or in doubt."""
    if expression == 0:
        return True
    reduction = _Reduction([expression], None, {})
    try:
        for turn in range(_FEW):
            if not is_nothing(reduction.points.at(2 * turn)(expression)):
                return False
    except CANNOT:
        return False
    return reduction.is_nothing_everywhere()


def depends(expression: sympy.Expr, symbols: AbstractSet[sympy.Symbol]) -> bool:
    """Return whether an expression changes with symbols; True without a finite value."""
    others = {s: sympy.Symbol(f"other {s.name}", **s.assumptions0) for s in symbols}
    return not vanishes(expression - replaced(expression, others))


def _check_size(independent: int, columns: int) -> None:
    if independent**2 * columns > _MOST_STEPS:
        raise ModelError(
            "the parameters enter in too many products and sums to find the identifiable ones. "
            "Declare parameters that enter together as one parameter."
        )


class _Reduction:
    """The dependences of functions, and the evidence for each."""

    def __init__(
        self,
        functions: Sequence[sympy.Expr],
        velocity: sympy.Symbol | None,
        given: Mapping[sympy.Symbol, Value],
        differing: Sequence[Mapping[sympy.Symbol, Any]] = (),
    ) -> None:
        self.functions, self.columns = functions, range(len(functions))
        self.points = Points(*functions, velocity=velocity, given=given)
        self._differing = differing
        self._only_real = True
        self._first: dict[int, DrawnPoint] = {}

    @cached_property
    def covering(self) -> CoveringPoints:
        """Return points that cover the functions."""
        return CoveringPoints(self.points, self.functions)

    def is_nothing_everywhere(self) -> bool:
        """Return whether the first function is 0 everywhere, given that it is 0 at a few points."""
        nothing: _Weights = {0: {}}
        if self._holds_with(_outer_functions(self.functions), nothing, 0, decimals=True):
            return True
        for point in self.covering.cycle(1, decimals=True):
            for row in self._rows(point):
                if not is_nothing(row[0]):
                    return False
                self.covering.observe(point)
        doubtful = _nodes(self.covering.unresolved([0]))
        return not doubtful or self._holds_with(doubtful, nothing, 0, decimals=True)

    def result(self) -> Reduced:
        """Return the dependences for which there is evidence.

        Decimals are taken as exact first. Functions that are then independent may still be equal up
        to products of decimals that the user rounded.
        """
        size = len(self.columns)
        points = [*self._first_points(size), *self._differing_points()]
        rough = self._echelon_at(points)
        if len(rough) == size:
            return self._all_apart()
        with numbers.workprec(2 * numbers.prec):
            algebra = _echelon(self._opaque_rows(), self.columns)
            if len(algebra) == len(rough):
                return _reduced({j: _fractions(row, ()) for j, row in algebra.items()})
            points = [*self._first_points(2 * size + _SPARE_ROWS), *self._differing_points()]
            points = [point.again(decimals=False) for point in points]
            found, doubts = self._with_evidence(points, algebra)
            table = {j: _fractions(row, doubts) for j, row in found.items()}
            table |= {j: _unit(j, size) for j in doubts}
            exact = len(table)
            if exact > len(rough) and _has_decimals(self.functions):
                self._merge_rounded(table, points, doubts)
        return _reduced(table, doubts, rounded=len(table) < exact)

    def _all_apart(self) -> Reduced:
        """Return each function as independent."""
        return _reduced({j: _unit(j, len(self.columns)) for j in self.columns})

    def _echelon_at(
        self, points: Iterable[DrawnPoint], columns: Sequence[int] | None = None
    ) -> _Echelon:
        """Return the reduced row echelon form of the values at points, for some of the columns."""
        rows = [row for point in points for row in self._rows(point)]
        return _echelon(rows, self.columns if columns is None else columns)

    def _first_points(self, wanted: int) -> list[DrawnPoint]:
        """Return the given number of points of moderate size.

        Raises
        ------
        NotRealError
            There are none.
        """
        failures = 0
        real: list[DrawnPoint] = []
        others: list[DrawnPoint] = []
        for turn in range(2 * wanted + _FAILURES):
            point = self._first.setdefault(turn, self.points.at(turn))
            if not self._values(point):
                failures += 1
            elif point.is_real:
                real.append(point)
            else:
                others.append(point)
            if len(real) == wanted or failures == _FAILURES:
                break
        self._only_real = len(real) == wanted
        found = real if self._only_real else [*real, *others]
        if not found:
            listed = ", ".join(map(str, self.functions))
            raise NotRealError(f"a part of {listed} has no finite real value.")
        return found

    def _differing_points(self) -> list[DrawnPoint]:
        """Return the points that are given as evidence."""
        return [
            DrawnPoint(self.points, turn, {symbol: exactly(x) for symbol, x in place.items()})
            for turn, place in enumerate(self._differing)
        ]

    def _values(self, point: DrawnPoint) -> _Row:
        """Return the values of the functions; none if one has no finite value."""
        try:
            row = [point(function) for function in self.functions]
        except CANNOT:
            return []
        finite = all(numbers.isfinite(part) for pair in row for part in pair)
        return row if finite else []

    def _rows(self, point: DrawnPoint) -> list[_Row]:
        """Return the values as rows; real and imaginary parts separately, if hardly ever real."""
        row = self._values(point)
        if not row or (self._only_real and not point.is_real):
            return []
        rows = [[(numbers.re(x), point.off(numbers.re(y))) for x, y in row]]
        if any(numbers.im(x) for x, _ in row):
            rows.append([(numbers.im(x), point.off(numbers.im(y))) for x, y in row])
        return rows

    def _opaque_rows(self) -> list[_Row]:
        """Return values with independent numbers in place of all functions."""
        nodes = _outer_functions(self.functions)
        turns = range(len(self.columns) + _SPARE_ROWS)
        return [row for turn in turns for row in self._opaque(nodes, turn, decimals=False)]

    def _opaque(self, nodes: Sequence[sympy.Basic], turn: int, *, decimals: bool) -> list[_Row]:
        placed = {
            node: exactly(drawn(turn, "function", str(place)) * (-1) ** (turn + place))
            for place, node in enumerate(nodes)
        }
        return self._rows(DrawnPoint(self.points, _OPAQUE_TURNS + turn, placed, decimals=decimals))

    def _holds_with(
        self, nodes: Sequence[sympy.Basic], weights: "_Weights", j: int, *, decimals: bool = False
    ) -> bool:
        """Return whether a dependence holds with independent numbers in place of some functions."""
        rows = [row for k in range(_FEW) for row in self._opaque(nodes, k, decimals=decimals)]
        return bool(rows) and not any(_remainder(row, j, weights[j]) for row in rows)

    def _with_evidence(
        self, points: list[DrawnPoint], algebra: _Echelon
    ) -> tuple[_Echelon, dict[int, tuple[int, ...]]]:
        """Return dependences, and those of them that remain in doubt, by their column.

        Each cycle of points tests the dependences found before it; one that fails at a point adds a
        row. A dependence shown by algebra needs no points.
        """
        size = len(self.columns)
        rows = [row for point in points for row in self._rows(point)]
        found = _echelon(rows, self.columns)
        failed: set[int] = set()
        for number in range(1, _MOST_CYCLES + 1):
            if len(found) == len(algebra):
                return algebra, {}
            weights, failed = _weights(found, self.columns), set()
            more: list[tuple[Any, _Row, DrawnPoint]] = []
            for point in self.covering.cycle(number):
                for row in self._rows(point):
                    self.covering.observe(point)
                    left = {j: _remainder(row, j, w) for j, w in weights.items()}
                    failed |= {j for j, share in left.items() if share}
                    if any(left.values()):
                        more.append((max(left.values()), row, point))
            if not failed:
                break
            more.sort(key=itemgetter(0), reverse=True)
            chosen = [*more[: 2 * size], *more[2 * size :: max(1, len(more) // (2 * size))]]
            rows += [row for _, row, _ in chosen]
            points += [point for _, _, point in chosen]
            found = _echelon(rows, self.columns)
        if len(found) == len(algebra):
            return algebra, {}
        weights = _weights(found, self.columns)
        doubts = {
            j: (*w, j) for j, w in weights.items() if failed or not self._is_shown(j, weights)
        }
        return found, doubts

    def _is_shown(self, j: int, weights: "_Weights") -> bool:
        """Return whether a dependence at all points is more than a coincidence."""
        simple = all(map(_is_simple, weights[j].values()))
        if not (simple or self.points.given or _has_numbers(self.functions)):
            return False
        doubtful = _nodes(self.covering.unresolved((*weights[j], j)))
        if not weights[j] and not self._cancels(self.functions[j]):
            # Points at which it is zero may all be outside a window in which it is not.
            doubtful = _nodes(self.covering.needed([j]))
        return not doubtful or self._holds_with(doubtful, weights, j)

    def _cancels(self, function: sympy.Expr) -> bool:
        """Return whether a function that is zero has terms that are not."""
        terms, seen = sympy.Add.make_args(function), 0
        for point in self.covering.cycle(1):
            with contextlib.suppress(*CANNOT):
                seen += not all(is_nothing(point(term)) for term in terms)
        return seen >= _SPARE_ROWS

    def _merge_rounded(
        self, table: dict[int, Row], points: Sequence[DrawnPoint], doubts: Mapping[int, Any]
    ) -> None:
        """Merge functions that are equal except for decimals that the user rounded."""
        columns = [j for j in sorted(table) if j not in doubts]
        with numbers.workprec(numbers.prec // 2):
            again = [point.again(decimals=True) for point in points]
            weights = _weights(self._echelon_at(again, columns), columns)
        if not weights:
            return
        failed: set[int] = set()
        for point in self.covering.cycle(_MOST_CYCLES + 1):
            for row in self._rows(point):
                self.covering.observe(point)
                failed |= {j for j, w in weights.items() if _remainder(row, j, w, rounded=True)}
        for j, own in weights.items():
            if j not in failed and not self.covering.unresolved((*own, j)):
                merged = table.pop(j)
                for p, weight in own.items():
                    share = _fraction(weight)
                    table[p] = [x + share * y for x, y in zip(table[p], merged, strict=True)]


def _reduced(
    table: Mapping[int, Row],
    doubts: Mapping[int, tuple[int, ...]] | None = None,
    *,
    rounded: bool = False,
) -> Reduced:
    """Return rows by their pivots, in ascending order."""
    pivots = sorted(table)
    left = list(doubts.values()) if doubts else []
    return Reduced([table[j] for j in pivots], pivots, left, rounded)


#: Weights with which a column is the sum of others, by that column.
_Weights: TypeAlias = dict[int, dict[int, Any]]


def _outer_functions(functions: Sequence[sympy.Expr]) -> list[sympy.Basic]:
    """Return the nodes that are no rational operation, and are not inside another such node."""
    found: dict[sympy.Basic, None] = {}
    for function in functions:
        walk = sympy.preorder_traversal(function)
        for node in walk:
            rational = node.is_Add or node.is_Mul or (node.is_Pow and node.exp.is_Integer)
            if node == DIRECTION or (node.args and not rational):
                walk.skip()
                if node.free_symbols:
                    found[node] = None
    return list(found)


def _nodes(features: Sequence[Feature]) -> list[sympy.Basic]:
    return list(dict.fromkeys(feature.node for feature in features))


def _has_decimals(functions: Sequence[sympy.Expr]) -> bool:
    return any(is_decimal(number) for f in functions for number in f.atoms(sympy.Float))


def _has_numbers(functions: Sequence[sympy.Expr]) -> bool:
    """Return whether a number that is no fraction was declared: a decimal, pi, a root of 2."""
    return any(
        node.is_number and not (node.is_Rational or (node.is_Float and not is_decimal(node)))
        for function in functions
        for node in sympy.preorder_traversal(function)
        if isinstance(node, sympy.Expr)
    )


def _unit(j: int, size: int) -> Row:
    return [Fraction(int(i == j)) for i in range(size)]


def _echelon(rows: Sequence[_Row], columns: Sequence[int]) -> _Echelon:
    """Return the reduced row echelon form of given columns, with the surest pivots."""
    left, off = list(rows), rounding(0)
    found: _Echelon = {}
    for j in columns:
        sure = [place for place, row in enumerate(left) if not is_nothing(row[j])]
        if sure:
            lead = left.pop(max(sure, key=lambda place: _sureness(left[place][j])))
            number, moved = lead[j]
            # With rounding included once more: a common error of a row cancels in both numbers.
            found[j] = [(x / number, off(y / moved)) for x, y in lead]
            left = [_minus_multiple(row, found[j], j) for row in left]
    for j in sorted(found, reverse=True):
        for i in (i for i in found if i > j and len(found) < len(columns)):
            found[j] = _minus_multiple(found[j], found[i], i)
        found[j] = [
            NOTHING if i != j and (i in found or is_nothing(x)) else x
            for i, x in enumerate(found[j])
        ]
    return found


def _sureness(value: Value) -> tuple[int, Any]:
    """Return the binary digits of a number that are not rounding, and its size."""
    number, moved = value
    change = number - moved
    digits = numbers.mag(number) - numbers.mag(change) if change else numbers.prec
    return int(digits), abs(number)


def _minus_multiple(row: _Row, lead: _Row, j: int) -> _Row:
    """Subtract from a row the multiple of another row with a 1 in column j."""
    share, moved = row[j]
    if not share and not moved:
        return row
    left = [
        (x - share * a, y - moved * b) for (x, y), (a, b) in zip(row[j:], lead[j:], strict=True)
    ]
    return [*row[:j], *left]


def _weights(found: _Echelon, columns: Iterable[int]) -> _Weights:
    """Return the weights of the columns without a pivot in those with one."""
    return {
        j: {p: _simplified(row[j][0]) for p, row in sorted(found.items()) if row[j][0]}
        for j in columns
        if j not in found
    }


def _remainder(row: _Row, j: int, weights: Mapping[int, Any], *, rounded: bool = False) -> Any:
    """Return the share of a column outside the span of others, 0 if it may be rounding."""
    value, moved = row[j]
    terms = [weight * row[p][0] for p, weight in weights.items()]
    noise = sum((abs(w * (row[p][0] - row[p][1])) for p, w in weights.items()), abs(value - moved))
    left, size = abs(value - sum(terms)), abs(value) + sum(map(abs, terms))
    allowed = max(_EXACT * size, _NOTHING_LEFT * noise)
    if rounded:
        allowed = max(allowed, _ROUNDED * min(size, _MOST_CANCELLED * abs(value)))
    return left / size if left > allowed else 0


def _fractions(row: _Row, without: Collection[int]) -> Row:
    return [Fraction(0) if j in without or not x else _fraction(x) for j, (x, _) in enumerate(row)]


def _simplified(number: Any) -> Any:
    """Return a number, as a simple fraction if it is one except for the last digits."""
    fraction = _fraction(number)
    return numbers.mpf(fraction.numerator) / fraction.denominator


def _is_simple(number: Any) -> bool:
    fraction = _fraction(number)
    return abs(fraction.numerator) * fraction.denominator <= _SHORT


def _fraction(number: Any) -> Fraction:
    """Return a number as a fraction, a simple one if it is one except for the last digits."""
    size = numbers.mag(number)
    if abs(size) > _LARGEST:
        number = numbers.ldexp(numbers.sign(number), max(-_LARGEST, min(size, _LARGEST)))
    sign, mantissa, exponent, _ = number._mpf_
    exact = Fraction(-int(mantissa) if sign else int(mantissa)) * Fraction(2) ** int(exponent)
    simple = exact.limit_denominator(_SIMPLE)
    return simple if abs(simple - exact) <= abs(exact) / 10**_SAME else exact
