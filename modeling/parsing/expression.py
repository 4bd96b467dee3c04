"""Read expressions that a user writes as text, without running them.

Text passes a whitelist of characters, Python's parser, and a whitelist of syntax, node by node;
every name must be declared. Length, nesting, powers and the size after expansion are bounded, so
that reading is fast for every text. Every error names the position in the text.
"""

import ast
import math
import operator
import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from types import MappingProxyType
from typing import Any

import sympy

from axisid.modeling.quantities import CANNOT, MOST_NODES, joined_exponential, with_numbers
from axisid.support.errors import ModelError

from .grammar import (
    DEEPEST,
    FUNCTIONS,
    LARGEST,
    NODES,
    ConstantValues,
    Elements,
    TextError,
    nearest,
    nested,
    not_allowed,
    small,
)

_LARGEST_POWER = 20  # absolute value
_LONGEST = 2000  # characters
_DEEPEST_CALLS = 6
_EXACT = 10**9  # below this size, whole numbers stay exact
_SMALLEST, _LARGEST_FLOAT = math.ulp(0.0), sys.float_info.max
_SHOWN = 60  # characters of a name or piece

_OPERATORS: dict[type[ast.AST], Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}
_CHAINED = ((ast.Add, ast.Sub), (ast.Mult, ast.Div))
_NOT_FINITE = (sympy.nan, sympy.zoo, sympy.oo, -sympy.oo, sympy.I)


