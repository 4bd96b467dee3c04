"""Text becomes an expression of declared names, or a refusal that says where; at once, always."""

import math
import warnings

import pytest
import sympy
from hypothesis import given, settings, strategies as st

from axisid import UsageError
from axisid.codegen.lowering.expressions import Lowering
from axisid.codegen.lowering.program import Builder
from axisid.modeling.parsing.expression import read_expression
from axisid.modeling.parsing.grammar import FUNCTIONS, TextError
from axisid.modeling.quantities.constants import Constant
from tests.bounded import within
from tests.refusals import refuses

SYMBOLS = {name: sympy.Symbol(name, real=True) for name in ("m", "b", "c", "x", "dx", "ddx")}
m, b, c, x, dx, ddx = SYMBOLS.values()


GIVEN = {"pi": math.pi, "G": 9.80665, "h": 1e300, "s": 10.0, "k": 2.0, "a": -1.0}
CONSTANTS = {name: Constant(value, "1", name).symbol for name, value in GIVEN.items()}
pi, G, h, s, k, a = CONSTANTS.values()


def read(text: str) -> sympy.Expr:
    return read_expression(text, SYMBOLS | CONSTANTS)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("m*ddx + b*dx + c*sign(dx)", m * ddx + b * dx + c * sympy.sign(dx)),
        ("m*dx**2/2", m * dx**2 / 2),
        ("1/2*m*dx**2", m * dx**2 / 2),
        ("-6/8*b", sympy.Rational(-3, 4) * b),
        ("1./2*b", b / 2),
        ("0.5*b", 0.5 * b),
        ("1/3*b", (1 / 3) * b),
        ("x**(1/2)", sympy.sqrt(x)),
        ("-c*abs(-x)", -c * sympy.Abs(x)),
        ("b*tanh(dx/1e-3)", b * sympy.tanh(dx / sympy.Float(1e-3))),
        ("b - c - x", b - c - x),
        ("b/c/x", b / c / x),
        ("b/c*x", b / c * x),
        ("-x**2", -(x**2)),
        ("2**-x", 2**-x),
        ("x**2**3", x**8),
        ("max(x, b)*atan2(x, dx)", sympy.Max(x, b) * sympy.atan2(x, dx)),
        ("  (x\n\t+ b)\r\n", x + b),
        (
            "+".join(f"b*sin({i}*x)" for i in range(60)),
            sum(b * sympy.sin(i * x) for i in range(60)),
        ),
        ("exp(2*x)", sympy.exp(2 * x)),
        ("sin(x)**20*cos(x)**20", sympy.sin(x) ** 20 * sympy.cos(x) ** 20),
        (
            "*".join(f"sin({i}*x)" for i in range(1, 9)),
            sympy.prod(sympy.sin(i * x) for i in range(1, 9)),
        ),
        (".5*x + 1.e-3", 0.5 * x + sympy.Float(1e-3)),
        ("1/((x + b + c)**15 + 1)", 1 / ((x + b + c) ** 15 + 1)),
        ("((x + 1)**20 + b)**20", ((x + 1) ** 20 + b) ** 20),
        ("m*G*sin(pi*x)", m * G * sympy.sin(pi * x)),
        ("sqrt(pi*G)*b", sympy.sqrt(pi * G) * b),
        ("2**(25*k)*x", 2 ** (25 * k) * x),
        ("(x + b)**k", (x + b) ** k),
        ("abs(a)*x/s**15", sympy.Abs(a) * x / s**15),
        ("max(k, pi)*atan2(k, s)", sympy.Max(k, pi) * sympy.atan2(k, s)),
    ],
)
def test_text_means_what_it_means_in_python(text: str, expected: sympy.Expr) -> None:
    assert read(text) == expected


@given(st.integers(-(10**9) + 1, 10**9 - 1), st.integers(1, 10**9 - 1))
def test_quotient_of_whole_numbers_is_the_one_of_floating_point(above: int, below: int) -> None:
    for divisor in (below, below & -below):
        value = read(f"{above}/{divisor}")
        assert float(value) == above / divisor
        assert value.is_Rational == (
            sympy.Rational(above, divisor) == sympy.Rational(above / divisor)
        )


