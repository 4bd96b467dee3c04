"""Which functions of the motion depend on each other, by their values at random motions.

Functions that are dependent at every motion are so at random ones, and those that are independent
are so at as many motions as there are functions, if these are where each of them has something to
show: on both sides of each kink, within each bell, where no hyperbolic tangent is 1 to all digits.
"""

import random
from collections.abc import Iterable, Mapping, Sequence, Set as AbstractSet
from fractions import Fraction
from typing import Any, NamedTuple

import sympy
from mpmath import libmp
from sympy.core.relational import Relational
from sympy.functions.elementary.miscellaneous import Max, Min

from axisid.modeling.algebra import CANNOT, numbers, value_at, values_at
from axisid.modeling.quantities import DIRECTION
from axisid.support.errors import ModelError

from .echelon import Row, meant

_SCALES = 1.0, 0.5  # the largest value of a function, and its median, over which it is compared
_NEAR, _FAR = 0.5, 3  # powers of ten by which the numbers of a motion are larger or smaller than 1
_SPARE = 2  # motions more than functions
_TRIES = 8  # for each motion at which all functions are real
_ROUNDS = 4
#: Sides and powers of ten of the numbers that each argument is to be,
_TARGETS = ((-1, -5, -1), (1, -5, -1), (-1, -1, 1), (1, -1, 1))
_MOST_TARGETED = 300  # and motions at which any is one.
_SECANTS, _FURTHEST = 25, 1e9
_MOST_WORK = 1_000_000  # nodes evaluated, and numbers of the table
_MOST_FUNCTIONS = 200
#: Binary digits of a value beside those of what was added up: what decimals leave when they are
#: rounded, less than any leave, and what is left of nothing.
_ROUNDING, _DOUBTFUL, _EXACT = -40, -83, -150
_NONE = -(10**15)  # binary digits before the point of 0
_MOST_BITS = 1000  # of a weight, or of its inverse
_PRECISION = 240  # binary digits
_NOTHING = (libmp.fzero, _NONE, _NONE)
#: Functions that have something to show everywhere, or that bend by the conditions in them.
_EVEN = (sympy.sin, sympy.cos, sympy.Piecewise)
_Point = dict[sympy.Symbol, Any]


class _Value(NamedTuple):
    """A number as mpmath's functions have it, and the size of what was added up to it.

    Both sizes are binary digits before the point.
    """

    number: Any
    bits: int
    size: int

    @property
    def certainty(self) -> int:
        """How little has cancelled."""
        return self.bits - self.size


_Row = dict[int, _Value]


def independent(
    functions: Sequence[sympy.Expr],
    velocity: sympy.Symbol,
    values: Mapping[sympy.Symbol, Any],
    positive: AbstractSet[sympy.Symbol] = frozenset(),
) -> list[Row]:
    """Functions of the motion as sums of as few of them as there are independent ones.

    Parameters
    ----------
    functions : sequence of sympy.Expr
    velocity : sympy.Symbol
        The friction direction is its sign.
    values : mapping of sympy.Symbol to number
        Of symbols that are not moved.
    positive : set of sympy.Symbol
        Those that are moved within positive numbers.

    Returns
    -------
    list of rows
        One for each independent function, with its weight in each of the functions.

    Raises
    ------
    ModelError
        They are too large or too many, have no real values at any motion, or nearly depend on each
        other.
    """
    if len(functions) > _MOST_FUNCTIONS:
        raise ModelError(
            "the parameters multiply too many functions of the motion to find which of them a "
            "record tells apart; declare what enters together as one parameter.",
            code="too-many-terms",
        )
    motions, width = _Motions(functions, velocity, values, positive), len(functions)
    found = motions.general(width + _SPARE)
    tables, held = _tables(found, width, motions), False
    for _ in range(_ROUNDS):
        if held or (motions.real and tables[0].rank == width):
            break
        rank = tables[0].rank
        found += motions.targeted()
        tables = _tables(found, width, motions)
        further = motions.general(width, _NEAR) + motions.general(width)
        holding = [table for table in tables if table.holds_at(further)]
        held = bool(holding) and tables[0].rank == rank
        tables = holding or tables
        found += further
    if not motions.real:
        raise ModelError(
            "the equation of motion has no finite real value at any motion.", code="no-real-number"
        )
    if tables[0].rank < width and (tables[0].doubtful or not held):
        raise ModelError(
            "what parameters do to the force differs by less than 1e-25 of its size, which no "
            "record shows and no rounding of decimals leaves; declare what does nearly the "
            "same as one parameter.",
            code="nearly-dependent",
        )
    return tables[0].weights()


def _tables(values: Sequence[Sequence[_Value]], width: int, motions: "_Motions") -> list["_Table"]:
    """Those of most rows: what is independent in one order of steps may be lost in another."""
    tables = [_Table(values, width, rank, motions) for rank in _SCALES]
    most = max(table.rank for table in tables)
    return [table for table in tables if table.rank == most]


