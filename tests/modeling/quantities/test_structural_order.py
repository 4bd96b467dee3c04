"""Symbols are numbered by where they stand, not by their names."""

import sympy
from hypothesis import given, settings, strategies as st

from axisid.modeling.quantities.structural_order import structural_order

a, b, c, d = sympy.symbols("a b c d", real=True)
FORCE = sympy.Add(a * b**2, sympy.tanh(c / d), sympy.sin(a) * c, sympy.Max(0, b - 3) * d)


@settings(max_examples=30)
@given(st.lists(st.text("klmnxyz", min_size=1, max_size=5), min_size=4, max_size=4, unique=True))
def test_the_number_of_a_symbol_stays_with_it_under_another_name(names: list[str]) -> None:
    renamed = {
        s: sympy.Symbol(name, real=True) for s, name in zip((a, b, c, d), names, strict=True)
    }
    order = structural_order([FORCE, a * c])
    again = structural_order([(a * c).xreplace(renamed), FORCE.xreplace(renamed)])
    assert {renamed[s]: place for s, place in order.items()} == again


def test_what_has_a_meaning_of_its_own_is_told_from_its_like() -> None:
    assert len(set(structural_order([a + b], (a,)).values())) == 2
    assert structural_order([a + b], (a,))[a] == structural_order([a + c], (a,))[a]
