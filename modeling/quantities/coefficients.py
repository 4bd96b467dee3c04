"""What multiplies products of parameters in a force, and which of it is independent.

Only the parameters are multiplied out; what does not depend on them stays as it was written. Rows
of numbers get their reduced row echelon form, where rounding tells what is nothing.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set as AbstractSet
from fractions import Fraction
from functools import cache
from typing import Any, TypeAlias

import sympy
from sympy.ntheory.multinomial import multinomial_coefficients

from axisid.support.errors import ModelError
from axisid.support.mappings import grouped

from .point_value import (
    CANNOT,
    NOTHING,
    Points,
    Value,
    depends,
    exactly,
    is_nothing,
    numbers,
    off_as_decimal,
    rounding,
    vanishes,
)
from .symbols import check_size

#: Products of two terms that may be formed for one expression.
_MOST_PRODUCTS = 100_000

#: Powers of the parameters, whole ones of either sign.
Exponents = tuple[int, ...]
_Polynomial = dict[Exponents, sympy.Expr]


class Coefficients:
    """An expression as a polynomial of parameters, with expressions for its weights.

    Parameters
    ----------
    expression : sympy.Expr
    parameters : sequence of sympy.Symbol
        Those that it is a polynomial of, once everything that cancels is left out.
    motion : set of sympy.Symbol
        Those of them that count as motion, and have no powers.

    Attributes
    ----------
    terms : dict
        The weights by the products of powers; what no parameter multiplies too.

    Raises
    ------
    ModelError
        It has too many terms, or too large ones.
    """

    def __init__(
        self,
        expression: sympy.Expr,
        parameters: Sequence[sympy.Symbol],
        motion: AbstractSet[sympy.Symbol] = frozenset(),
    ) -> None:
        self._one = (0,) * len(parameters)
        self._places = {p: j for j, p in enumerate(parameters) if p not in motion}
        self._zero = dict.fromkeys(self._places, sympy.S.Zero)
        self._of = cache(self._worked_out)
        self._left = _MOST_PRODUCTS
        self._hidden: set[sympy.Symbol] = set()
        self.terms = self._of(expression)
        for weight in self.terms.values():
            check_size(weight, "the equation of motion, multiplied out,")

    @property
    def nonlinear(self) -> set[sympy.Symbol]:
        """The parameters that the expression is no polynomial of."""
        divisors = {
            p
            for exponents, weight in self.terms.items()
            for p, j in self._places.items()
            if exponents[j] < 0 and not vanishes(weight)
        }
        return self._hidden | divisors

    def _worked_out(self, node: sympy.Expr) -> _Polynomial:
        if not node.free_symbols & self._places.keys():
            return {self._one: node}
        base, power = node.as_base_exp()
        whole = int(power) if power.is_Number and int(power) == float(power) else None
        if base in self._places and whole is not None:
            exponents = list(self._one)
            exponents[self._places[base]] = whole
            return {tuple(exponents): sympy.S.One}
        if node.is_Add:
            return _sum(map(self._of, node.args))
        if node.is_Mul:
            return self._product(map(self._of, node.args))
        if node.is_Pow and whole is not None and whole > 0:
            return self._power(self._of(base), whole)
        if isinstance(node, sympy.Piecewise):
            return self._chosen(node)
        return {self._one: self._opaque(node).xreplace(self._zero)}

    def _opaque(self, node: sympy.Basic) -> sympy.Basic:
        """A node that is taken as a whole; some of the parameters in it may cancel."""
        shown = node if isinstance(node, sympy.Expr) else sympy.Piecewise((1, node), (0, True))
        inside = node.free_symbols & self._places.keys() - self._hidden
        self._hidden |= {p for p in inside if depends(shown, {p})}
        return node

    def _chosen(self, node: sympy.Piecewise) -> _Polynomial:
        """The weights of what is chosen by conditions, chosen by the same."""
        values = [self._of(value) for value, _ in node.args]
        conditions = [self._opaque(c).xreplace(self._zero) for _, c in node.args]
        return {
            exponents: sympy.Piecewise(
                *(
                    (value.get(exponents, sympy.S.Zero), condition)
                    for value, condition in zip(values, conditions, strict=True)
                ),
                evaluate=False,  # its evaluation compares all conditions with all
            )
            for exponents in dict.fromkeys(e for value in values for e in value)
            if any(value.get(exponents, 0) != 0 for value in values)
        }

    def _power(self, base: _Polynomial, whole: int) -> _Polynomial:
        """By the multinomial theorem: a product after another nests sums in sums."""
        self._take(math.comb(whole + len(base) - 1, whole))
        shares = multinomial_coefficients(len(base), whole)
        return _sum(
            {
                tuple(
                    sum(k * e for k, e in zip(powers, each, strict=True))
                    for each in zip(*base, strict=True)
                ): (sympy.Mul(count, *(w**k for w, k in zip(base.values(), powers, strict=True))))
            }
            for powers, count in shares.items()
        )

    def _take(self, terms: int) -> None:
        self._left -= terms
        if self._left < 0:
            raise ModelError(
                "the equation of motion has too many products of parameters.",
                code="equation",
            )

    def _product(self, factors: Iterable[_Polynomial]) -> _Polynomial:
        made: _Polynomial = {self._one: sympy.S.One}
        for factor in factors:
            self._take(len(made) * len(factor))
            made = _sum(
                {tuple(map(sum, zip(a, b, strict=True))): x * y}
                for a, x in made.items()
                for b, y in factor.items()
            )
        return made


def _sum(polynomials: Iterable[_Polynomial]) -> _Polynomial:
    terms = grouped(term for polynomial in polynomials for term in polynomial.items())
    return {exponents: sympy.Add(*weights) for exponents, weights in terms.items()}


#: Exact, or all digits that there are.
Row: TypeAlias = list[Fraction]
_Row: TypeAlias = list[Value]
#: Rows by the column in which they have a 1 and all others a 0.
_Echelon: TypeAlias = dict[int, _Row]

_MOST_STEPS = 2_000_000  # numbers that are worked out
_FAILURES = 40  # points in a row at which a function may have no value
_SIMPLE, _SAME = 10**15, 40  # the largest divisor of a simple fraction, and its digits
_LARGEST = 1000  # binary digits of a number, beyond which all are alike


class NotRealError(ModelError):
    """A part of an expression is no finite real number, whatever the motion."""

    code = "formula"


def reduced_rows(rows: Sequence[Row]) -> tuple[list[Row], list[int]]:
    """Reduced row echelon form without its zero rows, and its pivot columns.

    What is left where weights cancel is nothing if it is no more than rounding leaves: a product
    of decimals computed in floating point is not the product of these decimals.

    Raises
    ------
    ModelError
        There are too many weights to be worked out.
    """
    _check_size(len(rows), max(map(len, rows), default=0))
    return _finished(_echelon(([off_as_decimal(x) for x in row] for row in rows), len(rows)))


def reduced_functions(
    functions: Sequence[sympy.Expr],
    velocity: sympy.Symbol,
    given: Mapping[sympy.Symbol, sympy.Rational] | None = None,
) -> tuple[list[Row], list[int]]:
    """The same of the values of functions at as many points as it takes.

    The columns that stand for a function each tell which combinations of functions are 0 anywhere.

    Raises
    ------
    NotRealError
        A function has no finite value.
    ModelError
        There are too many functions.
    """
    numbered = {s: exactly(numbers.mpf(x.p) / x.q) for s, x in (given or {}).items()}
    _check_size(len({f.as_coeff_Mul()[1] for f in functions}), len(functions))
    points = Points(*functions, velocity=velocity, given=numbered)
    rank = -1
    while True:
        with points.digits():
            found = _echelon(_rows_at(points, functions), points.count)
            if len(found) in (rank, len(functions)):
                return _finished(found)
        rank = len(found)
        points.look_closer()


def _check_size(independent: int, columns: int) -> None:
    if independent**2 * columns > _MOST_STEPS:
        raise ModelError(
            "the parameters enter in too many products and sums to find which of them a "
            "record tells apart; declare what enters together as one parameter."
        )


def _rows_at(points: Points, functions: Sequence[sympy.Expr]) -> Iterator[_Row]:
    """Values at point after point; real and imaginary parts apart."""
    turn = failures = 0
    while failures < _FAILURES:
        values = points.at(turn)
        turn += 1
        try:
            row = [values(function) for function in functions]
            if not all(numbers.isfinite(part) for pair in row for part in pair):
                raise ValueError("it is not finite")
        except CANNOT:
            failures += 1
            continue
        failures = 0
        yield [(numbers.re(x), values.off(numbers.re(y))) for x, y in row]
        if any(numbers.im(x) for x, _ in row):
            yield [(numbers.im(x), values.off(numbers.im(y))) for x, y in row]
    raise NotRealError(f"a part of {', '.join(map(str, functions))} has no finite real value.")


def _echelon(rows: Iterable[_Row], idle: int) -> _Echelon:
    """Reduce rows until there is one for each column, or so many in a row have nothing new."""
    found: _Echelon = {}
    without, off = 0, rounding(0)
    for row in rows:
        lead, pivot = row, _first(row)
        while pivot in found:
            lead = _less(lead, found[pivot], pivot)
            pivot = _first(lead, pivot + 1)
        without = without + 1 if pivot is None else 0
        if pivot is not None:
            number, moved = lead[pivot]
            # Off once more: what a row brings into others cancels alike in both numbers.
            found[pivot] = [(x / number, off(y / moved)) for x, y in lead]
        if len(found) == len(row):
            return {j: [exactly(numbers.mpf(i == j)) for i in range(len(row))] for j in found}
        if without == idle:
            break
    for j in sorted(found, reverse=True):
        for i in sorted(i for i in found if i > j):
            found[j] = _less(found[j], found[i], i)
        found[j] = [NOTHING if is_nothing(value) else value for value in found[j]]
    return found


def _first(row: _Row, start: int = 0) -> int | None:
    """The first column from one on in which something is."""
    return next((j for j in range(start, len(row)) if not is_nothing(row[j])), None)


def _less(row: _Row, lead: _Row, j: int) -> _Row:
    """A row less what it has in column j of another, whose number there is 1."""
    share, moved = row[j]
    left = [
        (x - share * a, y - moved * b) for (x, y), (a, b) in zip(row[j:], lead[j:], strict=True)
    ]
    return [*row[:j], *left]


def _finished(found: _Echelon) -> tuple[list[Row], list[int]]:
    pivots = sorted(found)
    return [[_fraction(x) if x else Fraction(0) for x, _ in found[j]] for j in pivots], pivots


def _fraction(number: Any) -> Fraction:
    """A number as a fraction, a simple one if it is one but for the last digits."""
    size = numbers.mag(number)
    if abs(size) > _LARGEST:
        number = numbers.ldexp(numbers.sign(number), max(-_LARGEST, min(size, _LARGEST)))
    sign, mantissa, exponent, _ = number._mpf_
    exact = Fraction(-int(mantissa) if sign else int(mantissa)) * Fraction(2) ** int(exponent)
    simple = exact.limit_denominator(_SIMPLE)
    return simple if abs(simple - exact) <= abs(exact) / 10**_SAME else exact
