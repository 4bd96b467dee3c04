"""The force as functions of the motion times monomials of the parameters, and what is independent.

``force = sum of f_i(motion) A_ij mu_j(parameters)``, with exact weights A. Its reduced row echelon
form R is the smallest set of combinations ``R mu`` that the force depends on.
"""

from collections.abc import Iterable, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from fractions import Fraction

import sympy
from sympy.simplify.fu import TR8

from .cases import Cases
from .independence import exact
from .symbols import DIRECTION

#: Share of what was added up below which a weight is what rounding left of nothing.
_ROUNDING = Fraction(1, 10**12)
_DIGITS = 30  # of an irrational weight
_EXTREME = 100  # decimal exponent

Exponents = tuple[int, ...]
Row = list[Fraction]


@dataclass(frozen=True, slots=True, kw_only=True)
class Terms:
    """The force over the functions of the motion that occur in it.

    Attributes
    ----------
    monomials : tuple of tuple of int
        Distinct, with exponents by parameter; the parameters themselves first, in their order.
    weights : tuple of list of Fraction
        One row for each function of the motion, scaled at will, one column for each monomial.
    bent : frozenset of sympy.Symbol
        Parameters that enter other than by whole powers; they count as motion, and each has a row
        and a column of its own.
    """

    monomials: tuple[Exponents, ...]
    weights: tuple[Row, ...]
    bent: frozenset[sympy.Symbol]


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
    """
    unknown = set(parameters)
    parts = [_canonical(part, velocity, unknown) for part in sympy.Add.make_args(force)]
    terms = [term for part in parts for term in sympy.Add.make_args(part)]
    bent = {
        s
        for term in terms
        for factor in sympy.Mul.make_args(term)
        if not _is_whole_power(factor, unknown)
        for s in factor.free_symbols & unknown
    }
    table: dict[sympy.Expr, dict[Exponents, list[sympy.Expr]]] = {}
    for term in terms:
        weight, rest = term.as_independent(*term.free_symbols, as_Add=False)
        powers = rest.as_powers_dict()
        exponents = tuple(0 if p in bent else int(powers.get(p, 0)) for p in parameters)
        motion = rest / sympy.Mul(*(p**e for p, e in zip(parameters, exponents, strict=True)))
        if any(exponents) and weight != 0:
            row = table.setdefault(_without_abs(motion, velocity), {})
            row.setdefault(exponents, []).append(weight)
    for j, p in enumerate(parameters):
        if p in bent:
            table[p] = {tuple(int(i == j) for i in range(len(parameters))): [sympy.S.One]}
    totals = [{e: _total(weights) for e, weights in row.items()} for row in table.values()]
    monomials = tuple(
        sorted({e for row in totals for e, total in row.items() if total}, key=_order)
    )
    rows = tuple(_fractions(row, monomials) for row in totals)
    return Terms(monomials=monomials, weights=rows, bent=frozenset(bent))


def reduced_rows(weights: Sequence[Row]) -> tuple[list[Row], list[int]]:
    """Reduced row echelon form without its zero rows, and its pivot columns.

    Exact, but that what rounding alone leaves where weights cancel counts as zero: a product of
    decimals computed in floating point is not the product of these decimals. A weight that is small
    beside others of its row is none of that: ``(x - 9)**12`` has weights from 1 to 3e11.
    """
    columns = range(len(weights[0]) if weights else 0)
    sizes = [_size(row[j] for row in weights) for j in columns]
    rows = [_Tracked.of([x / size for x, size in zip(row, sizes, strict=True)]) for row in weights]
    done: list[_Tracked] = []
    pivots: list[int] = []
    for j in columns:
        best = max(rows, key=lambda row: row.certainty(j), default=None)
        if best is None or not best.values[j]:
            continue
        lead = best.over(best.values[j])
        rows = [row.less(lead, j) for row in rows if row is not best]
        done = [*(row.less(lead, j) for row in done), lead]
        pivots.append(j)
    scaled = [
        [x * size / sizes[pivot] for x, size in zip(row.values, sizes, strict=True)]
        for row, pivot in zip(done, pivots, strict=True)
    ]
    return scaled, pivots


@dataclass(frozen=True, slots=True)
class _Tracked:
    """A row, and for each of its weights the size of what was added up to it."""

    values: Row
    sizes: Row

    @classmethod
    def of(cls, row: Row) -> "_Tracked":
        """A row as it was given, its largest weight 1."""
        largest = max(map(abs, row), default=Fraction(0)) or Fraction(1)
        return cls([x / largest for x in row], [abs(x / largest) for x in row])

    def certainty(self, j: int) -> tuple[Fraction, Fraction]:
        """How little has cancelled in a weight; then how large it is."""
        value = abs(self.values[j])
        return (value / self.sizes[j] if value else Fraction(0)), value

    def over(self, divisor: Fraction) -> "_Tracked":
        """The row divided by a number."""
        return _Tracked(
            [x / divisor for x in self.values], [size / abs(divisor) for size in self.sizes]
        )

    def less(self, lead: "_Tracked", j: int) -> "_Tracked":
        """The row less what it has in column j of another, whose weight there is 1."""
        share, more = self.values[j], self.sizes[j]
        if not share:
            return self
        left = [x - share * y for x, y in zip(self.values, lead.values, strict=True)]
        sizes = [size + more * y for size, y in zip(self.sizes, lead.sizes, strict=True)]
        kept = [
            x if abs(x) > _ROUNDING * size else Fraction(0)
            for x, size in zip(left, sizes, strict=True)
        ]
        return _Tracked(kept, sizes)


def _canonical(
    force: sympy.Expr, velocity: sympy.Symbol, parameters: AbstractSet[sympy.Symbol]
) -> sympy.Expr:
    """Products of sines and cosines as sums, which are independent; decimals as fractions."""
    cases = Cases(exact(force), velocity, parameters)
    terms = sympy.Add.make_args(sympy.expand(cases.split))
    waves = [_in_phase(TR8(term)) if term.has(sympy.sin, sympy.cos) else term for term in terms]
    return cases.joined(sympy.expand(sympy.Add(*waves)))


def _in_phase(term: sympy.Expr) -> sympy.Expr:
    """Sines and cosines with a phase that is a number, by those without one."""
    replaced = {}
    for wave in term.atoms(sympy.sin, sympy.cos):
        phase, angle = wave.args[0].as_coeff_Add()
        if phase != 0:
            sine, cosine = sympy.sin(angle), sympy.cos(angle)
            replaced[wave] = (
                sine * sympy.cos(phase) + cosine * sympy.sin(phase)
                if isinstance(wave, sympy.sin)
                else cosine * sympy.cos(phase) - sine * sympy.sin(phase)
            )
    return term.xreplace(replaced)


def _is_whole_power(factor: sympy.Expr, unknown: set[sympy.Symbol]) -> bool:
    base, exponent = factor.as_base_exp()
    return base in unknown and exponent.is_Integer and exponent > 0


def _without_abs(motion: sympy.Expr, velocity: sympy.Symbol) -> sympy.Expr:
    """``|dq|`` as a factor is ``direction dq``, the same function in other words.

    Where ``|dq|`` has a power that is not whole, ``dq`` is ``direction |dq|``.
    """
    size = sympy.Abs(velocity)
    powers = motion.as_powers_dict()
    of_size, of_velocity, of_direction = (
        powers.get(base, sympy.S.Zero) for base in (size, velocity, DIRECTION)
    )
    if not of_size:
        return motion
    base, turns = (velocity, of_size) if of_size.is_Integer else (size, of_velocity)
    rest = motion / (size**of_size * velocity**of_velocity * DIRECTION**of_direction)
    return rest * base ** (of_size + of_velocity) * DIRECTION ** ((of_direction + turns) % 2)


def _order(exponents: Exponents) -> tuple[int, tuple[int, ...]]:
    return sum(exponents), tuple(-e for e in exponents)


def _total(weights: Sequence[sympy.Expr]) -> sympy.Expr:
    """Sum of weights; 0 where only rounding is left of it."""
    total = sympy.Add(*weights)
    if len(weights) == 1 or total == 0:
        return total
    size = sum((abs(sympy.N(weight, _DIGITS)) for weight in weights), sympy.S.Zero)
    return (
        total
        if abs(sympy.N(total, _DIGITS))
        > sympy.Rational(_ROUNDING.numerator, _ROUNDING.denominator) * size
        else sympy.S.Zero
    )


def _fractions(row: dict[Exponents, sympy.Expr], monomials: Sequence[Exponents]) -> Row:
    scale = _power_of_ten(next((w for w in row.values() if w != 0), sympy.S.One))
    return [_fraction(row.get(e, sympy.S.Zero) * scale) for e in monomials]


def _power_of_ten(weight: sympy.Expr) -> sympy.Expr:
    """What brings an extreme weight near 1; 1 for any other.

    Scaling a row does not change the null space, and a number such as exp(-1e4), which expanding a
    Gaussian gives, would be a fraction of thousands of digits.
    """
    size = sympy.Abs(sympy.N(weight))
    exponent = int(sympy.floor(sympy.log(size, 10))) if size else 0
    if abs(exponent) <= _EXTREME:
        return sympy.S.One
    return sympy.Float(10, 2 * _DIGITS) ** -exponent  # as a whole number it could fill the memory


def _fraction(weight: sympy.Expr) -> Fraction:
    exact = weight if weight.is_Rational else sympy.Rational(str(sympy.N(weight, _DIGITS)))
    return Fraction(int(exact.p), int(exact.q))


def _size(column: Iterable[Fraction]) -> Fraction:
    largest = max(map(abs, column), default=Fraction(0))
    return _power(largest) if largest else Fraction(1)


def _power(value: Fraction) -> Fraction:
    """A power of ten near a positive number."""
    digits = len(str(value.numerator)) - len(str(value.denominator))
    return Fraction(10) ** digits
