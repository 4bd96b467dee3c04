"""The null space of a matrix of polynomials, exactly and in bounded work.

Its rows are the derivatives of base parameters by the declared ones, times these: of a product of
powers that is the product itself times its exponents, so that most rows are whole numbers.
"""

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from operator import sub
from typing import TypeAlias

from axisid.support.errors import ModelError

#: Whole powers of the parameters.
Exponents: TypeAlias = tuple[int, ...]
#: Weights by powers; none is 0.
Polynomial: TypeAlias = dict[Exponents, Fraction]
Vector: TypeAlias = dict[int, Polynomial]  # by column; none is 0

_PRIME = 2**61 - 1
_ROOT = 1_000_003  # its powers are a point that has nothing to do with any axis
_MOST_PRODUCTS = 20_000


class TooManyProductsError(ModelError):
    """The null space has too many terms."""


def kernel(rows: Sequence[Polynomial], variables: int, columns: Sequence[int]) -> list[Vector]:
    """Directions in which no polynomial changes, where only some variables do.

    Parameters
    ----------
    rows : sequence of Polynomial
    variables : int
        How many there are.
    columns : sequence of int
        Those that change.

    Returns
    -------
    list of Vector
        Independent directions, by variable.

    Raises
    ------
    TooManyProductsError
        They have too many terms.
    """
    zero = (0,) * variables
    slopes = [slope for row in rows if (slope := _slopes(row, zero, columns))]
    echelon = _Echelon(columns)
    kept = [slope for slope in sorted(slopes, key=_complexity) if echelon.takes(slope)]
    whole = [{j: x[zero] for j, x in row.items()} for row in kept if _is_whole(row)]
    basis = _whole_kernel(whole, columns)
    curved = [_along(row, basis) for row in kept if not _is_whole(row)]
    found = []
    for mix in _mixtures(curved, {zero: Fraction(1)}, len(basis)):
        vector: Vector = {}
        for i, weight in mix.items():
            for j, share in basis[i].items():
                term = {_raised(powers, j): share * w for powers, w in weight.items()}
                vector[j] = _sum(vector.get(j, {}), term)
        found.append(_reduced({j: vector[j] for j in sorted(vector) if vector[j]}))
    return found


def _raised(powers: Exponents, j: int) -> Exponents:
    return (*powers[:j], powers[j] + 1, *powers[j + 1 :])


def _slopes(row: Polynomial, zero: Exponents, columns: Iterable[int]) -> Vector:
    """Derivatives by the variables, times these; over the product of powers if there is but one."""
    single = len(row) == 1
    slopes = {j: {zero if single else e: w * e[j] for e, w in row.items() if e[j]} for j in columns}
    return {j: slope for j, slope in slopes.items() if slope}


def _is_whole(row: Vector) -> bool:
    return all(not any(powers) for slope in row.values() for powers in slope)


class _Echelon:
    """Rows at a point of the field of whole numbers modulo a prime, of which none follows."""

    def __init__(self, columns: Iterable[int]) -> None:
        self._columns = tuple(columns)
        self._rows: dict[int, dict[int, int]] = {}

    def takes(self, row: Vector) -> bool:
        """Add a row unless it follows from those before; whether it was added."""
        left = {j: _residue(polynomial) for j, polynomial in row.items()}
        for pivot, lead in self._rows.items():
            share = left.get(pivot, 0)
            for j, x in lead.items() if share else ():
                left[j] = (left.get(j, 0) - share * x) % _PRIME
        found = next((j for j in self._columns if left.get(j)), None)
        if found is None:
            return False
        scale = pow(left[found], -1, _PRIME)
        self._rows[found] = {j: x * scale % _PRIME for j, x in left.items() if x}
        return True


def _complexity(row: Vector) -> tuple[int, int]:
    terms = [powers for slope in row.values() for powers in slope]
    return len(set(terms)), max(map(sum, terms))


def _residue(polynomial: Polynomial) -> int:
    """A polynomial at a point of the field of whole numbers modulo a prime."""
    total = 0
    for powers, weight in polynomial.items():
        value = weight.numerator * pow(weight.denominator, -1, _PRIME)
        for j, power in enumerate(powers):
            value = value * pow(_ROOT, (j + 1) * power, _PRIME) % _PRIME
        total += value
    return total % _PRIME


