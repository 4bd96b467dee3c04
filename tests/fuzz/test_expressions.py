"""Expressions as text mean what they say, in many digits, or are refused in words."""

import ast
import operator
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest

from axisid import build, load_axis
from axisid.modeling.parsing.expression import read_expression
from axisid.modeling.quantities.symbols import Coordinate
from tests.fuzz.cases import Fuzz, WrongError, one_of, spoilt

DIGITS = 40
_FUNCTIONS: dict[str, tuple[int, Callable[..., Any]]] = {
    "sin": (1, mpmath.sin),
    "cos": (1, mpmath.cos),
    "tan": (1, mpmath.tan),
    "asin": (1, mpmath.asin),
    "acos": (1, mpmath.acos),
    "atan": (1, mpmath.atan),
    "atan2": (2, mpmath.atan2),
    "sinh": (1, mpmath.sinh),
    "cosh": (1, mpmath.cosh),
    "tanh": (1, mpmath.tanh),
    "exp": (1, mpmath.exp),
    "log": (1, mpmath.log),
    "sqrt": (1, mpmath.sqrt),
    "abs": (1, abs),
    "sign": (1, mpmath.sign),
    "min": (2, min),
    "max": (2, max),
}
_OPERATORS: dict[type, Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}
_NUMBERS = ("2", "3", "0.5", "1", "10", "0.1", "1e-3", "100", "7", "1/2", "1/3", "1.5", "1e4", "pi")
_JUNK = (
    "^",
    "%",
    "=",
    "==",
    "[",
    "]",
    "{",
    ":",
    ";",
    ".",
    ",",
    "!",
    "@",
    "_",
    "\\",
    "é",
    "²",
    "0x",
    "j",
)


def random_text(rng: np.random.Generator, names: Sequence[str], depth: int = 4) -> str:
    """Draw the text of an expression of some names."""
    kind = rng.random()
    if depth == 0 or kind < 0.2:
        name = one_of(rng, tuple(names))
        kinds = (name, name, name, f"({name} - {one_of(rng, _NUMBERS)})", one_of(rng, _NUMBERS))
        return one_of(rng, kinds)
    if kind < 0.45:
        function = one_of(rng, tuple(_FUNCTIONS))
        count = _FUNCTIONS[function][0]
        return f"{function}({', '.join(random_text(rng, names, depth - 1) for _ in range(count))})"
    left = random_text(rng, names, depth - 1)
    if kind < 0.55:
        power = one_of(rng, ("2", "3", "4", "0.5", "(1/2)", "-1", "-2", "1.5", "12", "(1/3)"))
        return f"({left})**{power}"
    sign = one_of(rng, (" + ", " - ", "*", "*", "/"))
    right = random_text(rng, names, depth - 1)
    return f"({left}){sign}({right})" if rng.random() < 0.5 else f"{left}{sign}{right}"


def renamed(text: str, names: Mapping[str, str]) -> str:
    """A text with other words in the place of its names."""
    return re.sub(r"[A-Za-z_]\w*", lambda word: names.get(word[0], word[0]), text)


#: rad, beyond which three points in the last place need not show how far rounding turns an angle.
_MOST_TURNED = 1e12


class NoValueError(ValueError):
    """An expression has no real finite value at a point, or one that rounding decides."""


def exact_value(text: str, values: Mapping[str, float]) -> tuple[float, float]:
    """What a text means at a point, in `DIGITS` digits, and the rounding that floats may have.

    The rounding is what the text worked out in floats, as it stands, is off; and what the value
    moves by where every input moves by a unit in its last place.

    Raises
    ------
    NoValueError
        There is no real finite value, or none that floats can hold.
    """
    tree = ast.parse(text, mode="eval").body
    with mpmath.workdps(DIGITS):
        right = _value(tree, {n: mpmath.mpf(v) for n, v in values.items()})
        moved = [
            _value(
                tree, {n: mpmath.mpf(v) * (1 + s * mpmath.mpf(2) ** -52) for n, v in values.items()}
            )
            for s in (-1, 1)
        ]
        largest = max(abs(part) for part in _parts(tree, values))
        turned = [abs(angle) for angle in _angles(tree, values)]
    with mpmath.workdps(16):
        plain = _value(tree, {n: mpmath.mpf(v) for n, v in values.items()})
    rounding = max(abs(other - right) for other in (*moved, plain))
    if not (abs(right) < 1e100 and largest < 1e150):
        raise NoValueError("too large for floats")
    if any(angle > _MOST_TURNED for angle in turned):
        raise NoValueError("rounding turns an angle by more than a little")
    return float(right), float(rounding)