class _Table:
    """Values of functions, one row for each motion, reduced to those of independent ones."""

    def __init__(
        self, values: Sequence[Sequence[_Value]], width: int, rank: float, motions: "_Motions"
    ) -> None:
        self._width = width
        rows = [{j: entry for j, entry in enumerate(row) if entry.size > _NONE} for row in values]
        sizes = [sorted(row[j].bits for row in rows if j in row) or [0] for j in range(width)]
        self._scales = [column[round(rank * (len(column) - 1))] for column in sizes]
        self._rows: dict[int, _Row] = {}  # by the column that each leads
        leads = {i: lead for i, row in enumerate(rows) if (lead := self._lead(row))}
        while leads:
            i = max(leads, key=lambda i: (leads[i], i))
            j, best = leads.pop(i)[2], rows[i]
            rows[i] = {}
            self._rows[j] = best
            for k, row in enumerate(rows):
                if j in row:
                    motions.work(len(best))
                    rows[k] = _less(row, best, j)
                    leads.pop(k, None)
                    if lead := self._lead(rows[k]):
                        leads[k] = lead
        self.doubtful = any(_EXACT < e.certainty < _DOUBTFUL for row in rows for e in row.values())

    @property
    def rank(self) -> int:
        """How many functions are independent."""
        return len(self._rows)

    def _lead(self, row: _Row) -> tuple[int, int, int] | None:
        """Column of the value by which a row may lead, after how well it does.

        Of it least is lost; and it is largest beside the others of its row, which it moves least.
        """
        sizes = {j: x.size - self._scales[j] for j, x in row.items()}
        first, second = (*sorted(sizes.values(), reverse=True)[:2], _NONE, _NONE)[:2]
        found = [
            (
                x.certainty // 8,
                x.bits - self._scales[j] - (second if sizes[j] == first else first),
                j,
            )
            for j, x in row.items()
            if x.certainty > _ROUNDING
        ]
        return max(found, default=None)

    def weights(self) -> list[Row]:
        """The functions by independent ones."""
        return [
            [_weight(row[k], row[j]) if k in row else Fraction(0) for k in range(self._width)]
            for j, row in self._reduced().items()
        ]

    def holds_at(self, values: Sequence[Sequence[_Value]]) -> bool:
        """Whether all functions are these sums of the independent ones at further motions."""
        reduced = self._reduced()
        return all(
            _is_sum(
                row[k], [(row[j], lead[j], lead[k]) for j, lead in reduced.items() if k in lead]
            )
            for row in values
            for k in range(self._width)
        )

    def _reduced(self) -> dict[int, _Row]:
        """The rows by the columns that they lead, without these columns in others."""
        done: dict[int, _Row] = {}
        for j, row in reversed(self._rows.items()):
            left = dict(row)
            for k, lead in done.items():
                left = _less(left, lead, k)
            done[j] = left
        return done


def _is_sum(value: _Value, terms: Iterable[tuple[_Value, _Value, _Value]]) -> bool:
    """Whether a value is that of terms ``x / y * z``, up to rounding."""
    total, size = libmp.mpf_neg(value.number), value.size
    for x, y, z in terms:
        if z.certainty > _ROUNDING:
            share = libmp.mpf_div(z.number, y.number, _PRECISION)
            term = libmp.mpf_mul(x.number, share, _PRECISION)
            total, size = libmp.mpf_add(total, term, _PRECISION), max(size, _bits(term))
    return total == libmp.fzero or _bits(total) <= size + _ROUNDING


def _less(row: _Row, lead: _Row, j: int) -> _Row:
    """A row less what it has in column j of another."""
    if j not in row:
        return row
    (x, x_bits, x_size), (pivot, bits, size) = row[j], lead[j]
    share = libmp.mpf_div(x, pivot, _PRECISION)
    share_bits, share_size = x_bits - bits, max(x_size, x_bits + size - bits) - bits
    left = {k: y for k, y in row.items() if k != j}
    for k, (y, y_bits, y_size) in lead.items():
        if k != j:
            old, _, old_size = left.get(k, _NOTHING)
            made = libmp.mpf_sub(old, libmp.mpf_mul(share, y, _PRECISION), _PRECISION)
            size = max(old_size, share_bits + y_size, share_size + y_bits)
            left[k] = _Value(made, _bits(made), size)
    return left


def _bits(number: Any) -> int:
    """Binary digits before the point."""
    return int(number[2] + number[3]) if number[1] else _NONE


def _weight(value: _Value, lead: _Value) -> Fraction:
    """A number as it was meant, or 0 where it is what rounding left."""
    if value.certainty <= _ROUNDING:
        return Fraction(0)
    sign, mantissa, exponent, _ = libmp.mpf_div(value.number, lead.number, _PRECISION)
    exponent = min(max(exponent, -_MOST_BITS), _MOST_BITS)
    return meant(Fraction((-1) ** sign * int(mantissa)) * Fraction(2) ** exponent)


