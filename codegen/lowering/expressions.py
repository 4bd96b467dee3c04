"""Convert SymPy expressions to operations of a program (*lowering*), with a method per node class.

A node that cannot be converted is refused by name. Expressions that are lowered by the same object
share their common subexpressions.

SymPy has one zero, floating-point numbers have +0 and -0. All targets give a zero the same sign,
with three exceptions: ``sign``, the smaller or larger of two zeros, and values selected by a
condition, which CasADi's virtual machine computes as a sum. Only ``atan2`` at its branch cut could
show the difference.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import reduce

import sympy
from sympy.functions.elementary.miscellaneous import Max, Min
from sympy.functions.elementary.piecewise import ExprCondPair
from sympy.logic.boolalg import BooleanAtom

from axisid.modeling.quantities import TIME, joined_exponential, with_numbers
from axisid.support.errors import ModelError

from .program import Builder, Program

_APPLIED: dict[type[sympy.Basic], str] = {
    sympy.exp: "exp",
    sympy.log: "log",
    sympy.sin: "sin",
    sympy.cos: "cos",
    sympy.tan: "tan",
    sympy.asin: "asin",
    sympy.acos: "acos",
    sympy.atan: "atan",
    sympy.sinh: "sinh",
    sympy.cosh: "cosh",
    sympy.tanh: "tanh",
    sympy.Abs: "abs",
    sympy.sign: "sign",
    sympy.Not: "not",
    sympy.atan2: "atan2",
    sympy.ITE: "select",
}
_FOLDED: dict[type[sympy.Basic], str] = {
    Min: "min",
    Max: "max",
    sympy.And: "and",
    sympy.Or: "or",
}
_RELATIONS: dict[type[sympy.Basic], tuple[str, bool]] = {
    sympy.StrictLessThan: ("lt", False),
    sympy.LessThan: ("le", False),
    sympy.StrictGreaterThan: ("lt", True),
    sympy.GreaterThan: ("le", True),
    sympy.Equality: ("eq", False),
}
# Classes that are lowered by a method `map_CLASS`.
_MAPPED = frozenset(
    {
        sympy.Symbol,
        sympy.Rational,
        sympy.Add,
        sympy.Mul,
        sympy.Pow,
        sympy.Piecewise,
        sympy.Heaviside,
        sympy.Unequality,
        BooleanAtom,
    }
)
_LARGEST_REPEATED_POWER = 4


class Lowering:
    """Converts SymPy expressions to operations of a builder.

    Parameters
    ----------
    builder : Builder
        Receives the operations.
    values : mapping of sympy.Symbol to int
        Value of each free symbol, as an index into the builder.
    """

    def __init__(self, builder: Builder, values: Mapping[sympy.Symbol, int]) -> None:
        self._builder = builder
        self._values = values
        self._memo: dict[sympy.Basic, int] = {}

    def __call__(self, expression: sympy.Basic) -> int:
        """Return the index of the operation that computes an expression.

        Raises
        ------
        ModelError
            A node has no counterpart, or a symbol has no value.
        """
        if expression not in self._memo:
            self._memo[expression] = self._lower(expression)
        return self._memo[expression]

    def _lower(self, node: sympy.Basic) -> int:
        """Return the operation of a node, by the table entry or method of its class or a base."""
        if isinstance(node, sympy.Float | sympy.NumberSymbol):
            return self._builder.constant(float(node))
        for kind in type(node).__mro__:
            if kind in _APPLIED:
                return self._builder.apply(_APPLIED[kind], *map(self, node.args))
            if kind in _FOLDED:
                ordered = sorted(node.args, key=sympy.default_sort_key)
                return self._chain(_FOLDED[kind], [self(argument) for argument in ordered])
            if kind in _RELATIONS:
                return self._relation(*_RELATIONS[kind], node)
            if kind in _MAPPED:
                return int(getattr(self, f"map_{kind.__name__}")(node))
        raise ModelError(
            f"no code can be generated for {type(node).__name__} in the expression {node}. Use "
            "sums, products, powers, elementary functions, Min, Max or Piecewise.",
            code="generated-code",
        )

    def map_Symbol(self, node: sympy.Symbol) -> int:
        """Return the operation that gives the value of a symbol."""
        if node not in self._values:
            known = ", ".join(sorted(map(str, self._values)))
            raise ModelError(
                f"the symbol {node} has no value here. Use only the symbols {known}.",
                code="generated-code",
            )
        return self._values[node]

    def map_Rational(self, node: sympy.Rational) -> int:
        """Return the operation of a constant; refuse a number that is too large for a float."""
        try:
            return self._builder.constant(int(node.p) / int(node.q))
        except OverflowError as error:
            raise ModelError(
                f"the number {node} is too large for a float. Give a smaller number.",
                code="generated-code",
            ) from error

    def map_Add(self, node: sympy.Add) -> int:
        """Return the operation of a sum: positive terms are added, then negative subtracted."""
        positive, negative = [], []
        for term in sorted(node.args, key=sympy.default_sort_key):
            if term.could_extract_minus_sign():
                negative.append(self(-term))
            else:
                positive.append(self(term))
        if not positive:
            return self._builder.apply("neg", self._chain("add", negative))
        return reduce(
            lambda left, right: self._builder.apply("sub", left, right),
            negative,
            self._chain("add", positive),
        )

    def map_Mul(self, node: sympy.Mul) -> int:
        """Return the operation of a product: numerator divided by denominator, each multiplied out.

        A very large or very small factor of an exponential is added to its exponent instead.
        """
        if node.could_extract_minus_sign():
            return self._builder.apply("neg", self(-node))
        joined = joined_exponential(node)
        if joined is not None:
            rest, exponent = joined
            power = self._builder.apply("exp", self(exponent))
            return power if rest == 1 else self._builder.apply("mul", self(rest), power)
        number = node.args[0]
        if number.is_Float and number != 0 and float(number) == 0:
            raise ModelError(
                f"the number {number} in {node} is too small for a float. Give a larger number."
            )
        numerator, denominator = [], []
        for factor in sorted(_joined_powers(node), key=sympy.default_sort_key):
            if factor.is_Rational and factor.q != 1:
                numerator += [self(sympy.Integer(factor.p))] if factor.p != 1 else []
                denominator.append(self(sympy.Integer(factor.q)))
            elif factor.is_Pow and factor.exp.could_extract_minus_sign():
                denominator.append(self(1 / factor))
            else:
                numerator.append(self(factor))
        above = self._chain("mul", numerator) if numerator else self._builder.constant(1)
        if not denominator:
            return above
        return self._divide(above, self._chain("mul", denominator), node)

    def map_Pow(self, node: sympy.Pow) -> int:
        """Return the operation of a power: a square root, products or a quotient if possible."""
        base, exponent = node.base, node.exp
        if exponent == sympy.Rational(1, 2):
            return self._builder.apply("sqrt", self(base))
        if exponent.could_extract_minus_sign():
            return self._divide(self._builder.constant(1), self(base**-exponent), node)
        if exponent.is_Integer and 1 < exponent <= _LARGEST_REPEATED_POWER:
            return self._chain("mul", [self(base)] * int(exponent))
        if exponent.is_Rational and exponent.q == 2 and 1 < exponent <= _LARGEST_REPEATED_POWER:
            root = self._builder.apply("sqrt", self(base))  # much faster than a power
            return self._chain("mul", [self(base)] * int(exponent) + [root])
        return self._builder.apply("pow", self(base), self(exponent))

    def map_BooleanAtom(self, node: sympy.Basic) -> int:
        return self._builder.constant(node == sympy.true)

    def map_Piecewise(self, node: sympy.Piecewise) -> int:
        """Return nested selections; the first condition that is true selects the value."""
        *pairs, last = node.args
        if not isinstance(last, ExprCondPair) or last.cond != sympy.true:
            raise ModelError(
                f"{node} is not defined everywhere. End it with (value, True).",
                code="generated-code",
            )
        result = self(last.expr)
        for value, condition in reversed(pairs):
            result = self._builder.apply("select", self(condition), self(value), result)
        return result

    def map_Heaviside(self, node: sympy.Heaviside) -> int:
        """Return the operation of a unit step; its value at 0 is the node's second argument."""
        argument, middle = self(node.args[0]), self(node.args[1])
        zero, one = self._builder.constant(0), self._builder.constant(1)
        above = self._builder.apply("lt", zero, argument)
        below = self._builder.apply("lt", argument, zero)
        otherwise = self._builder.apply("select", below, zero, middle)
        return self._builder.apply("select", above, one, otherwise)

    def map_Unequality(self, node: sympy.Unequality) -> int:
        return self._builder.apply("not", self._relation("eq", False, node))

    def _divide(self, above: int, below: int, node: sympy.Basic) -> int:
        """Return the operation of a quotient; refuse a divisor that is the constant 0."""
        divisor = self._builder.operations[below]
        if divisor.name == "constant" and divisor.value == 0:
            raise ModelError(
                f"{node} divides by a constant that is zero. Check the gains and other constants.",
                code="generated-code",
            )
        return self._builder.apply("div", above, below)

    def _relation(self, operation: str, swapped: bool, node: sympy.Basic) -> int:
        """Return the operation of a comparison, with exchanged operands if `swapped`."""
        left, right = self(node.args[0]), self(node.args[1])
        return self._builder.apply(operation, *((right, left) if swapped else (left, right)))

    def _chain(self, operation: str, operands: list[int]) -> int:
        """Return a binary operation applied to several operands from left to right."""
        return reduce(lambda a, b: self._builder.apply(operation, a, b), operands)


