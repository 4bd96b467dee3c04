"""The inverse dynamic model: friction direction, and regressor with a proof of linearity.

Coulomb friction is set-valued at rest, so ``sign(dq)`` is replaced by the *friction direction*: +1
or -1 while the axis slides, and a value between them while the axis sticks, so that the forces
balance (Filippov). With the friction direction the model is smooth while the axis slides or sticks,
and also holds for the rows of a record in which the axis sticks.

Most axes are linear in all parameters. If a few parameters enter nonlinearly (a Stribeck velocity,
an exponent), the axis is *partially linear*: its regressor is the regressor of the force linearised
about given parameters.
"""

from dataclasses import dataclass

import sympy
from sympy.core.relational import Relational

from axisid.modeling.quantities import (
    DIRECTION,
    intercept,
    jumping_node,
    multiplied_out,
    slope,
    vanishes,
    without,
)
from axisid.support.errors import ModelError


def with_direction(force: sympy.Expr, velocity: sympy.Symbol) -> sympy.Expr:
    """Return a force in which the friction direction replaces jumps at zero velocity.

    The force must be affine in the direction, as in Filippov's convex combination at rest. A
    polynomial in the direction becomes affine by ``direction**2 = 1``, which holds while sliding:
    its values at +1 and -1 do not change, and nothing is multiplied out. Terms that are continuous
    at rest, such as ``Abs(dq)``, stay.

    Parameters
    ----------
    force : sympy.Expr
    velocity : sympy.Symbol

    Raises
    ------
    ModelError
        The force jumps with the velocity in another way.
    """
    # Rewrite signs, steps and pieces, then polynomials in the direction that are not affine.
    rewritten = force.replace(
        lambda node: (
            isinstance(node, (sympy.sign, sympy.Heaviside, sympy.Piecewise))
            and not {velocity, DIRECTION}.isdisjoint(node.free_symbols)
        ),
        lambda node: directed(node, velocity),
    ).replace(
        lambda node: (
            isinstance(node, (sympy.Add, sympy.Mul, sympy.Pow))
            and DIRECTION in node.free_symbols
            and node.is_polynomial(DIRECTION)
            and DIRECTION in node.diff(DIRECTION).free_symbols
        ),
        lambda node: _affine(*(node.xreplace({DIRECTION: sympy.Integer(s)}) for s in (1, -1))),
    )
    jump = jumping_node(rewritten, velocity)
    if jump is not None:
        raise ModelError(
            f"the term {jump} jumps with the velocity. Write the jump with sign({velocity}), so "
            "that the axis can stick there.",
            code="equation",
        )
    for term in sympy.Add.make_args(rewritten):
        if DIRECTION in term.diff(DIRECTION).free_symbols:
            raise ModelError(
                f"the term {term} is not linear in direction = sign({velocity}), so friction at "
                "rest is undefined. Write the jump as a separate factor.",
                code="equation",
            )
    return rewritten


def directed(node: sympy.Expr, velocity: sympy.Symbol) -> sympy.Expr:
    """Return a sign, a step or a Piecewise rewritten by the friction direction.

    It is returned unchanged unless the sign of the velocity alone decides its value or its branch.
    """
    if isinstance(node, sympy.Piecewise):
        return _directed_choice(node, velocity)
    factor = _factor(node.args[0], velocity)
    if factor is None:
        return node
    sign = sympy.sign(factor) * DIRECTION
    return sign if isinstance(node, sympy.sign) else (1 + sign) / 2


def _directed_choice(node: sympy.Piecewise, velocity: sympy.Symbol) -> sympy.Expr:
    """Return a Piecewise rewritten by the friction direction.

    It is returned unchanged if no condition depends on the direction, or if its value is continuous
    at rest. Otherwise its values for both directions are combined by the direction.
    """
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
    """Return a condition for positive and for negative velocity.

    It is None if the condition does not depend on the direction of the motion. Comparisons of a
    multiple of the velocity with 0 are replaced by comparisons without the velocity.
    """
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
    """Return ``c`` if the argument is ``c`` times an odd power of the velocity, otherwise None."""
    factor, power = argument.as_independent(velocity, as_Add=False)
    base, exponent = power.as_base_exp()
    odd = base == velocity and exponent.is_Integer and exponent % 2
    return factor if odd else None


def _affine(ahead: sympy.Expr, back: sympy.Expr) -> sympy.Expr:
    """Return an expression affine in the friction direction with given values at +1 and -1.

    Both values are exact, because the value of the opposite direction is multiplied by 0.
    """
    if ahead == back:
        return ahead
    if ahead == -back:
        return ahead * DIRECTION
    return ahead * (1 + DIRECTION) / 2 + back * (1 - DIRECTION) / 2


