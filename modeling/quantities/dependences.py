"""Find linear dependences between functions, and use only those with evidence.

Functions that agree at a few points need not be equal. A dependence is proved by algebra if it
holds with independent numbers in place of all functions such as sin or Max. Otherwise the
dependence must hold at points that cover the functions and were not used to find it. If that
cannot be shown, the functions are kept as independent, and the doubt is reported.

In the matrices of this module, each column is a function and each row a point. A number is computed
twice: as it is, and with the changes that rounding would make (`Value`).
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

#: Row of weights: exact fractions, or fractions with all available digits.
Row: TypeAlias = list[Fraction]
_Row: TypeAlias = list[Value]
#: Rows by pivot: the column in which the row has a 1 and all other rows have a 0.
_Echelon: TypeAlias = dict[int, _Row]

_MOST_STEPS = 2_000_000  # largest number of computed numbers
_SPARE_ROWS = 3  # rows in addition to one row for each column
_FAILURES = 40  # points at which a function may have no value, at most
_MOST_CYCLES = 12
_FEW = 3
_OPAQUE_TURNS = 10**9  # first number of the points with numbers in place of functions
_NOTHING_LEFT = 30  # a remainder up to this multiple of the change by rounding counts as zero
_SIMPLE, _SAME = 10**15, 40  # largest denominator of a simple fraction, and equal digits
_SHORT = 10**35  # largest numerator times denominator of a weight that is no coincidence
_LARGEST = 1000  # binary digits before or behind the point, at most
_EXACT = 1e-30  # remainder, as a share of the terms of a sum, up to which the terms cancel
_ROUNDED = 1e-12  # the same share if decimals may be products that the user rounded, ...
_MOST_CANCELLED = 100  # ... for terms at most so many times larger than the function


class NotRealError(ModelError):
    """Error for a part of an expression that is not finite and real at any motion."""

    code = "formula"


class Reduced(NamedTuple):
    """Reduced row echelon form of functions.

    Attributes
    ----------
    rows : list of list of Fraction
        Rows that are not zero.
    pivots : list of int
        For each row, the column of its leading 1.
    doubts : list of tuple of int
        Groups of columns that are linearly dependent at all evaluated points, although points that
        could show a difference were not found. A group of one column is 0 at all these points. The
        last column of each group has its own row, as if it were independent.
    rounded : bool
        Whether a dependence holds only up to products of decimals that the user rounded.
    """

    rows: list[Row]
    pivots: list[int]
    doubts: list[tuple[int, ...]]
    rounded: bool = False


def reduced_rows(rows: Sequence[Row]) -> tuple[list[Row], list[int]]:
    """Return the reduced row echelon form without its zero rows, and its pivot columns.

    If weights cancel except for rounding, the remainder counts as zero, because a product of
    decimals that was computed in floating point is not exact.

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
    """Return the reduced row echelon form of functions.

    The function of a column without a pivot is, at every motion, the sum of the functions of the
    pivots, with the weights that are in its column.

    Parameters
    ----------
    functions : sequence of sympy.Expr
        One function for each column.
    velocity : sympy.Symbol
        Velocity; the friction direction is its sign.
    given : mapping of sympy.Symbol to sympy.Rational, optional
        Symbols that have the same numbers at all points.
    differing : sequence of mapping of sympy.Symbol to number
        Points that are evaluated in addition, because functions were found to differ there.

    Raises
    ------
    NotRealError
        A function has no finite real value.
    ModelError
        There are too many functions.
    """
    numbered = {s: exactly(numbers.mpf(x.p) / x.q) for s, x in (given or {}).items()}
    # Rational multiples of one function are reduced only once.
    multiples = [function.as_coeff_Mul(rational=True) for function in functions]
    distinct = list(dict.fromkeys(function for share, function in multiples if share))
    _check_size(len({f.as_coeff_Mul()[1] for f in distinct}), len(functions))
    if not distinct:
        return Reduced([], [], [])
    found = _Reduction(distinct, velocity, numbered, differing).result()
    shares = [Fraction(int(share.p), int(share.q)) for share, _ in multiples]
    return _of_multiples(found, shares, [distinct.index(f) if s else 0 for s, f in multiples])


