"""Directions in which no sum of products changes: all of them, and no more work than allowed."""

from fractions import Fraction

import pytest
import sympy
from hypothesis import given, settings, strategies as st

from axisid import Parameter
from axisid.modeling.derivation.null_space import NullSpaceVector, null_space
from tests.bounded import within

SIZE = 4
Sum = dict[tuple[int, ...], Fraction]


def declared(size: int) -> list[Parameter]:
    return [Parameter(f"x{j}", "1", nominal=j + 1.0) for j in range(size)]


PARAMETERS = declared(SIZE)
SYMBOLS = [p.symbol for p in PARAMETERS]
MONOMIALS = st.tuples(*[st.integers(0, 2)] * SIZE).filter(any)
SUMS = st.lists(
    st.dictionaries(
        MONOMIALS,
        st.integers(-3, 3).filter(bool).map(Fraction),
        min_size=1,
        max_size=3,
    ),
    min_size=1,
    max_size=SIZE,
)


def written(total: Sum) -> sympy.Expr:
    return sympy.Add(
        *(
            sympy.Rational(w.numerator, w.denominator)
            * sympy.Mul(*(s**e for s, e in zip(SYMBOLS, powers, strict=True)))
            for powers, w in total.items()
        )
    )


def hidden(
    sums: list[Sum], parameters: list[Parameter], free: set[sympy.Symbol]
) -> tuple[NullSpaceVector, ...]:
    monomials = list(dict.fromkeys(powers for total in sums for powers in total))
    rows = [[total.get(powers, Fraction(0)) for powers in monomials] for total in sums]
    known = {p.symbol for p in parameters} - free
    return null_space(rows, monomials, parameters, known)


@pytest.mark.slow
@settings(max_examples=60)
@given(SUMS, st.sets(st.sampled_from(SYMBOLS), min_size=1))
def test_directions_are_those_of_the_jacobian(sums: list[Sum], free: set[sympy.Symbol]) -> None:
    ordered = [s for s in SYMBOLS if s in free]
    jacobian = sympy.Matrix([written(total) for total in sums]).jacobian(ordered)
    point = {s: sympy.Rational(7 * i + 3, 2 * i + 5) for i, s in enumerate(SYMBOLS)}
    found = hidden(sums, PARAMETERS, free)
    assert len(found) == len(free) - jacobian.subs(point).rank()
    vectors = [[direction.get(s, sympy.S.Zero) for s in ordered] for direction in found]
    for vector in vectors:
        assert (jacobian * sympy.Matrix(vector)).applyfunc(sympy.expand).is_zero_matrix
    if vectors:
        assert sympy.Matrix(vectors).subs(point).rank() == len(vectors)


@pytest.mark.slow
def test_too_much_for_symbols_is_told_in_numbers_at_once() -> None:
    size = 16
    one = tuple(int(j == 0) for j in range(size))
    sums = [
        {
            tuple((i * j + k) % 3 + one[j] for j in range(size)): Fraction(i + k + 1)
            for k in range(4)
        }
        for i in range(1, 13)
    ]
    parameters = declared(size)
    with within(1_500_000):
        found = hidden(sums, parameters, {p.symbol for p in parameters})
    assert len(found) >= size - len(sums)
    assert all(weight.is_number for direction in found for weight in direction.values())


def test_what_many_parameters_of_one_sum_hide_is_told_pair_by_pair() -> None:
    size = 60
    parameters = declared(size)
    ones = {tuple(int(i == j) for i in range(size)): Fraction(1) for j in range(size)}
    with within(150_000):
        found = hidden([ones], parameters, {p.symbol for p in parameters})
    assert [len(direction) for direction in found] == [2] * (size - 1)
