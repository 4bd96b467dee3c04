"""Directions in which no polynomial changes: all of them, and no more work than allowed."""

from fractions import Fraction

import pytest
import sympy
from hypothesis import given, settings, strategies as st

from axisid.modeling.algebra.kernel import Polynomial, TooManyProductsError, kernel
from tests.bounded import within

SIZE = 4
SYMBOLS = sympy.symbols(f"x:{SIZE}", real=True)
Vector = dict[int, Polynomial]

MONOMIALS = st.tuples(*[st.integers(0, 2)] * SIZE).filter(any)
ROWS = st.lists(
    st.dictionaries(
        MONOMIALS,
        st.integers(-3, 3).filter(bool).map(Fraction),
        min_size=1,
        max_size=3,
    ),
    min_size=1,
    max_size=SIZE,
)


def written(polynomial: Polynomial) -> sympy.Expr:
    return sympy.Add(
        *(
            sympy.Rational(w.numerator, w.denominator)
            * sympy.Mul(*(s**e for s, e in zip(SYMBOLS, powers, strict=True)))
            for powers, w in polynomial.items()
        )
    )


@pytest.mark.slow
@settings(max_examples=60)
@given(ROWS, st.sets(st.integers(0, SIZE - 1), min_size=1))
def test_directions_are_those_of_the_jacobian(rows: list[Polynomial], columns: set[int]) -> None:
    free = sorted(columns)
    jacobian = sympy.Matrix([written(row) for row in rows]).jacobian([SYMBOLS[j] for j in free])
    point = {s: sympy.Rational(7 * i + 3, 2 * i + 5) for i, s in enumerate(SYMBOLS)}
    found = kernel(rows, SIZE, free)
    assert len(found) == len(free) - jacobian.subs(point).rank()
    vectors = [[written(vector.get(j, {})) for j in free] for vector in found]
    for vector in vectors:
        assert (jacobian * sympy.Matrix(vector)).applyfunc(sympy.expand).is_zero_matrix
    if vectors:
        assert sympy.Matrix(vectors).subs(point).rank() == len(vectors)


def test_powers_of_sums_take_no_time() -> None:
    """``c (a + b)**12`` has thirteen monomials, of which two directions are hidden."""
    a, b, c = SYMBOLS[:3]
    terms = sympy.Poly(sympy.expand(c * (a + b) ** 12), *SYMBOLS).terms()
    rows = [{tuple(powers): Fraction(int(w))} for powers, w in terms]
    with within(20_000):
        found = kernel(rows, SIZE, range(SIZE))
    assert len(found) == 2  # x3 alone, and a scale


@pytest.mark.slow
def test_too_much_work_is_refused_at_once() -> None:
    size = 16
    one = tuple(int(j == 0) for j in range(size))
    rows = [
        {
            tuple((i * j + k) % 3 + one[j] for j in range(size)): Fraction(i + k + 1)
            for k in range(4)
        }
        for i in range(1, 13)
    ]
    with within(1_500_000), pytest.raises(TooManyProductsError):
        kernel(rows, size, range(size))