def _of_multiples(distinct: Reduced, shares: Sequence[Fraction], places: Sequence[int]) -> Reduced:
    """Return the reduced form of rational multiples of functions whose reduced form is known.

    Parameters
    ----------
    distinct : Reduced
        Reduced form of the distinct functions.
    shares : sequence of Fraction
        The factor of each multiple.
    places : sequence of int
        For each multiple, the index of its distinct function.
    """
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
    """Return a reduced form in which each function has its own row.

    A function that was a sum of others becomes a doubt, together with these others.

    Parameters
    ----------
    reduced : Reduced
    size : int
        Number of functions.
    """
    doubts = list(reduced.doubts)
    for j in range(size):
        if j not in reduced.pivots:
            others = (p for p, row in zip(reduced.pivots, reduced.rows, strict=True) if row[j])
            doubts.append((*others, j))
    return Reduced([_unit(j, size) for j in range(size)], list(range(size)), doubts)


def vanishes(expression: sympy.Expr) -> bool:
    """Return whether an expression is 0 everywhere.

    The result is False in doubt, or if the expression has no finite real value.
    """
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
    """Return whether an expression changes with any of the given symbols.

    The result is True in doubt, or if the expression has no finite real value.
    """
    others = {s: sympy.Symbol(f"other {s.name}", **s.assumptions0) for s in symbols}
    return not vanishes(expression - replaced(expression, others))


def _check_size(independent: int, columns: int) -> None:
    """Refuse a reduction that would take too long.

    Parameters
    ----------
    independent, columns : int
        Number of rows, and of columns.
    """
    if independent**2 * columns > _MOST_STEPS:
        raise ModelError(
            "the parameters enter in so many products and sums that the identifiable combinations "
            "cannot be found. Declare parameters that enter together as one parameter."
        )