_LEAST = sympy.Float(1e-300)  # smallest argument of a logarithm


@dataclass(frozen=True, slots=True, kw_only=True)
class Regressor:
    """One row of a regressor, ``y = columns . parameters + intercept``.

    Attributes
    ----------
    columns : tuple of sympy.Expr
        One per parameter: the derivative of the force with respect to the parameter. For a linear
        axis the columns contain no parameter.
    intercept : sympy.Expr
        The force minus the sum of parameter times column. For a linear axis it is the known part of
        the force, which contains no parameter.
    nonlinear : tuple of sympy.Symbol
        The parameters that enter nonlinearly, in the axis's order; empty for a linear axis. The
        columns contain only these parameters and the parameters that multiply functions of them.
    """

    columns: tuple[sympy.Expr, ...]
    intercept: sympy.Expr
    nonlinear: tuple[sympy.Symbol, ...] = ()


def inverse_regressor(
    force: sympy.Expr,
    parameters: tuple[sympy.Symbol, ...],
    held: tuple[sympy.Symbol, ...] = (),
) -> Regressor:
    """Return the regressor and the intercept of the inverse dynamics.

    A parameter is nonlinear if the derivative of the force with respect to it contains the
    parameter itself. In the other, linear parameters the force must be jointly affine: no
    derivative with respect to a linear parameter may contain a linear parameter. The function
    differentiates the force, finds the nonlinear parameters, removes the linear parameters from the
    columns of linear parameters, and computes the intercept.

    Parameters
    ----------
    force : sympy.Expr
    parameters : tuple of sympy.Symbol
    held : tuple of sympy.Symbol
        Parameters that always count as nonlinear, such as for friction with internal states.

    Raises
    ------
    ModelError
        The force is not affine in its linear parameters, because it contains a product of them (the
        message names the term), or it jumps with a parameter.

    References
    ----------
    Equations (3) and (4) of [Brunot2015]_; [GolubPereyra1973]_ for partially linear models.
    """
    # The derivatives of the force, and the parameters that enter nonlinearly.
    columns = tuple(slope(force, p, "the force") for p in parameters)
    nonlinear = tuple(
        p
        for p, column in zip(parameters, columns, strict=True)
        if p in held or without(column, {p}) is None
    )
    # The columns of linear parameters, written without linear parameters.
    linear = frozenset(parameters) - set(nonlinear)
    row = tuple(
        without(column, linear) if p in linear else _with_finite_logarithms(column)
        for p, column in zip(parameters, columns, strict=True)
    )
    # The part of the force without linear parameters, minus the nonlinear parameters' columns.
    slopes = {p: column for p, column in zip(parameters, row, strict=True) if p in linear}
    free = None if None in row else intercept(force, slopes)
    if free is None:
        raise _not_linear(multiplied_out(force, powers=False), parameters)
    subtracted = (
        -(p * column) for p, column in zip(parameters, row, strict=True) if p in nonlinear
    )
    return Regressor(columns=row, intercept=sympy.Add(free, *subtracted), nonlinear=nonlinear)


def _with_finite_logarithms(column: sympy.Expr) -> sympy.Expr:
    """Return a derivative in which logarithms of 0 are finite.

    The derivative of ``x**p`` with respect to p is ``x**p log(x)``: 0 at x = 0, and not 0 times
    minus infinity.
    """
    return column.replace(
        lambda node: isinstance(node, sympy.log) and not node.args[0].is_positive,
        lambda node: sympy.log(sympy.Max(node.args[0], _LEAST)),
    )


def _not_linear(force: sympy.Expr, parameters: tuple[sympy.Symbol, ...]) -> ModelError:
    """Return the error for a force that is not linear; it names the first nonlinear term."""
    unknown = set(parameters)
    for term in sympy.Add.make_args(force):
        inside = sorted(term.free_symbols & unknown, key=str)
        if any(term.diff(p).free_symbols & unknown for p in inside):
            names = " and ".join(map(str, inside))
            is_product = len(inside) > 1 and set(inside) <= set(term.args)
            if is_product:
                remedy = f"Declare the product as one parameter instead of {names}."
            else:
                remedy = (
                    "Replace one of the parameters in the term by a known number, or declare "
                    "parameters that enter linearly."
                )
            return ModelError(
                f"the inverse dynamic model is not linear in {names} because of the term {term}. "
                f"{remedy}"
            )
    return ModelError(
        f"the inverse dynamic model is not linear in its parameters: {force}. Declare parameters "
        "that enter linearly."
    )
