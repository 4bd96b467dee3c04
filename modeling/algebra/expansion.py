"""Expressions multiplied out, exactly and in bounded work.

Two expressions that are the same function for reasons of algebra have the same sum of products. It
is only ever compared, never computed with. SymPy's own `expand` takes any time, as its rules ask
what is positive, real or whole of all that is nested.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

import sympy
from sympy.core.relational import Relational
from sympy.functions.elementary.miscellaneous import Max, Min
from sympy.logic.boolalg import Boolean

from axisid.modeling.quantities import DIRECTION, ConstantSymbol

from .constant_value import NotRealError, has_value, number_symbol, value_of
from .exponential import joined_exponential
from .products import (
    HALF,
    Algebra,
    Factor,
    Number,
    Sum,
    add,
    constant,
    frozen,
    normal,
    number_in,
    scaled,
)

_ODD = (sympy.tan, sympy.asin, sympy.atan, sympy.sinh, sympy.tanh)
_EVEN = (sympy.cosh,)

#: The base of the natural exponential, as a factor of weights that may be beyond floating point.
EULER = Factor("exp", ("e", ()), frozenset())
_FEW_CASES, _FEW_RELATIONS = 3, 3  # of a choice that is multiplied out
_LARGEST_POWER = 700  # of e that is a number for floating point


class Expansion:
    """Multiplies expressions out, over factors that they share.

    Parameters
    ----------
    velocity : sympy.Symbol
        The friction direction is its sign.
    values : mapping of sympy.Symbol to Fraction
        Numbers in place of symbols.
    """

    def __init__(
        self, velocity: sympy.Symbol, values: Mapping[sympy.Symbol, Number] | None = None
    ) -> None:
        self.algebra = Algebra()
        self._values = values or {}
        self._made: dict[sympy.Basic, Sum] = {}
        self._made[DIRECTION] = self.algebra.sign(self(velocity))

    def __call__(self, expression: sympy.Basic) -> Sum:
        """The sum of an expression.

        Raises
        ------
        TooLargeError
            It would take too many products.
        NotRealError
            A part of it is no finite real number, whatever the motion.
        """
        if expression not in self._made:
            self._made[expression] = self._expanded(expression)
        return self._made[expression]

    def free(self, symbol: sympy.Symbol) -> Sum:
        """A symbol itself, also one with a number in its place."""
        return self.algebra.single(Factor("symbol", symbol, frozenset({symbol})))

    def _expanded(self, node: sympy.Basic) -> Sum:
        if node.is_Symbol:
            return self._symbol(node)
        if node == sympy.E:
            return self._natural(constant(1))
        if node.is_Number or node.is_NumberSymbol:
            return constant(_number(node))
        if node.is_Add:
            return self._sum(self(term) for term in node.args)
        if node.is_Mul:
            return self._multiplied(node)
        if node.is_Pow:
            return self._power(node.base, self._inside(node.exp))
        if isinstance(node, sympy.Piecewise):
            return self._chosen(node.args)
        if isinstance(node, Boolean):
            return self._indicator(node)
        if not node.args:
            raise NotRealError(f"{node} is no real number.")
        return self._applied(node)

    def _inside(self, node: sympy.Basic) -> Sum:
        """The sum of an argument, with numbers for powers of e: no weight comes out of it."""
        total: Sum = {}
        for product, weight in self(node).items():
            power = product[0][1] if product else 0
            alone = len(product) == 1 and self.algebra.factor(product[0][0]) == EULER
            if alone and -_LARGEST_POWER < power < _LARGEST_POWER:
                add(total, constant(weight * value_of(sympy.exp, (power,))))
            else:
                add(total, {product: weight})
        return total

    def _symbol(self, node: sympy.Symbol) -> Sum:
        if node in self._values:
            return constant(self._values[node])
        if isinstance(node, ConstantSymbol):
            return constant(_number(sympy.Float(node.value)))
        return self.free(node)

    def _sum(self, terms: Iterable[Sum]) -> Sum:
        total: Sum = {}
        for term in terms:
            add(total, term)
        return total

    def _multiplied(self, node: sympy.Mul) -> Sum:
        joined = joined_exponential(node)
        if joined is None:
            return self._product(self(factor) for factor in node.args)
        rest, exponent = joined
        return self.algebra.times(self(rest), self._natural(self._inside(exponent)))

    def _product(self, factors: Iterable[Sum]) -> Sum:
        total = constant(1)
        for factor in factors:
            total = self.algebra.times(total, factor)
        return total

    def _power(self, base: sympy.Expr, exponent: Sum) -> Sum:
        number = number_in(exponent)
        if number is None:
            return self._exponential(self(base), exponent)
        if isinstance(base, sympy.Abs):
            return self.algebra.modulus(self(base.args[0]), number)
        return self.algebra.power(self(base), number)

    def _exponential(self, base: Sum, exponent: Sum) -> Sum:
        """A power as a product over the terms of its exponent."""
        number = number_in(base)
        if number is not None:
            return self._natural(scaled(exponent, value_of(sympy.log, (number,))))
        size, inside = normal(base, positive=True)
        made = self._natural(scaled(exponent, value_of(sympy.log, (size,))))
        for product, weight in exponent.items():
            if product:
                symbols = self.algebra.symbols({product: 1}, inside)
                factor = Factor("exp", (frozen(inside), product), symbols)
                term = self.algebra.power(self.algebra.single(factor), weight)
            else:
                term = self.algebra.power(inside, weight)
            made = self.algebra.times(made, term)
        return made

    def _natural(self, exponent: Sum) -> Sum:
        """``exp`` of a sum; of a number too, which may be beyond all floating point."""
        made = constant(1)
        for product, weight in exponent.items():
            symbols = self.algebra.symbols({product: 1})
            factor = self.algebra.single(Factor("exp", ("e", product), symbols))
            made = self.algebra.times(made, self.algebra.power(factor, weight))
        return made

    def _applied(self, node: sympy.Basic) -> Sum:
        inner = [self._inside(argument) for argument in node.args]
        if isinstance(node, sympy.exp):
            return self._natural(inner[0])
        if isinstance(node, sympy.Abs):
            return self.algebra.modulus(inner[0])
        if isinstance(node, sympy.sign):
            return self.algebra.sign(inner[0])
        if isinstance(node, sympy.Heaviside):
            return self._step(inner[0])
        if isinstance(node, (sympy.sin, sympy.cos)):
            return self.algebra.wave(node.func.__name__, inner[0])
        if isinstance(node, (Max, Min)):
            return self._extreme(node.func, inner)
        return self._function(node.func, inner)

    def _function(self, kind: Any, inner: list[Sum]) -> Sum:
        numbers = [number_in(total) for total in inner]
        if has_value(kind) and all(number is not None for number in numbers):
            return constant(value_of(kind, [number or 0 for number in numbers]))
        if kind is sympy.log:
            size, rest = normal(inner[0], positive=True)
            made = self._opaque(kind, [rest])
            add(made, constant(value_of(sympy.log, (size,))))
            return made
        if kind in (*_ODD, *_EVEN) and inner[0][min(inner[0])] < 0:
            made = self._opaque(kind, [scaled(inner[0], -1)])
            return scaled(made, -1) if kind in _ODD else made
        return self._opaque(kind, inner)

    def _opaque(self, kind: Any, inner: list[Sum]) -> Sum:
        content = tuple(frozen(total) for total in inner)
        return self.algebra.single(Factor(kind, content, self.algebra.symbols(*inner)))

    def _extreme(self, kind: Any, inner: list[Sum]) -> Sum:
        """The largest or smallest of sums, in any order."""
        numbers = [number for number in map(number_in, inner) if number is not None]
        others = {frozen(total): total for total in inner if number_in(total) is None}
        if numbers:
            extreme = constant(value_of(kind, numbers))
            others[frozen(extreme)] = extreme
        if len(others) == 1:
            return next(iter(others.values()))
        return self._opaque(kind, [others[key] for key in sorted(others)])

    def _step(self, total: Sum) -> Sum:
        """1 where a sum is positive, 0 where it is negative."""
        made = scaled(self.algebra.sign(total), HALF) if total else {}
        add(made, constant(HALF))
        return made

    def _chosen(self, pairs: Iterable[tuple[sympy.Basic, sympy.Basic]]) -> Sum:
        """What is chosen by conditions: a sum over the cases, each times 0 or 1."""
        left, made = constant(1), constant(0)
        before: list[sympy.Basic] = []
        for value, condition in self._open(pairs):
            before.append(condition)
            holds = dict(left) if condition == sympy.true else self._case(before, left)
            add(made, self.algebra.times(self(value), holds))
            add(left, holds, -1)
        return made

    def _open(
        self, pairs: Iterable[tuple[sympy.Basic, sympy.Basic]]
    ) -> Iterator[tuple[sympy.Basic, sympy.Basic]]:
        """The cases that can be, with conditions that the motion decides."""
        for value, condition in pairs:
            decided = condition
            if isinstance(condition, Relational):
                number = number_in(self._side(condition))
                decided = condition if number is None else condition.func(number, 0)
            if decided != sympy.false:
                yield value, decided
            if decided == sympy.true:
                return

    def _case(self, conditions: Sequence[sympy.Basic], left: Sum) -> Sum:
        """1 where the last condition holds and none before it, else 0; `left` is 1 without it."""
        if len(conditions) <= _FEW_CASES and len(_relations(conditions[-1])) <= _FEW_RELATIONS:
            return self.algebra.times(self._indicator(conditions[-1]), left)
        sides = [self._side(relation) for c in conditions for relation in _relations(c)]
        content = (tuple(_form(c) for c in conditions), tuple(frozen(side) for side in sides))
        return self.algebra.single(Factor("case", content, self.algebra.symbols(*sides)), {})

    def _side(self, relation: Relational) -> Sum:
        """What decides a relation, up to a positive number."""
        difference = self(relation.lhs - relation.rhs)
        if number_in(difference) is not None:
            return difference
        return normal(difference, positive=_is_order(relation))[1]

    def _indicator(self, condition: sympy.Basic) -> Sum:
        """1 where a condition holds, 0 where it does not; at a border it may be anything."""
        if condition in (sympy.true, sympy.false):
            return constant(1 if condition == sympy.true else 0)
        if isinstance(condition, (sympy.StrictGreaterThan, sympy.GreaterThan)):
            return self._step(self(condition.lhs - condition.rhs))
        if isinstance(condition, (sympy.StrictLessThan, sympy.LessThan)):
            return self._step(self(condition.rhs - condition.lhs))
        if isinstance(condition, sympy.And):
            return self._product(map(self._indicator, condition.args))
        if isinstance(condition, sympy.Or):
            fails = self._product(_complement(self._indicator(c)) for c in condition.args)
            return _complement(fails)
        if isinstance(condition, sympy.ITE):
            choice, one, other = condition.args
            return self._chosen(((one, choice), (other, sympy.true)))
        if isinstance(condition, (sympy.Not, sympy.Ne)):
            return _complement(self._indicator(~condition))
        if isinstance(condition, sympy.Eq):
            return self._equal(self(condition.lhs - condition.rhs))
        raise NotRealError(f"the condition {condition} cannot be used.")

    def _equal(self, difference: Sum) -> Sum:
        number = number_in(difference)
        if number is not None:
            return constant(0 if number else 1)
        return self._opaque(sympy.Eq, [normal(difference, positive=False)[1]])


def _is_order(relation: Relational) -> bool:
    return not isinstance(relation, (sympy.Eq, sympy.Ne))


def _relations(condition: sympy.Basic) -> list[Relational]:
    """The relations of a condition, in the order in which they stand."""
    return [node for node in sympy.preorder_traversal(condition) if isinstance(node, Relational)]


def _form(condition: sympy.Basic) -> str:
    """How a condition is made of relations; at a border it may be anything."""
    if isinstance(condition, Relational):
        operator = str(condition.rel_op)
        return operator.removesuffix("=") if _is_order(condition) else operator
    return f"{type(condition).__name__}({', '.join(map(_form, condition.args))})"


def _complement(holds: Sum) -> Sum:
    fails = constant(1)
    add(fails, holds, -1)
    return fails


def _number(node: sympy.Expr) -> Fraction:
    if not node.is_finite:
        raise NotRealError(f"{node} is no finite number.")
    if node.is_NumberSymbol:
        return number_symbol(node)
    return Fraction(int(node.p), int(node.q)) if node.is_Rational else Fraction(str(node))
