"""The force as functions of the motion times monomials of the parameters, and what is independent.

``force = sum of f_i(motion) A_ij mu_j(parameters)``, with independent functions f and weights A.
The reduced row echelon form R of A is the smallest set of combinations ``R mu`` that the force
depends on.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import sympy

from axisid.modeling.algebra import Coefficients, exact

from .echelon import Row
from .motions import independent

Exponents = tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Terms:
    """The force over the functions of the motion that occur in it.

    Attributes
    ----------
    monomials : tuple of tuple of int
        Distinct, with exponents by parameter; the parameters themselves first, in their order.
    weights : tuple of list of Fraction
        One row for each function of the motion, scaled at will, one column for each monomial.
    nonlinear : frozenset of sympy.Symbol
        Parameters that enter other than by whole powers; they count as motion, and each has a row
        and a column of its own.
    """

    monomials: tuple[Exponents, ...]
    weights: tuple[Row, ...]
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
        It has too many terms, or is real at no motion.
    """
    force = exact(force)
    coefficients = Coefficients(force, parameters)
    nonlinear, linear = coefficients.nonlinear, parameters
    if nonlinear:
        linear = [p for p in parameters if p not in nonlinear]
        coefficients = Coefficients(force, linear)
    functions: dict[sympy.Expr, int] = {}
    table: list[tuple[int, Exponents, Fraction]] = []
    for powers, weight in coefficients.items():
        by_parameter = dict(zip(linear, powers, strict=True))
        exponents = tuple(by_parameter.get(p, 0) for p in parameters)
        number, function = weight.as_coeff_Mul()
        if any(exponents) and weight != 0:
            place = functions.setdefault(function, len(functions))
            table.append((place, exponents, Fraction(number.p, number.q)))
    rows: list[dict[Exponents, Fraction]] = []
    for shares in independent(list(functions), velocity, {}, positive=nonlinear):
        row: dict[Exponents, Fraction] = {}
        for place, exponents, share in table:
            row[exponents] = row.get(exponents, Fraction(0)) + shares[place] * share
        rows.append({exponents: share for exponents, share in row.items() if share})
    for j, p in enumerate(parameters):
        if p in nonlinear:
            rows.append({tuple(int(i == j) for i in range(len(parameters))): Fraction(1)})
    monomials = tuple(sorted({e for row in rows for e in row}, key=_order))
    return Terms(
        monomials=monomials,
        weights=tuple([row.get(e, Fraction(0)) for e in monomials] for row in rows),
        nonlinear=nonlinear,
    )


def _order(exponents: Exponents) -> tuple[int, tuple[int, ...]]:
    return sum(exponents), tuple(-e for e in exponents)