@dataclass(slots=True)
class ExpressionReader:
    """Converter of a Python syntax tree to a SymPy expression, node by node.

    Attributes
    ----------
    text : str
        The whole text, for messages.
    start : int
        Offset in the text of the first character that Python's parser has seen.
    symbols, elements : mapping
        Symbols, and elements of friction or load, that the text may use, by name.
    """

    text: str
    start: int
    symbols: Mapping[str, sympy.Symbol]
    elements: Elements
    _constants: ConstantValues = field(init=False, default_factory=ConstantValues)

    def read(self, tree: ast.expr) -> sympy.Expr:
        """Return the expression of a whole text.

        Raises
        ------
        TextError
            The text is not a permitted expression, or the expression is too large to be
            differentiated.
        """
        result = self._evaluated(tree, DEEPEST, _DEEPEST_CALLS)
        self._check_size(result)
        return result

    def _evaluated(self, node: ast.expr, depth: int, calls: int) -> sympy.Expr:
        """Return the expression of a node.

        Parameters
        ----------
        node : ast.expr
        depth, calls : int
            Numbers of further levels of nesting, and of nested function calls, that are permitted.
        """
        if not depth:
            raise nested(*self._at(node))
        if isinstance(node, ast.Call) and not calls:
            raise TextError(
                f"functions are nested more than {_DEEPEST_CALLS} deep. Simplify the expression.",
                *self._at(node),
            )
        match node:
            case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
                whole = isinstance(value, int) and abs(value) < _EXACT
                return sympy.Integer(value) if whole else self._folded(node, float, value)
            case ast.Name(id=name):
                return self._symbol(node, name)
            case ast.UnaryOp(op=op, operand=operand) if type(op) in _OPERATORS:
                return _OPERATORS[type(op)](self._evaluated(operand, depth - 1, calls))
            case ast.BinOp(op=op) if type(op) in _OPERATORS:
                return self._chain(node, depth, calls)
            # An element of friction or load, unless a declared symbol has its name.
            case ast.Call(func=ast.Name(id=name)) if (
                name in self.elements and name not in self.symbols
            ):
                return self._element(node, name, depth, calls)
            case ast.Call(func=ast.Name(id=name), args=arguments):
                return self._call(node, name, arguments, depth, calls)
            case _:
                raise not_allowed(_shortened(ast.unparse(node)), *self._at(node))

    def _check_size(self, result: sympy.Expr) -> None:
        """Refuse an expression that is too large, may not be real, or has too large numbers.

        In the exponent of a joined exponential (see `joined_exponential`) a number may be of any
        size.
        """
        in_exponents: set[sympy.Expr] = set()
        for count, node in enumerate(sympy.preorder_traversal(result)):
            if count > MOST_NODES:
                raise TextError(
                    "the expression is too large. Simplify the expression.", self.text, 0
                )
            if node.is_Mul and joined_exponential(node) is not None:
                in_exponents.add(node.args[0])
            fits_float = not node.is_Number or node == 0 or _SMALLEST <= abs(node) <= _LARGEST_FLOAT
            if node not in in_exponents and not fits_float:
                raise TextError(
                    "a number in the expression is too large or too small for a float. Change the "
                    "number.",
                    self.text,
                    0,
                )
            is_leaf = node.is_Symbol or node.is_Number or node.is_NumberSymbol
            if not is_leaf and node.func not in NODES:
                raise TextError(
                    f"the expression may not be real: it contains {type(node).__name__}. Write a "
                    "real expression.",
                    self.text,
                    0,
                )
            if not self._constants.fits(node):
                raise TextError(
                    "with the values of the constants, a part of the expression has no value, or "
                    f"a value above {LARGEST:g}. Change the constants or the expression.",
                    self.text,
                    0,
                )

    def _symbol(self, node: ast.AST, name: str) -> sympy.Expr:
        """Return the symbol that a name stands for; the number for ``pi``."""
        if name in self.symbols:
            return self.symbols[name]
        if name == "pi":
            return sympy.Float(math.pi)
        if name in FUNCTIONS:
            raise TextError(
                f"{name} is a function. Write {name}(...).",
                *self._at(node),
            )
        raise TextError(
            f"the name {_shortened(name)} is not known. Known names are "
            f"{', '.join(self.symbols)}.{nearest(name, self.symbols)}",
            *self._at(node),
        )

    def _chain(self, node: ast.BinOp, depth: int, calls: int) -> sympy.Expr:
        """Return a sum, a product or a power; a sum or product of any length is one level deep.

        Python parses ``a + b + c`` as ``(a + b) + c``. The chain of such operations is collected
        from the last operation to the first, and then evaluated from the first to the last.
        """
        kinds = next((kinds for kinds in _CHAINED if isinstance(node.op, kinds)), ())
        links: list[ast.BinOp] = [node]
        inner = node.left
        while isinstance(inner, ast.BinOp) and isinstance(inner.op, kinds):
            links.append(inner)
            inner = inner.left
        value = self._evaluated(inner, depth - 1, calls)
        for link in reversed(links):
            value = self._combined(link, value, self._evaluated(link.right, depth - 1, calls))
        return value

    def _combined(self, node: ast.BinOp, left: sympy.Expr, right: sympy.Expr) -> sympy.Expr:
        """Return the result of an operation on two expressions; a number for two numbers.

        Raises
        ------
        TextError
            The result is a power, a quotient or a combination of constants without a permitted
            value.
        """
        operation = _OPERATORS[type(node.op)]
        if left.is_Number and right.is_Number:
            return self._folded(node, operation, left, right)
        if isinstance(node.op, ast.Pow):
            self._check_exponent(node, left, right)
            for factor in sympy.Mul.make_args(left):
                if isinstance(factor, sympy.exp):
                    self._check_logarithm(node.right, right * factor.args[0])
        if isinstance(node.op, ast.Div) and 0 in (right, self._constants.value(right)):
            raise TextError(
                "the divisor is zero. Write a divisor other than zero.", *self._at(node.right)
            )
        self._check_constants(node, operation, left, right)
        result = self._real(node, operation, left, right)
        if isinstance(node.op, ast.Pow):  # powers of powers multiply
            for factor in sympy.Mul.make_args(result):
                self._check_exponent(node, *factor.as_base_exp())
        return result

    def _call(
        self, node: ast.Call, name: str, arguments: list[ast.expr], depth: int, calls: int
    ) -> sympy.Expr:
        """Return a function of expressions, such as ``sin(q)``; its value if all are numbers."""
        if name not in FUNCTIONS:
            known = [*FUNCTIONS, *self.elements]
            if name in self.symbols:
                raise TextError(
                    f"{name} is not a function. Write {name}*(...) for a product.",
                    *self._at(node),
                )
            raise TextError(
                f"the function {_shortened(name)} is not known. Known functions are "
                f"{', '.join(known)}.{nearest(name, known)}",
                *self._at(node),
            )
        function = FUNCTIONS[name]
        if len(arguments) != function.arguments or node.keywords:
            raise TextError(
                f"{name}(...) has {len(arguments) + len(node.keywords)} arguments. Give "
                f"{function.arguments}, without names.",
                *self._at(node),
            )
        inner = [self._evaluated(argument, depth - 1, calls - 1) for argument in arguments]
        if all(value.is_Number for value in inner):
            return self._folded(node, function.number, *inner)
        self._check_constants(node, function.number, *inner)
        if function.symbolic is sympy.exp:
            self._check_logarithm(node, inner[0])
        return self._real(node, function.symbolic, *inner)

    def _element(self, node: ast.Call, name: str, depth: int, calls: int) -> sympy.Expr:
        """Return the force of an element of friction or load, such as ``stribeck(...)``."""
        arguments = [self._evaluated(each, depth - 1, calls - 1) for each in node.args]
        if any(each.arg is None for each in node.keywords):
            raise not_allowed("**", *self._at(node))
        named = {
            str(each.arg): self._evaluated(each.value, depth - 1, calls - 1)
            for each in node.keywords
        }
        try:
            force = self._real(node, partial(self.elements[name], **named), *arguments)
        except ModelError as error:
            raise TextError(str(error), *self._at(node), code=error.code) from error
        for power in sorted(force.atoms(sympy.Pow), key=str):
            self._check_exponent(node, *power.as_base_exp())
        return force

    def _check_logarithm(self, node: ast.AST, exponent: sympy.Expr) -> None:
        """Refuse a large factor of a log in an exponent: SymPy turns exp(n log(x)) into x**n."""
        numbers = with_numbers(exponent).atoms(sympy.Number)
        if exponent.has(sympy.log) and any(abs(float(n)) > _LARGEST_POWER for n in numbers):
            raise TextError(
                f"a number above {_LARGEST_POWER} multiplies a log in an exponent. Write a power "
                "with **.",
                *self._at(node),
            )

    def _check_exponent(self, node: ast.expr, base: sympy.Expr, power: sympy.Expr) -> None:
        """Refuse an exponent above 20 in size, unless base and exponent are constants.

        A power of constants is one number, which is checked as a number.
        """
        value = self._constants.value(power)
        is_constant = not power.is_Number and self._constants.value(base) is not None
        if value is not None and not is_constant and not abs(value) <= _LARGEST_POWER:
            place = node.right if isinstance(node, ast.BinOp) else node
            raise TextError(
                f"the power {power} is above {_LARGEST_POWER}. Use a power from {-_LARGEST_POWER} "
                f"to {_LARGEST_POWER}.",
                *self._at(place),
            )

    def _check_constants(
        self, node: ast.AST, operation: Callable[..., Any], *parts: sympy.Expr
    ) -> None:
        """Refuse an operation on numbers and constants whose value is above 1e100 in size."""
        values = [self._constants.value(part) for part in parts]
        if not all(value is not None for value in values):
            return
        value = self._number(node, operation, *values)
        if not small(value):
            raise TextError(
                f"the result is {value:.3g} with the values of the constants. Keep its size below "
                f"{LARGEST:g}.",
                *self._at(node),
            )

    def _folded(self, node: ast.AST, operation: Callable[..., Any], *numbers: Any) -> sympy.Expr:
        """Return the result of an operation on numbers, computed in floating point.

        Exact arithmetic could take very long. A quotient of whole numbers that is exact in floating
        point stays a fraction, such as ``1/2`` as the factor of an energy or as an exponent.
        """
        value = self._number(node, operation, *map(float, numbers))
        if value == int(value) and abs(value) < _EXACT:
            return sympy.Integer(int(value))
        if operation is operator.truediv and all(n.is_Integer for n in numbers):
            exact_value = sympy.Rational(*numbers)
            if exact_value == sympy.Rational(value):
                return exact_value
        return sympy.Float(value)

    def _number(self, node: ast.AST, operation: Callable[..., Any], *numbers: Any) -> float:
        """Return the result of an operation on floats; a result not finite and real is refused."""
        value = self._result(node, operation, *numbers)
        if isinstance(value, complex) or not math.isfinite(value):
            raise TextError(
                f"the result is {value}. Write an expression with a finite real value.",
                *self._at(node),
            )
        return float(value)

    def _real(self, node: ast.AST, make: Callable[..., Any], *parts: Any) -> sympy.Expr:
        """Return the result of an operation on expressions; refuse an infinite or imaginary one."""
        result = self._result(node, make, *parts)
        if any(part in _NOT_FINITE for part in (result, *result.args)):
            raise TextError(
                "the result is not finite and real. Write an expression with a finite real value.",
                *self._at(node),
            )
        return result

    def _result(self, node: ast.AST, make: Callable[..., Any], *parts: Any) -> Any:
        """Return the result of an operation; an error of the operation becomes a `TextError`."""
        try:
            return make(*parts)
        except CANNOT as error:
            # The last argument is the message; an overflow has an error number before it.
            reason = "".join(map(str, error.args[-1:])).rstrip(".")
            raise TextError(f"the result has no value: {reason}.", *self._at(node)) from error

    def _at(self, node: ast.AST) -> tuple[str, int]:
        """Return the text, and the offset in it at which a node begins."""
        return self.text, self.start + getattr(node, "col_offset", 0)


