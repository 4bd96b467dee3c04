"""Functions are the same only with evidence from all of their parts; a doubt keeps them."""

from fractions import Fraction

import pytest
import sympy
from hypothesis import given, settings, strategies as st
from sympy import (
    Abs,
    Heaviside,
    Max,
    Min,
    Rational,
    acos,
    asin,
    atan2,
    cos,
    exp,
    sign,
    sin,
    sqrt,
    tanh,
)

from axisid.modeling.quantities import reduced_functions, vanishes
from axisid.modeling.quantities.symbols import DIRECTION as D
from tests.bounded import within

q, dq = sympy.symbols("q dq", real=True)
HALF = Rational(1, 2)


def independent(*functions: sympy.Expr, velocity: sympy.Symbol = dq) -> int:
    return len(reduced_functions(list(map(sympy.sympify, functions)), velocity).rows)


APART = {
    "a knee at 0.1 mm/s": (tanh(dq / 1e-4), 1),
    "a knee at 1 um/s beside the direction": (tanh(dq / 1e-6), D),
    "a knee that is exact": (tanh(dq * 10**6), D),
    "a knee at 20 m": (tanh((q - 20) / 0.1), 1),
    "a knee at 20 km": (tanh((q - 20_000) / 0.1), 1),
    "steps at two places": (Heaviside(q - 0.37), Heaviside(q - 0.38)),
    "steps 1 um apart": (Heaviside(q - 0.37), Heaviside(q - 0.370001)),
    "a root of a wave": (sqrt(1 - cos(q) ** 2), sin(q)),
    "a root of a square": (sqrt(q**2 + 4 * q + 4), q, 1),
    "an angle of a wave": (acos(cos(q)), q),
    "knots of a stage with 0.4 mm": (Max(0, q), Max(0, q - 1e-4), Max(0, q - 4e-4), q, 1),
    "a ramp into dry friction": (Min(1, Abs(dq) / 1e-4) * D, D),
    "a narrow window": (Max(0, 1 - Abs(q - 0.37) / 1e-4), 1),
    "a narrow bump": (Max(0, 1 - ((q - 737) / 1e-5) ** 2), 1),
    "a narrow bell": (exp(-(((q - 0.37) / 1e-5) ** 2)), 1),
    "a window of the velocity in one of the position": (
        Max(0, 1 - Abs(q - 3) / 1e-3) * tanh(dq / 1e-5),
        Max(0, 1 - Abs(q - 3) / 1e-3) * D,
    ),
    "more digits than seventy": (1, 1 + q / 10**60),
    "a kink of two symbols": (Abs(q - 1000 * dq), q - 1000 * dq),
}


@pytest.mark.parametrize("name", APART)
def test_functions_that_agree_at_a_few_points_stay_apart(name: str) -> None:
    found = reduced_functions(list(map(sympy.sympify, APART[name])), dq)
    assert (len(found.rows), found.doubts) == (len(APART[name]), [])


@pytest.mark.parametrize("smooth", range(5, 9))
def test_two_one_sided_springs_beside_smooth_functions_stay(smooth: int) -> None:
    beside = [sympy.S.One, q, q**2, q**3, sin(q), cos(q), exp(q), tanh(q)][:smooth]
    springs = [Max(0, q - 0.313), Max(0, -q - 0.272)]
    assert independent(*beside, *springs) == smooth + 2


MERGED = {
    "a spring of two halves": ((Max(0, q - 0.3), Max(0, 0.3 - q), q - 0.3), 2),
    "a modulus and its halves": ((Abs(q - 0.37), Max(0, q - 0.37), q - 0.37), 2),
    "squares of waves": ((sin(q) ** 2, cos(q) ** 2, 1), 2),
    "one window, scaled": ((Max(0, 1 - Abs(q - 1) / 1e-4), Max(0, 1e-4 - Abs(q - 1))), 1),
    "one knee twice": ((tanh(dq / 1e-4), 2 * tanh(dq / 1e-4), D), 2),
    "angles of scaled arguments": ((atan2(sin(q), cos(q)), atan2(2 * sin(q), 2 * cos(q))), 1),
    "products of decimals": ((9.80665 * q, (9.80665 * 0.123456789) * q / 0.123456789), 1),
    "directions": (((1 + D) / 2, (1 - D) / 2, 1, D), 2),
    "a choice between three": ((Max(q, 1, 2 * q), Max(2 * q, 1), 3 * Max(1, q, 2 * q)), 1),
}


