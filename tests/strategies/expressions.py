"""Random SymPy expressions over given symbols: one strategy for every node that is lowered."""

from collections.abc import Callable

import sympy
from hypothesis import strategies as st

Expressions = st.SearchStrategy[sympy.Expr]

numbers: Expressions = st.one_of(
    st.integers(-5, 5).map(sympy.Integer),
    st.fractions(-3, 3, max_denominator=7).map(
        lambda f: sympy.Rational(f.numerator, f.denominator)
    ),
    st.floats(-10, 10, allow_nan=False).map(lambda x: sympy.Float(round(x, 6))),
    st.sampled_from([sympy.pi, sympy.E]),
)


def _positive(e: sympy.Expr) -> sympy.Expr:
    return 1 + e**2


def _bounded(e: sympy.Expr) -> sympy.Expr:
    return sympy.sin(e) / 2


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
    "atan2": lambda a, b: sympy.atan2(_positive(a), b),
    "Piecewise": lambda a, b: sympy.Piecewise((a, a < b), (b, True)),
    "and": lambda a, b: sympy.Piecewise((a, sympy.And(a <= b, b < 2)), (b + 1, True)),
    "ITE": lambda a, b: sympy.Piecewise((a, sympy.ITE(a < b, a > 0, b > 1)), (b, True)),
    "or": lambda a, b: sympy.Piecewise((a, sympy.Or(a >= b, ~(b > 1))), (b - 1, True)),
}


def expressions(symbols: tuple[sympy.Symbol, ...], leaves: int = 8) -> Expressions:
    """Expressions of bounded size that are real and finite for moderate values."""
    return st.recursive(
        st.one_of(st.sampled_from(symbols), numbers),
        lambda inner: st.one_of(
            st.tuples(st.sampled_from(sorted(UNARY)), inner).map(lambda t: UNARY[t[0]](t[1])),
            st.tuples(st.sampled_from(sorted(BINARY)), inner, inner).map(
                lambda t: BINARY[t[0]](t[1], t[2])
            ),
        ),
        max_leaves=leaves,
    )
