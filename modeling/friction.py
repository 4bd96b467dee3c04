"""Friction at rest: the velocity's sign becomes a variable of its own.

Coulomb friction is set-valued at rest, so ``sign(dq)`` is replaced by the *friction direction*:
+1 or -1 while the axis slides, and between them while it sticks, such that the forces balance
(Filippov). With it the model is smooth in each mode, and holds row by row for a stuck axis too.
"""

import sympy

from .errors import ModelError
from .symbols import DIRECTION

_DISCONTINUOUS = (sympy.sign, sympy.Heaviside, sympy.Piecewise)


def with_direction(force: sympy.Expr, velocity: sympy.Symbol) -> sympy.Expr:
    """Rewrite ``sign(dq)`` and ``Heaviside(dq)`` by the friction direction.

    Powers are reduced by ``direction**2 = 1``, which holds while sliding; the force must then be
    affine in the direction, as Filippov's convex combination at rest is. ``Abs(dq)`` is continuous
    and stays.

    Raises
    ------
    ModelError
        The force jumps with the velocity in another way.
    """
    directed = force.subs(
        {
            sympy.sign(velocity): DIRECTION,
            sympy.Heaviside(velocity): (1 + DIRECTION) / 2,
        }
    )
    # An exponential stays whole: the factors of a narrow Gaussian are beyond floating point.
    bells = [e for e in directed.atoms(sympy.exp) if DIRECTION not in e.free_symbols]
    whole = {e: sympy.Dummy(real=True) for e in bells}
    rewritten = (
        sympy.expand(directed.xreplace(whole))
        .replace(
            lambda node: node.is_Pow and node.base == DIRECTION and node.exp.is_Integer,
            lambda node: DIRECTION if node.exp % 2 else sympy.S.One,
        )
        .xreplace({dummy: e for e, dummy in whole.items()})
    )
    for kind in _DISCONTINUOUS:
        for node in rewritten.atoms(kind):
            if velocity in node.free_symbols:
                raise ModelError(
                    f"the term {node} jumps with the velocity; write the jump with "
                    f"sign({velocity}), so that the axis can stick there."
                )
    for term in sympy.Add.make_args(rewritten):
        if DIRECTION in term.diff(DIRECTION).free_symbols:
            raise ModelError(
                f"the term {term} is not linear in direction = sign({velocity}), so friction at "
                "rest has no meaning; write the jump as a factor of its own."
            )
    return rewritten
