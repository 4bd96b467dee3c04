"""The force as functions of the motion times monomials of the parameters, and what is independent.

``force = sum of mu_j(parameters) f_j(motion)``. The rows of ``f_j`` at motions that have nothing to
do with each other have a reduced row echelon form R, and ``R mu`` is the smallest set of
combinations that the force depends on.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import sympy
from sympy.core.expr import AtomicExpr

from axisid.modeling.algebra import (
    CANNOT,
    Coefficients,
    NotRealError,
    Row,
    reduced_functions,
    value_at,
)

Exponents = tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Terms:
    """The combinations of monomials of the parameters that a force depends on.

    Attributes
    ----------
    monomials : tuple of tuple of int
        Distinct, with exponents by parameter, those of the lowest degree first.
    rows : tuple of list of Fraction
        In reduced row echelon form, one column for each monomial.
    pivots : tuple of int
        The monomial that each row begins with.
    nonlinear : frozenset of sympy.Symbol
        Parameters that enter other than by whole powers; they count as motion, and each has a row
        and a column of its own.
    """

    monomials: tuple[Exponents, ...]
    rows: tuple[Row, ...]
    pivots: tuple[int, ...]
    nonlinear: frozenset[sympy.Symbol]


def force_terms(
    force: sympy.Expr, velocity: sympy.Symbol, parameters: Sequence[sympy.Symbol]
) -> Terms:
    """Split a force into functions of the motion and monomials of the parameters.

    Parameters
    ----------
    force : sympy.Expr
        With the friction direction in place of ``sign(dq)``.
    velocity : sympy.Symbol
    parameters : sequence of sympy.Symbol

    Raises
    ------
    ModelError
        It has too many products of parameters, or a part that is no real number.
    """
    _check_real(force)
    nonlinear = Coefficients(force, parameters).nonlinear
    linear = [p for p in parameters if p not in nonlinear]
    places = [j for j, p in enumerate(parameters) if p not in nonlinear]
    weights: dict[Exponents, sympy.Expr] = {}
    for powers, weight in Coefficients(force, linear).terms:
        exponents = [0] * len(parameters)
        for j, power in zip(places, powers, strict=True):
            exponents[j] = power
        if any(exponents):
            weights[tuple(exponents)] = weight
    weights = dict(sorted(weights.items(), key=lambda item: _order(item[0])))
    found, pivots = reduced_functions(list(weights.values()), velocity)
    own = [j for j, p in enumerate(parameters) if p in nonlinear]
    monomials = [*weights, *(tuple(int(i == j) for i in range(len(parameters))) for j in own)]
    units = [
        [Fraction(i == j) for i in range(len(monomials))]
        for j in range(len(weights), len(monomials))
    ]
    rows = [*([*row, *[Fraction(0)] * len(own)] for row in found), *units]
    order = [
        j
        for j in sorted(range(len(monomials)), key=lambda j: _order(monomials[j]))
        if any(row[j] for row in rows)
    ]
    return Terms(
        monomials=tuple(monomials[j] for j in order),
        rows=tuple([row[j] for j in order] for row in rows),
        pivots=tuple(order.index(j) for j in (*pivots, *range(len(weights), len(monomials)))),
        nonlinear=frozenset(nonlinear),
    )


def _check_real(force: sympy.Expr) -> None:
    nodes = force.atoms(AtomicExpr, sympy.Pow, sympy.Function)
    for node in (n for n in nodes if not (n.is_Rational or n.free_symbols)):
        try:
            value_at(node, {})
        except CANNOT as error:
            raise NotRealError(f"{node} has no finite real value.") from error


def _order(exponents: Exponents) -> tuple[int, tuple[int, ...]]:
    return sum(exponents), tuple(-e for e in exponents)