@pytest.mark.parametrize(
    ("text", "where", "code", "says"),
    [
        ("__import__('os').system('true')", "column 12", "formula", ""),
        ("x.__class__", "column 1", "formula", ""),
        ("m*dxx", "column 3", "formula", "dxx.*Did you mean 'dx'"),
        ("m +\n  bb", "line 2, column 3", "formula", "bb"),
        ("(lambda: x)()", "column 8", "formula", "':'"),
        ("print(x)", "column 1", "formula", "sin, "),
        ("m(x + 1)", "column 1", "formula", r"m\*\(...\)"),
        ("sin*x", "column 1", "formula", "sin"),
        ("x if b else c", "column 1", "formula", ""),
        ("2x", "column 1", "formula", r"2\*x"),
        ("x^2", "column 2", "formula", r"\*\* for a power"),
        ("x b", "column 3", "formula", ""),
        ("x +", "column 4", "formula", ""),
        ("x + ((b)", "column 5", "formula", ""),
        ("x)", "column 2", "formula", ""),
        (" ", "column 1", "formula", ""),
        ("b + x/0", "column 7", "formula", ""),
        ("b + x/(c - c)", "column 8", "formula", ""),
        ("b + sqrt(-1)", "column 5", "formula", ""),
        ("sqrt(-x**2)", "column 1", "formula", ""),
        ("9**9**9**9", "column 4", "formula", ""),
        ("x**21", "column 4", "formula", "21 is above 20"),
        ("(x**20)**20", "column 10", "formula", "400 is above 20"),
        ("exp(999999999*log(9*x))", "column 1", "formula", ""),
        ("exp(x)**(999999999*log(9*b)/x)", "column 10", "formula", ""),
        ("sin(" * 7 + "x" + ")" * 7, "column 25", "formula", "6"),
        ("-" * 1500 + "x", "column 16", "formula", "15"),
        ("(" * 1000, "column 201", "formula", "too many nested"),
        ("x+" * 1200 + "x", "column 2001", "formula", "2401 characters"),
        ("sin(x, b)", "column 1", "formula", "2 arguments. Give 1"),
        ("sin(*x)", "column 5", "formula", ""),
        ("x\0", "column 2", "formula", ""),
        ("\u2212x", "column 1", "formula", ""),
        ("x + pi**pi**pi**pi", "column 5", "formula", ""),
        ("exp(exp(exp(pi)))", "column 1", "formula", ""),
        ("2**pi**20", "column 1", "formula", ""),
        ("cosh(pi**18)", "column 1", "formula", ""),
        ("x*exp(h)", "column 3", "formula", ""),
        ("2**h", "column 1", "formula", ""),
        ("s**s**s", "column 1", "formula", ""),
        ("exp(exp(exp(s)))", "column 5", "formula", ""),
        ("x + 1e60**k", "column 5", "formula", r"1e\+120"),
        ("h*x", "column 1", "formula", "1e[+]100"),
        ("x*h*h", "column 1", "formula", "1e[+]100"),
        ("exp(x + h)*exp(-x)", "column 1", "formula", "1e[+]100"),
        ("exp(exp(x + h)*exp(-x))", "column 1", "formula", "1e[+]100"),
        ("x**(3*s)", "column 5", "formula", r"3\*s"),
        ("exp(s*s*log(9*x))", "column 1", "formula", ""),
        ("sqrt(1 - pi)", "column 1", "formula", ""),
        ("asin(pi)", "column 1", "formula", ""),
        ("log(log(pi - 3))", "column 1", "formula", ""),
        ("b + sqrt(a)", "column 5", "formula", ""),
        ("log(a)", "column 1", "formula", ""),
        ("a**0.5", "column 1", "formula", ""),
        ("x/(k - 2)", "column 4", "formula", ""),
    ],
)
def test_what_cannot_be_read_is_refused_at_its_place(
    text: str, where: str, code: str, says: str
) -> None:
    with within(100_000):
        with refuses(code, says) as refusal:
            read(text)
        assert refusal.value.where == where


def test_pointer_stands_under_the_mistake_and_carries_no_control_characters() -> None:
    with pytest.raises(TextError) as refusal:
        read("b*dx\n + c*\x1b[31mv" + " " * 200)
    line, caret = refusal.value.pointer.split("\n")
    assert line.startswith(" + c*?[31mv")
    assert caret.index("^") == 5


def lowered(expression: sympy.Expr) -> None:
    builder = Builder()
    Lowering(builder, {s: builder.scalar(str(s)) for s in SYMBOLS.values()})(expression)


FRAGMENTS = [
    *SYMBOLS,
    *FUNCTIONS,
    *"+-*/(),.9 \n",
    "**",
    "1e3",
    "0",
    "2",
    "pi",
    "__class__",
]
NEARLY = st.lists(
    st.sampled_from([*FRAGMENTS, "lambda ", "if", "'", "[", ":", "\\", "{"]), max_size=25
)
LEAVES = st.sampled_from([*SYMBOLS, "2", "0.5", "0", "pi", "20", "99999999", "1e308", "1e-9"])
TREES = st.recursive(
    LEAVES,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from(["+", "-", "*", "/", "**"]), inner).map(
            lambda t: f"({t[0]}{t[1]}{t[2]})"
        ),
        st.tuples(st.sampled_from(sorted(FUNCTIONS)), inner, inner).map(
            lambda t: f"{t[0]}({', '.join(t[1 : 1 + FUNCTIONS[t[0]].arguments])})"
        ),
        inner.map(lambda e: f"-{e}"),
    ),
    max_leaves=12,
)
MUTATED = st.tuples(TREES, st.integers(0, 60), st.integers(0, 4), st.text(max_size=3)).map(
    lambda t: t[0][: t[1]] + t[3] + t[0][t[1] + t[2] :]
)


@pytest.mark.slow
@settings(max_examples=400)
@given(st.one_of(st.text(max_size=40), NEARLY.map("".join), TREES, MUTATED))
def test_any_text_is_an_expression_of_declared_names_that_lowers_or_is_refused(text: str) -> None:
    with within(100_000), warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            expression = read_expression(text, SYMBOLS)
        except TextError as error:
            assert isinstance(error, UsageError)
            assert error.reason.endswith((".", "?"))
            assert str(error)
        else:
            assert expression.free_symbols <= set(SYMBOLS.values())
            lowered(expression)