def _shortened(text: str) -> str:
    """Return a text, cut after 60 characters."""
    return text if len(text) < _SHOWN else f"{text[:_SHOWN]}..."


# A number followed directly by a name, such as ``2x``, and a character that no expression contains.
_RUN_ON = re.compile(r"(?<![\w.])((?:\d++\.?+\d*+|\.\d++)(?:[eE][+-]?\d++)?+)([\w.])", re.ASCII)
_FOREIGN = re.compile(r"[^\w\s.+\-*/(),=]", re.ASCII)


def read_expression(
    text: str,
    symbols: Mapping[str, sympy.Symbol],
    elements: Elements = MappingProxyType({}),
) -> sympy.Expr:
    """Return the expression that a text contains.

    Parameters
    ----------
    text : str
    symbols : mapping of str to sympy.Symbol
        Symbols that the text may name, in addition to ``pi``.
    elements : mapping of str to callable, optional
        Elements of friction and load that the text may call; none by default.

    Raises
    ------
    TextError
        The text is not a permitted expression, or the expression is too large.
    """
    # Refuse texts that are long, empty, or contain foreign characters or run-on numbers.
    if len(text) > _LONGEST:
        raise TextError(
            f"the expression has {len(text)} characters. Write {_LONGEST} or fewer.",
            text,
            _LONGEST,
        )
    if not text.strip():
        raise TextError("the expression is empty. Write an expression.", text, 0)
    if foreign := _FOREIGN.search(text):
        hint = ", and ** for a power" if foreign[0] == "^" else ""
        raise not_allowed(foreign[0], text, foreign.start(), hint)
    if run_on := _RUN_ON.search(text):
        raise TextError(
            f"{run_on[0]!r} cannot be used, because an operator is missing after the number. Write "
            f"the operator, as in {run_on[1]}*{run_on[2]}.",
            text,
            run_on.start(),
        )
    # Parse the text as one line, then convert the syntax tree.
    flat = re.sub(r"\s", " ", text)
    start = len(flat) - len(flat.lstrip())
    try:
        tree = ast.parse(flat.strip(), mode="eval").body
    except SyntaxError as error:
        raise TextError(
            f"an operator, a number or a name is missing or superfluous here ({error.msg}). "
            "Correct the expression at this position.",
            text,
            start + (error.offset or len(flat.strip()) + 1) - 1,
        ) from error
    except (RecursionError, MemoryError, ValueError) as error:
        raise nested(text, 0) from error
    return ExpressionReader(text, start, symbols, elements).read(tree)