class _Reduction:
    """Search for the linear dependences of functions, with the evidence for each.

    Parameters
    ----------
    functions : sequence of sympy.Expr
        One function for each column.
    velocity : sympy.Symbol or None
        Symbol whose sign is the friction direction; None without one.
    given : mapping of sympy.Symbol to Value
        Symbols that have the same numbers at all points.
    differing : sequence of mapping of sympy.Symbol to number
        Points that are evaluated in addition.
    """

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
        """Return whether the first function is 0 everywhere, given that it is 0 at a few points.

        The function is 0 everywhere by algebra, or if it is 0 at all points that cover it and at
        points at which the features that no point shows have independent numbers.
        """
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
        """Return the reduced form with the dependences for which there is evidence.

        First the rank at a few points is computed: if it is full, all functions are independent.
        Then the dependences that hold by algebra are computed: if these are all dependences, they
        are the result. Otherwise cycles of covering points test the dependences, with decimals
        taken as exact. Functions that are then independent may still be equal up to products of
        decimals that the user rounded; such functions are merged last.
        """
        size = len(self.columns)
        points = [*self._first_points(size), *self._differing_points()]
        rough = self._echelon_at(points)
        if len(rough) == size:
            return self._all_independent()
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

    def _all_independent(self) -> Reduced:
        """Return the reduced form in which every function is independent."""
        return _reduced({j: _unit(j, len(self.columns)) for j in self.columns})

    def _echelon_at(
        self, points: Iterable[DrawnPoint], columns: Sequence[int] | None = None
    ) -> _Echelon:
        """Return the reduced row echelon form of the values at points, for some or all columns."""
        rows = [row for point in points for row in self._rows(point)]
        return _echelon(rows, self.columns if columns is None else columns)

    def _first_points(self, wanted: int) -> list[DrawnPoint]:
        """Return points at which the symbols have numbers of moderate size.

        These are `wanted` points with real values, if there are as many; otherwise all points that
        were found.

        Raises
        ------
        NotRealError
            The functions have no finite value at any point.
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
            raise NotRealError(
                f"a part of {listed} has no finite real value. Write a force that is finite and "
                "real."
            )
        return found

    def _differing_points(self) -> list[DrawnPoint]:
        """Return the points of `differing`, at which the functions are to be evaluated too."""
        return [
            DrawnPoint(self.points, turn, {symbol: exactly(x) for symbol, x in place.items()})
            for turn, place in enumerate(self._differing)
        ]

    def _values(self, point: DrawnPoint) -> _Row:
        """Return the values of the functions at a point; empty if one has no finite value."""
        try:
            row = [point(function) for function in self.functions]
        except CANNOT:
            return []
        finite = all(numbers.isfinite(part) for pair in row for part in pair)
        return row if finite else []

    def _rows(self, point: DrawnPoint) -> list[_Row]:
        """Return the values of the functions at a point as rows of the matrix.

        There is one row of real parts. If too few points give real values, there is also a row of
        imaginary parts; otherwise a point with values that are not real gives no row.
        """
        row = self._values(point)
        if not row or (self._only_real and not point.is_real):
            return []
        rows = [[(numbers.re(x), point.off(numbers.re(y))) for x, y in row]]
        if any(numbers.im(x) for x, _ in row):
            rows.append([(numbers.im(x), point.off(numbers.im(y))) for x, y in row])
        return rows

    def _opaque_rows(self) -> list[_Row]:
        """Return rows with independent numbers in place of all functions such as sin or Max."""
        nodes = _outer_functions(self.functions)
        turns = range(len(self.columns) + _SPARE_ROWS)
        return [row for turn in turns for row in self._opaque(nodes, turn, decimals=False)]

    def _opaque(self, nodes: Sequence[sympy.Basic], turn: int, *, decimals: bool) -> list[_Row]:
        """Return the rows of a point at which parts of the functions have independent numbers.

        Parameters
        ----------
        nodes : sequence of sympy.Basic
            Parts of the functions.
        turn : int
            Number of the point.
        decimals : bool
            Whether declared decimals are changed as by rounding.
        """
        placed = {
            node: exactly(drawn(turn, "function", str(place)) * (-1) ** (turn + place))
            for place, node in enumerate(nodes)
        }
        return self._rows(DrawnPoint(self.points, _OPAQUE_TURNS + turn, placed, decimals=decimals))

    def _holds_with(
        self, nodes: Sequence[sympy.Basic], weights: "_Weights", j: int, *, decimals: bool = False
    ) -> bool:
        """Return whether a dependence holds with independent numbers in place of some parts.

        Parameters
        ----------
        nodes : sequence of sympy.Basic
            Parts of the functions that are replaced by numbers.
        weights : dict
            By dependent column, the weights of the columns whose sum it is.
        j : int
            The dependent column.
        decimals : bool
            Whether declared decimals are changed as by rounding.
        """
        rows = [row for k in range(_FEW) for row in self._opaque(nodes, k, decimals=decimals)]
        return bool(rows) and not any(_remainder(row, j, weights[j]) for row in rows)

    def _with_evidence(
        self, points: list[DrawnPoint], algebra: _Echelon
    ) -> tuple[_Echelon, dict[int, tuple[int, ...]]]:
        """Return the echelon form after tests at covering points, and doubts by dependent column.

        Each cycle of points tests the dependences that were found before it. A dependence that
        fails at a point adds a row, and the echelon form is computed again. The tests end when no
        dependence fails, or when as many rows are independent as by algebra. A doubt is the group
        of columns of a dependence that did not fail but has no evidence either (`_is_shown`).

        Parameters
        ----------
        points : list of DrawnPoint
            First points; further ones are added.
        algebra : dict
            Echelon form of the dependences that hold by algebra.
        """
        size = len(self.columns)
        rows = [row for point in points for row in self._rows(point)]
        found = _echelon(rows, self.columns)
        failed: set[int] = set()
        for number in range(1, _MOST_CYCLES + 1):
            if len(found) == len(algebra):
                return algebra, {}
            weights, failed = _weights(found, self.columns), set()
            counterexamples: list[tuple[Any, _Row, DrawnPoint]] = []
            for point in self.covering.cycle(number):
                for row in self._rows(point):
                    self.covering.observe(point)
                    left = {j: _remainder(row, j, w) for j, w in weights.items()}
                    failed |= {j for j, share in left.items() if share}
                    if any(left.values()):
                        counterexamples.append((max(left.values()), row, point))
            if not failed:
                break
            # Add the points with the largest remainders, and a regular selection of the others.
            counterexamples.sort(key=itemgetter(0), reverse=True)
            step = max(1, len(counterexamples) // (2 * size))
            chosen = [*counterexamples[: 2 * size], *counterexamples[2 * size :: step]]
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
        """Return whether a dependence that holds at all points is more than a coincidence.

        Its weights must be simple fractions, unless numbers such as decimals were declared. The
        points must have shown all features of its functions, or the dependence must also hold with
        independent numbers in place of the functions whose features were not shown.
        """
        simple = all(map(_is_simple, weights[j].values()))
        if not (simple or self.points.given or _has_numbers(self.functions)):
            return False
        doubtful = _nodes(self.covering.unresolved((*weights[j], j)))
        if not weights[j] and not self._cancels(self.functions[j]):
            # The function may be 0 at all points because they are outside a narrow window.
            doubtful = _nodes(self.covering.needed([j]))
        return not doubtful or self._holds_with(doubtful, weights, j)

    def _cancels(self, function: sympy.Expr) -> bool:
        """Return whether a function that is 0 at all points has terms that are not 0 at a few."""
        terms, count = sympy.Add.make_args(function), 0
        for point in self.covering.cycle(1):
            with contextlib.suppress(*CANNOT):
                count += not all(is_nothing(point(term)) for term in terms)
        return count >= _SPARE_ROWS

    def _merge_rounded(
        self, table: dict[int, Row], points: Sequence[DrawnPoint], doubts: Mapping[int, Any]
    ) -> None:
        """Merge functions that are equal except for decimals that the user rounded.

        Parameters
        ----------
        table : dict
            Rows by their pivot, changed in place: the row of a merged function is removed, and its
            multiples are added to the rows of the functions whose sum it is.
        points : sequence of DrawnPoint
            Points at which such dependences are found.
        doubts : mapping
            Columns in doubt, which are not merged.
        """
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
    """Return a reduced form from rows by their pivots and doubts by their column."""
    pivots = sorted(table)
    left = list(doubts.values()) if doubts else []
    return Reduced([table[j] for j in pivots], pivots, left, rounded)


#: By dependent column, the weights of the columns whose sum it is.
_Weights: TypeAlias = dict[int, dict[int, Any]]


def _outer_functions(functions: Sequence[sympy.Expr]) -> list[sympy.Basic]:
    """Return the outermost parts of functions that are not sums, products or whole powers.

    The friction direction counts as such a part.
    """
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
    """Return the functions to which features belong, each once."""
    return list(dict.fromkeys(feature.node for feature in features))


def _has_decimals(functions: Sequence[sympy.Expr]) -> bool:
    """Return whether a decimal was declared that is not a whole number."""
    return any(is_decimal(number) for f in functions for number in f.atoms(sympy.Float))


def _has_numbers(functions: Sequence[sympy.Expr]) -> bool:
    """Return whether a number that is not a fraction was declared: a decimal, pi, sqrt(2)."""
    return any(
        node.is_number and not (node.is_Rational or (node.is_Float and not is_decimal(node)))
        for function in functions
        for node in sympy.preorder_traversal(function)
        if isinstance(node, sympy.Expr)
    )


def _unit(j: int, size: int) -> Row:
    """Return a row of the given size with a 1 in column `j`."""
    return [Fraction(int(i == j)) for i in range(size)]


def _echelon(rows: Sequence[_Row], columns: Sequence[int]) -> _Echelon:
    """Return the reduced row echelon form, by pivot column, for pivots in the given columns.

    In each column the entry with the most digits above rounding is the pivot.
    """
    left, off = list(rows), rounding(0)
    found: _Echelon = {}
    for j in columns:
        sure = [place for place, row in enumerate(left) if not is_nothing(row[j])]
        if sure:
            lead = left.pop(max(sure, key=lambda place: _sureness(left[place][j])))
            number, moved = lead[j]
            # Add a change by rounding, because an error common to both numbers cancels.
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
    """Return the sorting key of a pivot: the binary digits that rounding leaves, then the size."""
    number, moved = value
    change = number - moved
    digits = numbers.mag(number) - numbers.mag(change) if change else numbers.prec
    return int(digits), abs(number)


def _minus_multiple(row: _Row, lead: _Row, j: int) -> _Row:
    """Return a row minus a multiple of `lead`, so that its entry in column `j` is 0.

    The entry of `lead` in column `j` is 1, and its entries before are 0.
    """
    share, moved = row[j]
    if not share and not moved:
        return row
    left = [
        (x - share * a, y - moved * b) for (x, y), (a, b) in zip(row[j:], lead[j:], strict=True)
    ]
    return [*row[:j], *left]


def _weights(found: _Echelon, columns: Iterable[int]) -> _Weights:
    """Return, for each column without a pivot, the weights of the pivots whose sum it is."""
    return {
        j: {p: _simplified(row[j][0]) for p, row in sorted(found.items()) if row[j][0]}
        for j in columns
        if j not in found
    }


def _remainder(row: _Row, j: int, weights: Mapping[int, Any], *, rounded: bool = False) -> Any:
    """Return the remainder of column `j` after a weighted sum of other columns, at one point.

    The remainder is relative to the size of the terms, and 0 if rounding may explain it.

    Parameters
    ----------
    row : row of Value
        Values of all columns at the point.
    j : int
        The dependent column.
    weights : mapping of int to number
        Weights of the other columns.
    rounded : bool
        Whether decimals may be products that the user rounded.
    """
    value, moved = row[j]
    terms = [weight * row[p][0] for p, weight in weights.items()]
    noise = sum((abs(w * (row[p][0] - row[p][1])) for p, w in weights.items()), abs(value - moved))
    left, size = abs(value - sum(terms)), abs(value) + sum(map(abs, terms))
    allowed = max(_EXACT * size, _NOTHING_LEFT * noise)
    if rounded:
        allowed = max(allowed, _ROUNDED * min(size, _MOST_CANCELLED * abs(value)))
    return left / size if left > allowed else 0


def _fractions(row: _Row, without: Collection[int]) -> Row:
    """Return a row as fractions, with 0 in the columns `without`."""
    return [Fraction(0) if j in without or not x else _fraction(x) for j, (x, _) in enumerate(row)]


def _simplified(number: Any) -> Any:
    """Return a number as a float of many digits, rounded as in `_fraction`."""
    fraction = _fraction(number)
    return numbers.mpf(fraction.numerator) / fraction.denominator


def _is_simple(number: Any) -> bool:
    """Return whether a number is a fraction of numbers that are too small for a coincidence."""
    fraction = _fraction(number)
    return abs(fraction.numerator) * fraction.denominator <= _SHORT


def _fraction(number: Any) -> Fraction:
    """Return a number as a fraction: a simple fraction if it agrees to 40 digits, else exactly.

    A number of more than 1000 binary digits before or behind the point is limited to that size.
    """
    size = numbers.mag(number)
    if abs(size) > _LARGEST:
        number = numbers.ldexp(numbers.sign(number), max(-_LARGEST, min(size, _LARGEST)))
    sign, mantissa, exponent, _ = number._mpf_
    exact = Fraction(-int(mantissa) if sign else int(mantissa)) * Fraction(2) ** int(exponent)
    simple = exact.limit_denominator(_SIMPLE)
    return simple if abs(simple - exact) <= abs(exact) / 10**_SAME else exact