class _Motions:
    """Values of functions at motions that have nothing to do with each other."""

    def __init__(
        self,
        functions: Sequence[sympy.Expr],
        velocity: sympy.Symbol,
        values: Mapping[sympy.Symbol, Any],
        positive: AbstractSet[sympy.Symbol],
    ) -> None:
        self._functions, self._velocity = functions, velocity
        self._values, self._positive = values, positive
        self._nodes = _nodes(functions)
        symbols = {node for node in self._nodes if node.is_Symbol} | {velocity}
        moved = symbols - {DIRECTION} - values.keys()
        self._moved = sorted(moved, key=str)
        self._random = random.Random(1)  # noqa: S311  # the same motions each time
        self._left = _MOST_WORK
        self.real = False  # whether the functions have been so at any motion

    def general(self, count: int, span: float = _FAR) -> list[list[_Value]]:
        """Values at a number of motions, or fewer if the functions are hardly anywhere real."""
        found: list[list[_Value]] = []
        for _ in range(_TRIES * count):
            if len(found) == count:
                break
            found += self._values_at(self._point(span))
        return found

    def targeted(self) -> list[list[_Value]]:
        """Values at motions at which what functions bend by is neither too large nor too small.

        Beside an exponential that is far out, nothing else shows: some motions are all near 1.
        """
        count = len(self._functions) + _SPARE
        found = self.general(count) + self.general(count, _NEAR)
        places = [
            (argument, symbol, *target)
            for argument in _arguments(self._nodes)
            for symbol in self._moved
            if symbol in argument.free_symbols - self._positive
            for target in _TARGETS
        ]
        if len(places) > _MOST_TARGETED:
            places = self._random.sample(places, _MOST_TARGETED)
        for place in places:
            point = self._solved(*place)
            found += [] if point is None else self._values_at(point)
        return found

    def work(self, nodes: int) -> None:
        """Count what is worked out, and refuse more than allowed."""
        self._left -= nodes
        if self._left < 0:
            raise ModelError(
                "the equation of motion has too many terms to find what a record tells apart; "
                "write less of it.",
                code="too-many-terms",
            )

    def _values_at(self, point: _Point) -> list[list[_Value]]:
        """One row of values, or none where one of them is not real."""
        self.work(len(self._nodes))
        try:
            found = values_at(self._functions, self._directed(point))
            self.real = True
            return [[_Value(x._mpf_, _bits(x._mpf_), _bits(size._mpf_)) for x, size in found]]
        except CANNOT:
            return []

    def _point(self, span: float = _FAR) -> _Point:
        """Numbers of all sizes within powers of ten; those that are positive are near 1."""
        draw = self._random.uniform
        point = {
            s: numbers.mpf(draw(0.3, 1.7))
            if s in self._positive
            else self._random.choice((-1, 1)) * numbers.mpf(10) ** draw(-span, span)
            for s in self._moved
        }
        return {**point, **self._values}

    def _directed(self, point: _Point) -> _Point:
        return {**point, DIRECTION: numbers.sign(point[self._velocity])}

    def _solved(
        self, argument: sympy.Expr, symbol: sympy.Symbol, side: int, least: int, most: int
    ) -> _Point | None:
        """A motion at which an argument is about some number, by the secant method."""
        target = side * numbers.mpf(10) ** self._random.uniform(least, most)
        point = self._point()
        here, there = point[symbol], point[symbol] * numbers.mpf(9) / 8
        try:
            before, now = (self._miss(argument, {**point, symbol: x}) for x in (here, there))
            for _ in range(_SECANTS):
                if abs(now - target) < abs(target) / 2:
                    return {**point, symbol: there}
                slope = (now - before) / (there - here)
                here, there, before = there, there + (target - now) / slope, now
                if not abs(there) < _FURTHEST:
                    break
                now = self._miss(argument, {**point, symbol: there})
        except CANNOT:
            pass
        return None

    def _miss(self, argument: sympy.Expr, point: _Point) -> Any:
        return value_at(argument, self._directed(point))


def _nodes(functions: Sequence[sympy.Basic]) -> set[sympy.Basic]:
    """All nodes of expressions, each once."""
    found: set[sympy.Basic] = set()
    left = list(functions)
    while left:
        node = left.pop()
        if node not in found:
            found.add(node)
            left += node.args
    return found


def _arguments(nodes: AbstractSet[sympy.Basic]) -> list[sympy.Expr]:
    """What functions bend, jump or saturate by."""
    found: set[sympy.Expr] = set()
    for node in nodes:
        if isinstance(node, (Relational, Max, Min)):
            first, *others = node.args
            found |= {first - other for other in others}
        elif not isinstance(node, _EVEN) and (
            isinstance(node, sympy.Function)
            or (node.is_Pow and not (node.exp.is_Integer and node.exp > 0))
        ):
            found |= set(node.args)
    return sorted(found, key=sympy.default_sort_key)
