"""What is chosen by conditions, as a sum over the cases, each times a weight of 0 or 1.

So are forces in pieces compared with others: viscous friction in each direction, on each side.
"""

from collections.abc import Sequence
from collections.abc import Set as AbstractSet

import sympy
from sympy.core.relational import Relational

from .friction import directed
from .size import MOST_TERMS, most_terms
from .symbols import DIRECTION

_FEW = 4


class Cases:
    """A force with symbols for the weights of its cases, and the way back.

    A table of known values stays one function of the motion, and so does all where there would be
    too many terms.

    Parameters
    ----------
    force : sympy.Expr
    velocity : sympy.Symbol
    parameters : set of sympy.Symbol

    Attributes
    ----------
    split : sympy.Expr
        The force with symbols for weights, or by the friction direction where that decides.
    """

    def __init__(
        self, force: sympy.Expr, velocity: sympy.Symbol, parameters: AbstractSet[sympy.Symbol]
    ) -> None:
        self._velocity = velocity
        self._weights: dict[sympy.Expr, sympy.Dummy] = {}
        split = force.replace(
            lambda node: (
                isinstance(node, sympy.Piecewise)
                and node.args[-1].cond == sympy.true
                and (len(node.args) <= _FEW or not parameters.isdisjoint(node.free_symbols))
            ),
            self._by_case,
        )
        self.split = force if most_terms(split) > MOST_TERMS else split

    def joined(self, total: sympy.Expr) -> sympy.Expr:
        """A sum of products of what was split, with conditions for weights again.

        Powers of weights, which are 0 or 1, are lowered, and those of the direction, which is 1 or
        -1.
        """
        symbols = set(self._weights.values())

        def lower(power: sympy.Pow) -> sympy.Expr:
            base = power.base
            return base if base in symbols or power.exp % 2 else sympy.S.One

        joined = total.replace(
            lambda node: (
                node.is_Pow
                and (node.base in symbols or node.base == DIRECTION)
                and node.exp.is_Integer
                and node.exp > 0
            ),
            lower,
        )
        for case, weight in reversed(self._weights.items()):  # a case may have others within
            joined = joined.xreplace({weight: case})
        return joined

    def _by_case(self, node: sympy.Piecewise) -> sympy.Expr:
        values, conditions = zip(*node.args, strict=True)
        return values[-1] + sum(
            (value - values[-1]) * self._weight(conditions[: i + 1])
            for i, value in enumerate(values[:-1])
        )

    def _weight(self, conditions: Sequence[sympy.Basic]) -> sympy.Expr:
        """What is 1 where the last condition holds and none before it, else 0."""
        *before, last = conditions
        if not before and isinstance(last, Relational):
            last = last.canonical
            if isinstance(last, (sympy.GreaterThan, sympy.StrictGreaterThan)):
                return 1 - self._weight([last.negated])
            if isinstance(last, sympy.LessThan):  # the same but at a point
                last = sympy.StrictLessThan(*last.args)
        none = [(sympy.S.Zero, condition) for condition in before]
        pairs = (*none, (sympy.S.One, last), (sympy.S.Zero, sympy.true))
        case = sympy.Piecewise(*pairs, evaluate=False)  # its evaluation compares all with all
        weight = directed(case, self._velocity)
        opaque = sorted(weight.atoms(sympy.Piecewise), key=sympy.default_sort_key)
        return weight.xreplace(
            {c: self._weights.setdefault(c, sympy.Dummy(real=True)) for c in opaque}
        )
