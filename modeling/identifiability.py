"""What a regressor can tell apart, whatever the motion.

Columns that are linear combinations of each other as functions cannot be separated by any
experiment: only a combination of their parameters is identifiable.
"""

from collections.abc import Mapping, Sequence

import sympy

Direction = dict[sympy.Symbol, sympy.Expr]


def hidden_directions(
    columns: Sequence[sympy.Expr], parameters: Sequence[sympy.Symbol]
) -> tuple[Direction, ...]:
    """Null space of a regressor over all motions.

    Each column is written over the basis of distinct functions of the motion that occur in it; the
    null space of the coefficients is exact where these functions are independent.

    Returns
    -------
    tuple of dict
        Each maps parameters to the weights of a change that no motion shows.
    """
    basis: dict[sympy.Expr, int] = {}
    entries: dict[tuple[int, int], sympy.Expr] = {}
    for j, column in enumerate(columns):
        for term in sympy.Add.make_args(sympy.expand(column)):
            weight, function = term.as_coeff_Mul()
            if weight != 0:
                row = basis.setdefault(function, len(basis))
                entries[row, j] = entries.get((row, j), sympy.S.Zero) + sympy.Rational(weight)
    matrix = sympy.Matrix(
        max(len(basis), 1), len(columns), lambda i, j: entries.get((i, j), sympy.S.Zero)
    )
    return tuple(
        {p: weight for p, weight in zip(parameters, vector, strict=True) if weight != 0}
        for vector in matrix.nullspace()
    )


def describe_direction(direction: Mapping[sympy.Symbol, sympy.Expr]) -> str:
    """Say in words which parameters trade against each other: ``m +1, J -0.25``."""
    return ", ".join(f"{p} {float(weight):+.4g}" for p, weight in direction.items())
