"""Expressions as text, and what they mean, worked out in many digits without the program."""

import ast
import operator
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import mpmath
import numpy as np

from tests.fuzz.cases import one_of

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


def spoilt(text: str, rng: np.random.Generator) -> str:
    """A text with letters lost, doubled or put in."""
    for _ in range(int(rng.integers(1, 4))):
        at, kind = int(rng.integers(len(text) + 1)), int(rng.integers(3))
        if kind == 0:
            text = text[:at] + text[at + 1 :]
        elif kind == 1:
            text = text[:at] + one_of(rng, _JUNK) + text[at:]
        else:
            text = text[:at] + text[at : at + int(rng.integers(1, 10))] * 3 + text[at:]
    return text


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
        if isinstance(node, (ast.BinOp, ast.Call, ast.Name, ast.Constant)) and not (
            isinstance(node, ast.Name) and node.id in _FUNCTIONS
        ):
            yield _value(node, numbers)


def smaller_texts(text: str) -> Iterator[str]:
    """Expressions with a part in place of the whole, or a name in place of a part."""
    try:
        tree = ast.parse(text, mode="eval").body
    except (SyntaxError, ValueError):
        return
    nodes = [n for n in ast.walk(tree) if isinstance(n, (ast.BinOp, ast.Call, ast.UnaryOp))]
    for node in nodes[1:]:
        yield ast.unparse(node)
    for node in nodes:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, (ast.BinOp, ast.Call, ast.UnaryOp, ast.Name)):
                yield ast.unparse(
                    _NodeReplacement(node, child).visit(ast.parse(text, mode="eval").body)
                )


class _NodeReplacement(ast.NodeTransformer):
    """A tree with one of its nodes replaced, found by its place in the text."""

    def __init__(self, node: ast.expr, by: ast.AST) -> None:
        self._at, self._by = _span(node), by

    def visit(self, node: ast.AST) -> Any:
        """Replace the node, or go on below it."""
        if isinstance(node, ast.expr) and _span(node) == self._at:
            return self._by
        return self.generic_visit(node)


def _span(node: ast.expr) -> tuple[Any, ...]:
    return type(node), node.lineno, node.col_offset, node.end_lineno, node.end_col_offset
