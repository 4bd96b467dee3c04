"""The force as functions of the motion times monomials of the parameters, and what is independent.

``force = sum of f_i(motion) A_ij mu_j(parameters)``, with exact weights A. Its reduced row echelon
form R is the smallest set of combinations ``R mu`` that the force depends on.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import sympy

from axisid.modeling.algebra import (
    EULER,
    Algebra,
    Expansion,
    Number,
    Product,
    Sum,
    TooLargeError,
    modulus_of,
    value_of,
)
from axisid.modeling.quantities import rounded
from axisid.support.errors import ModelError

#: Share of what was added up below which a weight is what rounding left of nothing.
_ROUNDING = Fraction(1, 10**12)
_LONG, _KEPT = 2000, 400  # binary digits from which a weight is rounded, and to which
_LEAST = Fraction(1, 10**300)  # share of a row that stands for any smaller one
_MOST_STEPS = 300_000  # weights that are worked out in reducing rows
_SHOWN = 120  # letters of a term

Exponents = tuple[int, ...]
Row = list[Fraction]
#: Weights by column, each with the size of what was added up to it; those left out are 0.
_Tracked = dict[int, tuple[Fraction, Fraction]]
_NOTHING = (Fraction(0), Fraction(0))
_Weight = tuple[Number, Number]  # times a power of e


@dataclass(frozen=True, slots=True, kw_only=True)
class Terms:
    """The force over the functions of the motion that occur in it.

    Attributes
    ----------
    monomials : tuple of tuple of int
        Distinct, with exponents by parameter; the parameters themselves first, in their order.
    weights : tuple of list of Fraction
        One row for each function of the motion, scaled at will, one column for each monomial.
    nonlinear : frozenset of sympy.Symbol
        Parameters that enter other than by whole powers; they count as motion, and each has a row
        and a column of its own.
    """

    monomials: tuple[Exponents, ...]
    weights: tuple[Row, ...]
    nonlinear: frozenset[sympy.Symbol]


def force_terms(
    force: sympy.Expr, velocity: sympy.Symbol, parameters: Sequence[sympy.Symbol]
) -> Terms:
    """Split a force into functions of the motion and monomials of the parameters.

    Parameters
    ----------
    force : sympy.Expr
        With the friction direction in place of ``sign(dq)``.
    velocity : sympy.Symbol
    parameters : sequence of sympy.Symbol

    Raises
    ------
    ModelError
        It has too many terms once it is multiplied out, or a part that is no real number.
    """
    expansion = Expansion(velocity)
    parts = [_expanded(term, expansion) for term in sympy.Add.make_args(force)]
    return _terms(parts, expansion.algebra, parameters)


def column_terms(
    columns: Mapping[sympy.Symbol, sympy.Expr],
    velocity: sympy.Symbol,
    values: Mapping[sympy.Symbol, Number],
) -> Terms:
    """The same of the sum of parameters times columns, with numbers for symbols in the columns."""
    expansion = Expansion(velocity, values)
    parts = [
        expansion.algebra.times(expansion.free(p), expansion(term))
        for p, column in columns.items()
        for term in sympy.Add.make_args(column)
    ]
    return _terms(parts, expansion.algebra, tuple(columns))


def _expanded(term: sympy.Expr, expansion: Expansion) -> Sum:
    try:
        return expansion(term)
    except TooLargeError as error:
        text = str(rounded(term))
        shown = text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."
        raise TooLargeError(f"{error} What takes long is the term {shown}") from error


def _terms(parts: Iterable[Sum], algebra: Algebra, parameters: Sequence[sympy.Symbol]) -> Terms:
    total, unknown = _added(parts), set(parameters)
    nonlinear = {
        s
        for product in total
        for place, power in product
        if not (algebra.factor(place).kind == "symbol" and power.denominator == 1 and power > 0)
        for s in algebra.factor(place).symbols & unknown
    }
    linear = {p: j for j, p in enumerate(parameters) if p not in nonlinear}
    table: dict[Product, dict[Exponents, list[_Weight]]] = {}
    for product, weight in total.items():
        motion, exponents, power = _split(product, algebra, linear, len(parameters))
        if any(exponents):
            row = table.setdefault(motion, {})
            row.setdefault(exponents, []).append((weight, power))
    rows = [_weights(row) for row in table.values()]
    for j, p in enumerate(parameters):
        if p in nonlinear:
            rows.append({tuple(int(i == j) for i in range(len(parameters))): Fraction(1)})
    found = {exponents for row in rows for exponents in row}
    monomials = tuple(sorted(found, key=_order))
    weights = tuple([row.get(e, Fraction(0)) for e in monomials] for row in rows)
    return Terms(monomials=monomials, weights=weights, nonlinear=frozenset(nonlinear))


def _added(parts: Iterable[Sum]) -> Sum:
    """The sum of declared terms, without what rounding alone leaves where they cancel."""
    weights: dict[Product, list[Number]] = {}
    for part in parts:
        for product, weight in part.items():
            weights.setdefault(product, []).append(weight)
    total: Sum = {}
    for product, several in weights.items():
        value = sum(several, Fraction(0))
        if modulus_of(value) > _ROUNDING * sum(map(modulus_of, several), Fraction(0)):
            total[product] = value
    return total


def _split(
    product: Product, algebra: Algebra, linear: Mapping[sympy.Symbol, int], size: int
) -> tuple[Product, Exponents, Number]:
    """The motion in a product, the exponents of the parameters in it, and the power of e."""
    exponents, motion = [0] * size, []
    euler: Number = 0
    for place, power in product:
        factor = algebra.factor(place)
        if factor.kind == "symbol" and factor.content in linear:
            exponents[linear[factor.content]] = int(power)
        elif factor == EULER:
            euler = power
        else:
            motion.append((place, power))
    return tuple(motion), tuple(exponents), euler


def _weights(row: Mapping[Exponents, Sequence[_Weight]]) -> dict[Exponents, Fraction]:
    """The weights of a row over its largest power of e, which may be beyond all floating point."""
    most = max(power for terms in row.values() for _, power in terms)
    made = {}
    for exponents, terms in row.items():
        value = sum((weight * _share(power - most) for weight, power in terms), Fraction(0))
        if value:
            made[exponents] = value
    return made


def _share(power: Number) -> Fraction:
    if not power:
        return Fraction(1)
    return max(value_of(sympy.exp, (power,)), _LEAST)


def reduced_rows(weights: Sequence[Row]) -> tuple[list[Row], list[int]]:
    """Reduced row echelon form without its zero rows, and its pivot columns.

    Exact, but that what rounding alone leaves where weights cancel counts as zero: a product of
    decimals computed in floating point is not the product of these decimals. A weight that is small
    beside others of its row is none of that: ``(x - 9)**12`` has weights from 1 to 3e11.

    Raises
    ------
    ModelError
        There are too many weights to be worked out.
    """
    width = len(weights[0]) if weights else 0
    sizes = [_size(row[j] for row in weights) for j in range(width)]
    rows = [_tracked([x / size for x, size in zip(row, sizes, strict=True)]) for row in weights]
    done: list[_Tracked] = []
    pivots: list[int] = []
    steps = 0
    for j in range(width):
        able = [row for row in rows if row.get(j, _NOTHING)[0]]
        if not able:
            continue
        best = max(able, key=lambda row: _certainty(row[j]))
        lead = _over(best, best[j][0])
        steps += len(lead) * (len(able) + sum(j in row for row in done))
        if steps > _MOST_STEPS:
            raise ModelError(
                "the parameters enter in too many products and sums to find which of them a "
                "record tells apart; declare what enters together as one parameter."
            )
        rows = [_less(row, lead, j) for row in rows if row is not best]
        done = [*(_less(row, lead, j) for row in done), lead]
        pivots.append(j)
    scaled = [
        [row.get(j, _NOTHING)[0] * sizes[j] / sizes[pivot] for j in range(width)]
        for row, pivot in zip(done, pivots, strict=True)
    ]
    return scaled, pivots


def _order(exponents: Exponents) -> tuple[int, tuple[int, ...]]:
    return sum(exponents), tuple(-e for e in exponents)


def _size(column: Iterable[Fraction]) -> Fraction:
    largest = max(map(abs, column), default=Fraction(0))
    return _power(largest) if largest else Fraction(1)


def _power(value: Fraction) -> Fraction:
    """A power of ten near a positive number."""
    digits = len(str(value.numerator)) - len(str(value.denominator))
    return Fraction(10) ** digits


def _tracked(row: Row) -> _Tracked:
    """A row as it was given, its largest weight 1."""
    largest = max(map(abs, row), default=Fraction(0)) or Fraction(1)
    return {j: (x / largest, abs(x / largest)) for j, x in enumerate(row) if x}


def _certainty(weight: tuple[Fraction, Fraction]) -> tuple[Fraction, Fraction]:
    """How little has cancelled in a weight; then how large it is."""
    value, size = weight
    return abs(value) / size, abs(value)


def _over(row: _Tracked, divisor: Fraction) -> _Tracked:
    return {j: (x / divisor, size / abs(divisor)) for j, (x, size) in row.items()}


def _less(row: _Tracked, lead: _Tracked, j: int) -> _Tracked:
    """A row less what it has in column j of another, whose weight there is 1."""
    share, more = row.get(j, _NOTHING)
    if not share:
        return row
    left = dict(row)
    for i, (y, least) in lead.items():
        x, size = row.get(i, _NOTHING)
        value, total = _kept(x - share * y), _kept(size + more * least)
        left[i] = (value if abs(value) > _ROUNDING * total else Fraction(0)), total
    return left


def _kept(weight: Fraction) -> Fraction:
    """A weight with a bounded number of digits."""
    if weight.denominator.bit_length() < _LONG or not weight:
        return weight
    unit = Fraction(2) ** (_KEPT + weight.denominator.bit_length() - weight.numerator.bit_length())
    return Fraction(round(weight * unit)) / unit