def _value(node: ast.expr, values: Mapping[str, Any]) -> Any:
    match node:
        case ast.Constant(value=int() | float() as value):
            found = mpmath.mpf(value)
        case ast.Name(id="pi"):
            found = mpmath.mpf(float(mpmath.pi))
        case ast.Name(id=name):
            found = values[name]
        case ast.UnaryOp(op=op, operand=operand):
            found = _OPERATORS[type(op)](_value(operand, values))
        case ast.BinOp(op=op, left=left, right=right):
            found = _tried(_OPERATORS[type(op)], _value(left, values), _value(right, values))
        case ast.Call(func=ast.Name(id=name), args=arguments):
            found = _tried(_FUNCTIONS[name][1], *(_value(a, values) for a in arguments))
        case _:
            raise NoValueError("it is no expression")
    if isinstance(found, mpmath.mpc) or not mpmath.isfinite(found):
        raise NoValueError("it is not real, or not finite")
    return found


def _tried(operation: Callable[..., Any], *arguments: Any) -> Any:
    try:
        return operation(*arguments)
    except (ArithmeticError, ValueError, OverflowError) as error:
        raise NoValueError(str(error)) from error


def _angles(tree: ast.expr, values: Mapping[str, float]) -> Iterator[Any]:
    """Arguments of what is periodic in them."""
    numbers = {n: mpmath.mpf(v) for n, v in values.items()}
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("sin", "cos", "tan"):
            yield _value(node.args[0], numbers)


def _parts(tree: ast.expr, values: Mapping[str, float]) -> Iterator[Any]:
    """Values of all parts of an expression."""
    numbers = {n: mpmath.mpf(v) for n, v in values.items()}
    for node in ast.walk(tree):
        is_function = isinstance(node, ast.Name) and node.id in _FUNCTIONS
        if isinstance(node, (ast.BinOp, ast.Call, ast.Name, ast.Constant)) and not is_function:
            yield _value(node, numbers)


NAMES = ("x", "v")
_RELATIVE, _OF_LARGEST, _ROUNDINGS = 1e-9, 1e-12, 100.0
_RATIOS = {"x": "(q/a)", "v": "(dq/w)"}
_SPREADS = (1.0, 3.0, 0.1, 1e-3)

# Lengths and speeds over 1 have no unit, so that no expression of them is refused for its units.
_AXIS = """
name = "written"
coordinate = {{ name = "q", unit = "rad" }}
drive = {{ gain = 1.0 }}
[parameters]
J = {{ unit = "kg m^2", nominal = 1.0 }}
b = {{ unit = "N m" }}
[constants]
a = {{ value = 1.0, unit = "rad" }}
w = {{ value = 1.0, unit = "rad/s" }}
[newton]
inertia = "J"
resistance = ["b*({})"]
"""


def _points(text: str) -> Iterator[tuple[float, float]]:
    """Where an expression is looked at: anywhere, and near its own numbers, where parts cancel."""
    rng = np.random.default_rng(len(text))
    for spread in _SPREADS:
        yield tuple(spread * rng.normal(size=2))
    near = [float(number) for number in re.findall(r"\b\d[\d.]*(?:e-?\d+)?", text)]
    for number in near[:4]:
        beside = number + 10 ** rng.uniform(-7, -0.5) * rng.normal()
        yield from ((beside, rng.normal()), (rng.normal(), beside), (beside, beside))


def _check(text: str, file: Path) -> None:
    """Hold the force of an axis against what its expression says."""
    file.write_text(_AXIS.format(renamed(text, _RATIOS)), encoding="utf-8")
    built = build(load_axis(file), native=False)
    force = built.functions["inverse_dynamics"]
    for x, v in _points(text):
        try:
            right, rounding = exact_value(text, {"x": x, "v": v})
        except NoValueError:
            continue
        got = float(force(x, v, 0.0, float(np.sign(v)), [1.0, 1.0]))
        allowed = _ROUNDINGS * rounding + _RELATIVE * abs(right) + _OF_LARGEST
        if not abs(got - right) <= allowed:
            raise WrongError(f"value: {got!r} for {right!r} at x = {x!r}, v = {v!r}")


@pytest.mark.slow
def test_forces_are_those_of_the_text(tmp_path: Path) -> None:
    Fuzz(
        name="expressions",
        count=40,
        draw=lambda rng: random_text(rng, NAMES),
        check=lambda text: _check(text, tmp_path / "axis.toml"),
        shown=str,
    ).run()


@pytest.mark.slow
def test_spoilt_text_is_read_or_refused_at_once() -> None:
    q = Coordinate("x", unit="m")
    symbols = {"x": q.symbol, "v": q.velocity}
    Fuzz(
        name="spoilt expressions",
        count=1000,
        draw=lambda rng: spoilt(random_text(rng, NAMES), rng, _JUNK),
        check=lambda text: read_expression(text, symbols) and None,
        shown=repr,
    ).run()


@pytest.mark.parametrize(
    ("text", "value"), [("x**2 - v", 2.25 - 0.5), ("max(x, v)*sign(-v)", -1.5), ("1/2*x", 0.75)]
)
def test_the_yardstick_knows_what_a_text_means(text: str, value: float) -> None:
    found, rounding = exact_value(text, {"x": 1.5, "v": 0.5})
    assert found == value
    assert rounding <= 1e-15
    with pytest.raises(NoValueError):
        exact_value("sqrt(-x)", {"x": 1.5})
    assert mpmath.mp.dps == 15