def _whole_kernel(
    rows: Iterable[Mapping[int, Fraction]], columns: Sequence[int]
) -> list[dict[int, Fraction]]:
    """A basis of what rows of numbers map to nothing, of reduced row echelon form."""
    done: dict[int, dict[int, Fraction]] = {}
    for row in rows:
        left = dict(row)
        for pivot, lead in done.items():
            left = _minus(left, lead, left.get(pivot, Fraction(0)))
        pivot = next(j for j in columns if left.get(j))
        lead = {j: x / left[pivot] for j, x in left.items()}
        done = {p: _minus(r, lead, r.get(pivot, Fraction(0))) for p, r in done.items()}
        done[pivot] = lead
    return [
        {j: Fraction(1), **{pivot: -lead[j] for pivot, lead in done.items() if j in lead}}
        for j in columns
        if j not in done
    ]


def _minus(
    row: Mapping[int, Fraction], lead: Mapping[int, Fraction], share: Fraction
) -> dict[int, Fraction]:
    left = dict(row)
    for j, x in lead.items():
        left[j] = left.get(j, Fraction(0)) - share * x
    return {j: x for j, x in left.items() if x}


def _along(row: Vector, basis: Sequence[Mapping[int, Fraction]]) -> Vector:
    """A row's products with the vectors of a basis."""
    made: Vector = {}
    for i, vector in enumerate(basis):
        total: Polynomial = {}
        for j, share in vector.items():
            total = _sum(total, {e: share * w for e, w in row.get(j, {}).items()})
        if total:
            made[i] = total
    return made


class _Budget:
    """Multiplies polynomials, and counts."""

    def __init__(self) -> None:
        self._left = _MOST_PRODUCTS

    def times(self, one: Polynomial, other: Polynomial) -> Polynomial:
        self._left -= len(one) * len(other)
        if self._left < 0:
            raise TooManyProductsError("what no motion tells apart has too many terms.")
        made: Polynomial = {}
        for a, x in one.items():
            term = {tuple(map(sum, zip(a, b, strict=True))): x * y for b, y in other.items()}
            made = _sum(made, term)
        return made

    def minor(self, rows: Sequence[Vector], columns: Sequence[int], one: Polynomial) -> Polynomial:
        """Determinant of as many columns as there are rows."""
        if not rows:
            return one
        total: Polynomial = {}
        for place, j in enumerate(columns):
            if j in rows[0]:
                rest = self.minor(rows[1:], [*columns[:place], *columns[place + 1 :]], one)
                term = self.times(rows[0][j], rest)
                total = _sum(total, {e: (-w if place % 2 else w) for e, w in term.items()})
        return total


def _mixtures(rows: Sequence[Vector], one: Polynomial, size: int) -> list[Vector]:
    """The null space of a few rows of polynomials, by minors: one vector for each free column."""
    pivots = _pivots(rows, size)
    budget = _Budget()
    found = []
    for free in (j for j in range(size) if j not in pivots):
        vector = {free: budget.minor(rows, pivots, one)}
        for place, pivot in enumerate(pivots):
            columns = [*pivots[:place], free, *pivots[place + 1 :]]
            weight = budget.minor(rows, columns, one)
            vector[pivot] = {powers: -w for powers, w in weight.items()}
        found.append({j: weight for j, weight in vector.items() if weight})
    return found


def _pivots(rows: Sequence[Vector], size: int) -> list[int]:
    """The first columns that are independent almost everywhere."""
    turned = [{i: row[j] for i, row in enumerate(rows) if j in row} for j in range(size)]
    echelon = _Echelon(range(len(rows)))
    return [j for j, column in enumerate(turned) if column and echelon.takes(column)]


def _sum(one: Polynomial, other: Polynomial) -> Polynomial:
    total = dict(one)
    for powers, weight in other.items():
        total[powers] = total.get(powers, Fraction(0)) + weight
    return {powers: weight for powers, weight in total.items() if weight}


def _reduced(vector: Vector) -> Vector:
    """A vector over the powers and the number that all its terms share."""
    terms = [(powers, w) for polynomial in vector.values() for powers, w in polynomial.items()]
    shared = tuple(map(min, zip(*(powers for powers, _ in terms), strict=True)))
    size = abs(terms[0][1])
    return {
        j: {tuple(map(sub, powers, shared)): w / size for powers, w in polynomial.items()}
        for j, polynomial in vector.items()
    }
