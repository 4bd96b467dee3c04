"""What has kinks is rebuilt as it was, at once."""

import sympy
from sympy import Max, Min

from axisid.modeling.quantities.kinks import extreme, renamed, replaced
from tests.bounded import within

a, b, q, x = sympy.symbols("a b q x", real=True)


def test_numbers_are_compared_and_nothing_else() -> None:
    assert extreme(Max, (sympy.Integer(2), sympy.Integer(5))) == 5
    assert extreme(Max, (a, sympy.Integer(2), sympy.Float(0.5))) == Max(2, a)
    assert extreme(Min, (a, b)) == Min(a, b)


def test_replaced_is_what_sympy_makes_of_it() -> None:
    force = a * Max(0, q - b) ** 2 + sympy.exp(Min(q, a)) / (1 + sympy.Abs(q - a))
    new = {a: sympy.Integer(3), b: sympy.Float(0.5)}
    assert replaced(force, new) == force.xreplace(new)


def test_functions_of_other_symbols_stay_functions() -> None:
    stand_in = sympy.Symbol("0 a", positive=True)
    assert renamed(sympy.Abs(a) + Max(a, b), {a: stand_in}).has(sympy.Abs)


def nested(levels: int) -> sympy.Expr:
    inner = q
    for i in range(levels):
        limits = (-inner + x, sympy.Rational(i, 3))
        inner = Max(inner, *limits, evaluate=False) / 2 + a
    return inner


def test_a_deep_nest_takes_no_time() -> None:
    deep = nested(9)
    with within(100_000):
        assert replaced(deep, {a: sympy.Float(0.25)}).free_symbols == {q, x}
