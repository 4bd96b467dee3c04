"""Derivatives of expressions with kinks: `Max`, `Min`, `Abs` and what SymPy makes of them.

SymPy differentiates a kink to a step (``Heaviside``, ``sign``) and a step to an impulse
(``DiracDelta``). A step is 1/2 (a sign 0) at the kink, so that the slope there is the mean of the
slopes on both sides.
"""

from collections.abc import Iterator
from itertools import permutations

import sympy
from sympy.functions.elementary.miscellaneous import Max, Min

from axisid.modeling.quantities import extreme
from axisid.support.errors import ModelError

from .point_value import vanishes_where


def slope(value: sympy.Expr, variable: sympy.Symbol, what: str) -> sympy.Expr:
    """Derivative of a continuous expression.

    Parameters
    ----------
    value : sympy.Expr
    variable : sympy.Symbol
    what : str
        What the expression is, for messages.

    Raises
    ------
    ModelError
        The expression jumps where the variable passes a value.
    """
    derivative = _Slopes(variable)(value)
    for impulse in derivative.atoms(sympy.DiracDelta):
        if not _vanishes(derivative, impulse, variable):
            raise ModelError(
                f"{what} jumps with {variable} where {impulse.args[0]} is 0, and so has no "
                f"derivative by it: see {value}. Write what is continuous, such as "
                "max(0, x)**2 for a one-sided spring.",
                code="equation",
            )
        derivative = derivative.xreplace({impulse: sympy.S.Zero})
    if not derivative.has(sympy.Heaviside):
        return derivative
    return derivative.replace(lambda node: node.is_Mul, _without_needless_steps)


def plain_slope(value: sympy.Expr, variable: sympy.Symbol) -> sympy.Expr:
    """The same away from where an expression jumps."""
    derivative = _Slopes(variable)(value)
    return derivative.xreplace(dict.fromkeys(derivative.atoms(sympy.DiracDelta), sympy.S.Zero))


class _Slopes:
    """Derivatives by a variable, each node's once.

    What has a kink stands for itself in SymPy's derivative: SymPy would ask which side is the
    larger, and whether the arguments are real.
    """

    def __init__(self, variable: sympy.Symbol) -> None:
        self._variable = variable
        self._made: dict[sympy.Expr, sympy.Expr] = {}

    def __call__(self, value: sympy.Expr) -> sympy.Expr:
        if self._variable not in value.free_symbols:
            return sympy.S.Zero
        if value not in self._made:
            self._made[value] = self._of(value)
        return self._made[value]

    def _of(self, value: sympy.Expr) -> sympy.Expr:
        if isinstance(value, (Max, Min)):
            return self._of_extreme(value)
        if isinstance(value, (sympy.Abs, sympy.sign, sympy.Heaviside)):
            inside = value.args[0]
            return _RATES[value.func](inside) * self(inside)
        if value.is_Pow and self._variable not in value.exp.free_symbols:
            # SymPy writes base**exp / base, which has no value where a hinge is 0.
            return value.exp * value.base ** (value.exp - 1) * self(value.base)
        if value.is_Mul and any(factor.is_Pow for factor in value.args):
            return self._of_product(value)
        kinks = {node: sympy.Dummy(real=True) for node in _outermost_kinks(value)}
        outer = value.xreplace(kinks)
        derivative = outer.diff(self._variable)
        for node, size in kinks.items():
            slope = self(node)
            if slope != 0:
                derivative += outer.diff(size) * slope
        return derivative.xreplace({size: node for node, size in kinks.items()})

    def _of_product(self, value: sympy.Mul) -> sympy.Expr:
        terms = []
        for factor in value.args:
            slope = self(factor)
            if slope != 0:
                terms.append(slope * sympy.Mul(*(other for other in value.args if other != factor)))
        return sympy.Add(*terms)

    def _of_extreme(self, value: sympy.Expr) -> sympy.Expr:
        sign = 1 if isinstance(value, Max) else -1
        terms = []
        for argument in value.args:
            slope = self(argument)
            if slope != 0:
                others = extreme(value.func, [other for other in value.args if other != argument])
                step = sympy.Heaviside(sign * (argument - others), evaluate=False)
                terms.append(slope * step)
        return sympy.Add(*terms)


_RATES = {
    sympy.Abs: sympy.sign,
    sympy.sign: lambda inside: 2 * sympy.DiracDelta(inside, evaluate=False),
    sympy.Heaviside: lambda inside: sympy.DiracDelta(inside, evaluate=False),
}


def _outermost_kinks(value: sympy.Expr) -> Iterator[sympy.Expr]:
    """The nodes with kinks that are not within others."""
    walk = sympy.preorder_traversal(value)
    for node in walk:
        if isinstance(node, (Max, Min, sympy.Abs, sympy.sign, sympy.Heaviside)):
            walk.skip()
            yield node


def _vanishes(derivative: sympy.Expr, impulse: sympy.DiracDelta, variable: sympy.Symbol) -> bool:
    """Whether what multiplies an impulse is 0 where the impulse is."""
    inside = impulse.args[0]
    rate = inside.diff(variable)
    if len(impulse.args) > 1 or rate == 0 or variable in rate.free_symbols:
        return False
    struck = sympy.Dummy(real=True)
    weight = derivative.xreplace({impulse: struck}).diff(struck)
    return struck not in weight.free_symbols and vanishes_where(weight, inside, variable)


def _without_needless_steps(product: sympy.Mul) -> sympy.Expr:
    """``Heaviside(x) Max(0, x)`` is ``Max(0, x)``, and likewise ``Heaviside(-x) Min(0, x)``."""
    powers = [factor.as_base_exp() for factor in product.args]
    hinges = [base for base, exponent in powers if exponent.is_positive]
    needless = {
        sympy.Heaviside(sign * inside)
        for kind, sign in ((Max, 1), (Min, -1))
        for hinge in hinges
        if isinstance(hinge, kind) and len(hinge.args) == 2
        for inside, other in permutations(hinge.args)
        if other.is_zero
    }
    return sympy.Mul(*(base**e for base, e in powers if base not in needless))
