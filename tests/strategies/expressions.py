"""Random SymPy expressions over given symbols: one strategy for every node that is lowered."""

from collections.abc import Callable

import sympy
from hypothesis import strategies as st
from sympy.core.relational import Relational

Expressions = st.SearchStrategy[sympy.Expr]

#: Kind of a number of the lowering, and the numbers of that kind.
NUMBERS: dict[type[sympy.Expr], Expressions] = {
    sympy.Rational: st.one_of(
        st.integers(-5, 5).map(sympy.Integer),
        st.fractions(-3, 3, max_denominator=7).map(
            lambda f: sympy.Rational(f.numerator, f.denominator)
        ),
    ),
    sympy.Float: st.floats(-10, 10, allow_nan=False).map(lambda x: sympy.Float(round(x, 6))),
    sympy.NumberSymbol: st.sampled_from([sympy.pi, sympy.E]),
}
numbers: Expressions = st.one_of(*NUMBERS.values())


def _positive(e: sympy.Expr) -> sympy.Expr:
    return 1 + e**2


def _bounded(e: sympy.Expr) -> sympy.Expr:
    return sympy.sin(e) / 2


def _chosen(made: Callable[[sympy.Basic], sympy.Basic], a: sympy.Expr, b: sympy.Expr) -> sympy.Expr:
    """A choice by a condition made of ``a < b``, where that is one."""
    relation = a < b
    condition = made(relation) if isinstance(relation, Relational) else relation
    return sympy.Piecewise((a, condition), (b, True), evaluate=False)


#: Node class of the lowering, and how to make one from subexpressions.
UNARY: dict[str, Callable[[sympy.Expr], sympy.Expr]] = {
    "exp": lambda e: sympy.exp(_bounded(e)),
    "log": lambda e: sympy.log(_positive(e)),
    "sin": sympy.sin,
    "cos": sympy.cos,
    "tan": lambda e: sympy.tan(_bounded(e)),
    "asin": lambda e: sympy.asin(_bounded(e)),
    "acos": lambda e: sympy.acos(_bounded(e)),
    "atan": sympy.atan,
    "sinh": lambda e: sympy.sinh(_bounded(e)),
    "cosh": lambda e: sympy.cosh(_bounded(e)),
    "tanh": sympy.tanh,
    "Abs": sympy.Abs,
    "sign": sympy.sign,
    "Heaviside": sympy.Heaviside,
    "Pow": lambda e: _positive(e) ** sympy.Rational(3, 2),
    "sqrt": lambda e: sympy.sqrt(_positive(e)),
    "cube": lambda e: e**3,
    "inverse": lambda e: 1 / _positive(e),
}
BINARY: dict[str, Callable[[sympy.Expr, sympy.Expr], sympy.Expr]] = {
    "Add": lambda a, b: a + b,
    "Mul": lambda a, b: a * b,
    "difference": lambda a, b: a - b,
    "quotient": lambda a, b: a / _positive(b),
    "Min": sympy.Min,
    "Max": sympy.Max,
    "power": lambda a, b: sympy.Abs(a) ** (1 + _bounded(b)),
    "power of sum": lambda a, b: _positive(a) ** (sympy.cos(b) - 1),
    "atan2": lambda a, b: sympy.atan2(_positive(a), b),
    "atan2 ahead": lambda a, b: sympy.atan2(a, _positive(b)),
    "Piecewise": lambda a, b: sympy.Piecewise((a, a < b), (b, True)),
    "and": lambda a, b: sympy.Piecewise((a, sympy.And(a <= b, b < 2)), (b + 1, True)),
    "ITE": lambda a, b: sympy.Piecewise((a, sympy.ITE(a < b, a > 0, b > 1)), (b, True)),
    # Signs are equal often enough for both outcomes.
    "Eq": lambda a, b: sympy.Piecewise((a, sympy.Eq(sympy.sign(a), sympy.sign(b))), (b, True)),
    "Ne": lambda a, b: sympy.Piecewise((a, sympy.Ne(sympy.sign(a), sympy.sign(b))), (b, True)),
    # As SymPy leaves them where nothing evaluates them further.
    "Not": lambda a, b: _chosen(lambda c: sympy.Not(c, evaluate=False), a, b),
    "false": lambda a, b: _chosen(lambda c: sympy.ITE(c, sympy.false, a > 1, evaluate=False), a, b),
    "or": lambda a, b: sympy.Piecewise((a, sympy.Or(a >= b, ~(b > 1))), (b - 1, True)),
}


def operations(x: sympy.Expr, y: sympy.Expr) -> list[sympy.Expr]:
    """Every operation once."""
    return [*(make(x) for make in UNARY.values()), *(make(x, y) for make in BINARY.values())]


_TEN = 10.0
#: Values where floating point has its corners, and of any size.
SPECIAL = (0.0, -0.0, 1.0, -1.0, 0.3, -2.7, 1e-12, -1e-300, 5e-324, 1e8, -1e15)
FLOATS = st.one_of(
    st.sampled_from(SPECIAL),
    st.floats(-10, 10),
    st.builds(lambda x, e: x * _TEN**e, st.floats(-10, 10), st.integers(8, 14)),
    st.builds(lambda x, e: x * _TEN**e, st.floats(-10, 10), st.integers(-300, -5)),
)


def expressions(symbols: tuple[sympy.Symbol, ...], leaves: int = 8) -> Expressions:
    """Expressions of bounded size that are real and finite for moderate values."""
    made: Expressions = st.recursive(
        st.one_of(st.sampled_from(symbols), numbers),
        lambda inner: st.one_of(
            st.tuples(st.sampled_from(sorted(UNARY)), inner).map(lambda t: UNARY[t[0]](t[1])),
            st.tuples(st.sampled_from(sorted(BINARY)), inner, inner).map(
                lambda t: BINARY[t[0]](t[1], t[2])
            ),
        ),
        max_leaves=leaves,
    )
    return made.filter(_is_real)


def _is_real(made: sympy.Expr) -> bool:
    """Constants may fold to what is neither real nor finite."""
    return not made.has(sympy.I, sympy.nan, sympy.zoo, sympy.oo, -sympy.oo)