@dataclass(slots=True)
class Arguments(Builder):
    """A builder whose arguments are declared by SymPy symbols.

    Attributes
    ----------
    values : dict of sympy.Symbol to int
        Index of the operation of each declared symbol.
    """

    values: dict[sympy.Symbol, int] = field(default_factory=dict)

    def scalars(self, *symbols: sympy.Symbol) -> "Arguments":
        """Declare scalar arguments, and return this builder."""
        for symbol in symbols:
            self.values[symbol] = self.scalar(symbol.name)
        return self

    def vector_of(self, name: str, symbols: Sequence[sympy.Symbol]) -> "Arguments":
        """Declare a vector argument whose elements are symbols, and return this builder."""
        indices = self.vector(name, [symbol.name for symbol in symbols])
        self.values.update(zip(symbols, indices, strict=True))
        return self

    def vector_if_any(self, name: str, symbols: Sequence[sympy.Symbol]) -> "Arguments":
        """Declare a vector argument if it has elements, and return this builder."""
        return self.vector_of(name, symbols) if symbols else self

    def lower(self, **outputs: Sequence[Sequence[sympy.Expr]]) -> "Arguments":
        """Declare results by name, each as rows of expressions, and return this builder."""
        lowering = Lowering(self, self.values)
        for name, rows in outputs.items():
            self.output(name, [[lowering(e) for e in row] for row in rows])
        return self


def over_time(values: Mapping[str, sympy.Expr]) -> Program:
    """Return the program of signals as functions of the time, s: the recorded signals of a twin."""
    rows = {name: [[with_numbers(value)]] for name, value in values.items()}
    return Arguments().scalars(TIME).lower(**rows).program("over_time", "Signals over time.")


def _joined_powers(product: sympy.Mul) -> Sequence[sympy.Expr]:
    """Return the factors of a product, with powers of the same base joined.

    Otherwise the derivative ``p x**p / x`` of ``x**p`` would be 0/0 at x = 0.
    """
    numbers = [factor for factor in product.args if not factor.free_symbols]
    symbolic = [factor for factor in product.args if factor.free_symbols]
    # Numbers stay separate: SymPy writes their joined powers as products again, ``2*sqrt(2)``.
    exponents: dict[sympy.Expr, sympy.Expr] = {}
    for factor in symbolic:
        base, exponent = factor.as_base_exp()
        exponents[base] = exponents.get(base, sympy.S.Zero) + exponent
    if len(exponents) == len(symbolic):
        return tuple(product.args)
    return [*numbers, *(base**exponent for base, exponent in exponents.items())]
