"""What multiplies products of parameters in a force, and which of it is independent.

Only the parameters are multiplied out; what does not depend on them stays as it was written. Rows
of numbers get their reduced row echelon form, where rounding tells what is nothing.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set as AbstractSet
from fractions import Fraction
from functools import reduce
from typing import Any, TypeAlias

import sympy
from sympy import EXRAW
from sympy.polys.rings import PolyElement, PolyRing

from axisid.modeling.quantities import check_size
from axisid.support.errors import ModelError

from .point_value import (
    CANNOT,
    NOTHING,
    Points,
    Value,
    dependences,
    exactly,
    is_zero,
    numbers,
    perturbation,
    perturbed_decimal,
    vanishes,
)

#: Products of two terms that may be formed for one expression.
_MOST_PRODUCTS = 100_000

#: Powers of the parameters, whole ones of either sign.
Exponents = tuple[int, ...]


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
        # Of polynomials whose weights are expressions, which SymPy leaves as they are written.
        self._ring = PolyRing(parameters, EXRAW)
        self._polynomials: dict[sympy.Basic, PolyElement] = {}
        self._budget = _MOST_PRODUCTS
        self._hidden: set[sympy.Symbol] = set()
        self.terms: dict[Exponents, sympy.Expr] = dict(self._of(expression))
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

    def _of(self, node: sympy.Expr) -> PolyElement:
        if node not in self._polynomials:
            self._polynomials[node] = self._worked_out(node)
        return self._polynomials[node]

    def _worked_out(self, node: sympy.Expr) -> PolyElement:
        if not node.free_symbols & self._places.keys():
            return self._ring.ground_new(node)
        base, power = node.as_base_exp()
        whole = int(power) if power.is_Number and int(power) == float(power) else None
        if base in self._places and whole is not None:
            exponents = list(self._one)
            exponents[self._places[base]] = whole
            return self._ring.from_dict({tuple(exponents): sympy.S.One})
        if node.is_Add:
            return sum(map(self._of, node.args), self._ring.zero)
        if node.is_Mul:
            return reduce(self._product, map(self._of, node.args))
        if node.is_Pow and whole is not None and whole > 0:
            inner = self._of(base)
            self._take(math.comb(whole + len(inner) - 1, whole))
            return inner**whole
        if isinstance(node, sympy.Piecewise):
            return self._chosen(node)
        return self._ring.ground_new(self._opaque(node).xreplace(self._zero))

    def _opaque(self, node: sympy.Basic) -> sympy.Basic:
        """A node that is taken as a whole; some of the parameters in it may cancel."""
        shown = node if isinstance(node, sympy.Expr) else sympy.Piecewise((1, node), (0, True))
        inside = node.free_symbols & self._places.keys() - self._hidden
        self._hidden |= {p for (p,) in dependences(shown, [{p} for p in inside])}
        return node

    def _chosen(self, node: sympy.Piecewise) -> PolyElement:
        """The weights of what is chosen by conditions, chosen by the same."""
        values = [self._of(value) for value, _ in node.args]
        conditions = [self._opaque(c).xreplace(self._zero) for _, c in node.args]
        weights = {
            exponents: sympy.Piecewise(
                *(
                    (value.get(exponents, sympy.S.Zero), condition)
                    for value, condition in zip(values, conditions, strict=True)
                ),
                evaluate=False,  # its evaluation compares all conditions with all
            )
            for exponents in dict.fromkeys(e for value in values for e in value)
        }
        return self._ring.from_dict(weights)

    def _take(self, terms: int) -> None:
        self._budget -= terms
        if self._budget < 0:
            raise ModelError(
                "the equation of motion has too many products of parameters.",
                code="equation",
            )

    def _product(self, one: PolyElement, other: PolyElement) -> PolyElement:
        self._take(len(one) * len(other))
        return one * other


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
    return _finished(_echelon(([perturbed_decimal(x) for x in row] for row in rows), len(rows)))


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
            echelon = _echelon(_rows_at(points, functions), points.count)
            if len(echelon) in (rank, len(functions)):
                return _finished(echelon)
        rank = len(echelon)
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
        yield [(numbers.re(x), values.perturb(numbers.re(y))) for x, y in row]
        if any(numbers.im(x) for x, _ in row):
            yield [(numbers.im(x), values.perturb(numbers.im(y))) for x, y in row]
    raise NotRealError(f"a part of {', '.join(map(str, functions))} has no finite real value.")


def _echelon(rows: Iterable[_Row], idle: int) -> _Echelon:
    """Reduce rows until there is one for each column, or so many in a row have nothing new."""
    echelon: _Echelon = {}
    without, perturb = 0, perturbation(0)
    for row in rows:
        lead, pivot = row, _first(row)
        while pivot in echelon:
            lead = _less(lead, echelon[pivot], pivot)
            pivot = _first(lead, pivot + 1)
        without = without + 1 if pivot is None else 0
        if pivot is not None:
            number, perturbed = lead[pivot]
            # Off once more: what a row brings into others cancels alike in both numbers.
            echelon[pivot] = [(x / number, perturb(y / perturbed)) for x, y in lead]
        if len(echelon) == len(row):
            return {j: [exactly(numbers.mpf(i == j)) for i in range(len(row))] for j in echelon}
        if without == idle:
            break
    for j in sorted(echelon, reverse=True):
        for i in sorted(i for i in echelon if i > j):
            echelon[j] = _less(echelon[j], echelon[i], i)
        echelon[j] = [NOTHING if is_zero(value) else value for value in echelon[j]]
    return echelon


def _first(row: _Row, start: int = 0) -> int | None:
    """The first column from one on in which something is."""
    return next((j for j in range(start, len(row)) if not is_zero(row[j])), None)


def _less(row: _Row, lead: _Row, j: int) -> _Row:
    """A row less what it has in column j of another, whose number there is 1."""
    share, perturbed = row[j]
    left = [
        (x - share * a, y - perturbed * b) for (x, y), (a, b) in zip(row[j:], lead[j:], strict=True)
    ]
    return [*row[:j], *left]


def _finished(echelon: _Echelon) -> tuple[list[Row], list[int]]:
    pivots = sorted(echelon)
    return [[_fraction(x) if x else Fraction(0) for x, _ in echelon[j]] for j in pivots], pivots


def _fraction(number: Any) -> Fraction:
    """A number as a fraction, a simple one if it is one but for the last digits."""
    size = numbers.mag(number)
    if abs(size) > _LARGEST:
        number = numbers.ldexp(numbers.sign(number), max(-_LARGEST, min(size, _LARGEST)))
    sign, mantissa, exponent, _ = number._mpf_
    exact = Fraction(-int(mantissa) if sign else int(mantissa)) * Fraction(2) ** int(exponent)
    simple = exact.limit_denominator(_SIMPLE)
    return simple if abs(simple - exact) <= abs(exact) / 10**_SAME else exact
