"""Friction at rest: the velocity's sign becomes a variable of its own.

Coulomb friction is set-valued at rest, so ``sign(dq)`` is replaced by the *friction direction*:
+1 or -1 while the axis slides, and between them while it sticks, such that the forces balance
(Filippov). With it the model is smooth in each mode, and holds row by row for a stuck axis too.
"""

import sympy
from sympy.core.relational import Relational

from axisid.modeling.algebra import jumping_node, vanishes
from axisid.modeling.quantities import DIRECTION
from axisid.support.errors import ModelError


def with_direction(force: sympy.Expr, velocity: sympy.Symbol) -> sympy.Expr:
    """Rewrite what jumps where the velocity changes its sign by the friction direction.

    The force must be affine in the direction, as Filippov's convex combination at rest is. What is
    a polynomial in it becomes that by ``direction**2 = 1``, which holds while sliding: each
    direction keeps its value, and nothing is multiplied out. What is continuous at rest, such as
    ``Abs(dq)``, stays.

    Raises
    ------
    ModelError
        The force jumps with the velocity in another way.
    """
    rewritten = force.replace(
        lambda node: _decides(node, velocity), lambda node: directed(node, velocity)
    ).replace(
        _is_curved,
        lambda node: _affine(*(node.xreplace({DIRECTION: sympy.Integer(s)}) for s in (1, -1))),
    )
    jump = jumping_node(rewritten, velocity)
    if jump is not None:
        raise ModelError(
            f"the term {jump} jumps with the velocity; write the jump with "
            f"sign({velocity}), so that the axis can stick there.",
            code="equation",
        )
    for term in sympy.Add.make_args(rewritten):
        if DIRECTION in term.diff(DIRECTION).free_symbols:
            raise ModelError(
                f"the term {term} is not linear in direction = sign({velocity}), so friction at "
                "rest has no meaning; write the jump as a factor of its own.",
                code="equation",
            )
    return rewritten


def directed(node: sympy.Expr, velocity: sympy.Symbol) -> sympy.Expr:
    """A step or a choice by the friction direction, if the velocity's sign alone decides it."""
    if isinstance(node, sympy.Piecewise):
        return _directed_choice(node, velocity)
    factor = _factor(node.args[0], velocity)
    if factor is None:
        return node
    sign = sympy.sign(factor) * DIRECTION
    return sign if isinstance(node, sympy.sign) else (1 + sign) / 2


def _decides(node: sympy.Basic, velocity: sympy.Symbol) -> bool:
    return isinstance(node, (sympy.sign, sympy.Heaviside, sympy.Piecewise)) and not {
        velocity,
        DIRECTION,
    }.isdisjoint(node.free_symbols)


def _directed_choice(node: sympy.Piecewise, velocity: sympy.Symbol) -> sympy.Expr:
    conditions = [_sides(condition, velocity) for _, condition in node.args]
    if not any(conditions):
        return node
    ahead, back = (
        sympy.Piecewise(
            *(
                (value, pair[side] if pair else condition)
                for (value, condition), pair in zip(node.args, conditions, strict=True)
            )
        ).xreplace({DIRECTION: sympy.Integer(1 - 2 * side)})
        for side in (0, 1)
    )
    at_rest = (ahead - back).xreplace({velocity: sympy.S.Zero})
    if DIRECTION not in node.free_symbols and vanishes(at_rest):
        return node
    return _affine(ahead, back)


def _sides(
    condition: sympy.Basic, velocity: sympy.Symbol
) -> tuple[sympy.Basic, sympy.Basic] | None:
    """A condition in either direction; None if no relation in it is decided by the direction."""
    found: dict[int, dict[sympy.Basic, sympy.Basic]] = {1: {}, -1: {}}
    for relation in condition.atoms(Relational):
        for side, replaced in found.items():
            there = relation.xreplace({DIRECTION: sympy.Integer(side)})
            if isinstance(there, Relational):
                factor = _factor(there.lhs - there.rhs, velocity)
                there = there if factor is None else there.func(side * factor, 0)
            if there != relation:
                replaced[relation] = there
    ahead, back = (condition.xreplace(replaced) for replaced in found.values())
    return None if ahead == back == condition else (ahead, back)


def _factor(argument: sympy.Expr, velocity: sympy.Symbol) -> sympy.Expr | None:
    """What multiplies an odd power of the velocity; None if the argument is no such product."""
    factor, power = argument.as_independent(velocity, as_Add=False)
    base, exponent = power.as_base_exp()
    odd = base == velocity and exponent.is_Integer and exponent % 2
    return factor if odd else None


def _is_curved(node: sympy.Basic) -> bool:
    """Whether a node is a polynomial in the direction, but not affine."""
    return (
        isinstance(node, (sympy.Add, sympy.Mul, sympy.Pow))
        and DIRECTION in node.free_symbols
        and _is_polynomial(node)
        and DIRECTION in node.diff(DIRECTION).free_symbols
    )


def _is_polynomial(node: sympy.Basic) -> bool:
    if DIRECTION not in node.free_symbols or node == DIRECTION:
        return True
    if node.is_Pow:
        return bool(node.exp.is_Integer and node.exp > 0) and _is_polynomial(node.base)
    if isinstance(node, sympy.Piecewise):
        return all(
            DIRECTION not in condition.free_symbols and _is_polynomial(value)
            for value, condition in node.args
        )
    return bool(node.is_Add or node.is_Mul) and all(map(_is_polynomial, node.args))


def _affine(ahead: sympy.Expr, back: sympy.Expr) -> sympy.Expr:
    """What has a value for each direction; to the last digit, since the other is times 0."""
    if ahead == back:
        return ahead
    if ahead == -back:
        return ahead * DIRECTION
    return ahead * (1 + DIRECTION) / 2 + back * (1 - DIRECTION) / 2