@pytest.mark.parametrize("name", MERGED)
def test_functions_that_are_sums_of_others_are_found(name: str) -> None:
    functions, rank = MERGED[name]
    assert independent(*functions) == rank


def test_what_no_point_shows_leaves_a_doubt_and_merges_nothing() -> None:
    flat = tanh(exp(q) + 1000)
    found = reduced_functions([flat, sympy.S.One], dq)
    assert (len(found.rows), found.doubts) == (2, [(0, 1)])
    assert not vanishes(flat - 1)


def test_an_angle_whose_turns_are_far_away_leaves_a_doubt() -> None:
    found = reduced_functions([asin(sin(q / 10**5)), q], dq)
    assert (len(found.rows), found.doubts) == (2, [(0, 1)])


def test_multiples_of_a_function_are_one_function_with_its_shares() -> None:
    found = reduced_functions([sympy.S.Zero, 2 * q, q**2, -3 * q, HALF * q**2], dq)
    assert found.rows == [[0, 1, 0, Fraction(-3, 2), 0], [0, 0, 1, 0, Fraction(1, 2)]]
    assert (found.pivots, found.doubts) == ([1, 2], [])


def test_a_whole_number_with_decimals_excuses_no_weights() -> None:
    found = reduced_functions([1.0 * sin(q), cos(q), sin(q + HALF)], dq)
    assert (len(found.rows), len(found.doubts)) == (3, 1)


def test_the_same_unknown_function_is_merged_by_algebra() -> None:
    flat = tanh(exp(q) + 1000)
    found = reduced_functions([flat, q * flat, 3 * flat], dq)
    assert (len(found.rows), found.doubts) == (2, [])
    assert vanishes(flat * (q + 1) - flat - q * flat)


def test_weights_that_are_no_fractions_need_a_declared_number() -> None:
    found = reduced_functions([sin(q), cos(q), sin(q + HALF)], dq)
    assert (len(found.rows), len(found.doubts)) == (3, 1)
    assert independent(sin(q), cos(q), sin(q + 0.5)) == 2


KNOWN = [
    tanh(dq / 1e-4),
    tanh((q - 20) / 0.1),
    sympy.S.One,
    q,
    Abs(q - HALF),
    Max(0, q - HALF),
    Max(0, HALF - q),
    Max(0, 1 - 1000 * Abs(q - HALF)),
    q * sign(q - 3),
    Min(1, 1000 * Abs(dq)) * D,
    D,
]
NAMES = st.text("abcxyzqrpt", min_size=1, max_size=4)


@pytest.mark.slow
@settings(max_examples=25)
@given(
    st.lists(st.sampled_from(KNOWN), min_size=2, max_size=5, unique=True),
    st.lists(NAMES, min_size=2, max_size=2, unique=True),
    st.data(),
)
def test_neither_names_nor_the_order_change_which_functions_are_independent(
    chosen: list[sympy.Expr], names: list[str], data: st.DataObject
) -> None:
    x, v = (sympy.Symbol(name, real=True) for name in names)
    other = [f.xreplace({q: x, dq: v}) for f in data.draw(st.permutations(chosen))]
    assert independent(*other, velocity=v) == independent(*chosen)


def test_a_choice_of_five_within_a_choice_of_five_takes_bounded_work() -> None:
    lines = [
        Min(*((i + 1) * q + Rational(j, 3) - i * j for j in range(5)), evaluate=False)
        for i in range(5)
    ]
    grown = Max(*lines, evaluate=False)
    with within(900_000):
        assert independent(grown, 2 * grown + q, q) == 2
