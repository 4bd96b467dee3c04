"""Derivatives of expressions with kinks: `Max`, `Min`, `Abs` and what SymPy makes of them.

SymPy differentiates a kink to a step (``Heaviside``, ``sign``) and a step to an impulse
(``DiracDelta``). A step is 1/2 (a sign 0) at the kink, so that the slope there is the mean of the
slopes on both sides.
"""

from itertools import permutations

import sympy
from sympy.functions.elementary.miscellaneous import Max, Min

from .errors import ModelError
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
    derivative = _derivative(value, variable)
    for impulse in derivative.atoms(sympy.DiracDelta):
        if not _vanishes(derivative, impulse, variable):
            raise ModelError(
                f"{what} jumps with {variable} where {impulse.args[0]} is 0, and so has no "
                f"derivative by it: see {value}. Write what is continuous, such as "
                "max(0, x)**2 for a one-sided spring."
            )
        derivative = derivative.xreplace({impulse: sympy.S.Zero})
    if not derivative.has(sympy.Heaviside):
        return derivative
    return derivative.replace(lambda node: node.is_Mul, _without_needless_steps)


def _derivative(value: sympy.Expr, variable: sympy.Symbol) -> sympy.Expr:
    """SymPy's, but that the argument of ``Abs`` is real whether or not SymPy can tell."""
    unclear = {
        node: sympy.Dummy(real=True)
        for node in value.atoms(sympy.Abs)
        if not node.args[0].is_extended_real
    }
    outer = value.xreplace(unclear)
    derivative = outer.diff(variable)
    for node, size in unclear.items():
        inside = node.args[0]
        derivative += outer.diff(size) * sympy.sign(inside) * _derivative(inside, variable)
    return derivative.xreplace({size: node for node, size in unclear.items()})


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
