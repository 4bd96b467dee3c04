"""What a regressor can tell apart, whatever the motion.

Columns that are linear combinations of each other as functions cannot be separated by any
experiment: only a combination of their parameters is identifiable.
"""

from collections.abc import Sequence

import sympy

_EXTREME = 100  # decimal exponent
_SIMPLE, _DIGITS = 1000, 6

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
    scales: list[sympy.Expr] = []
    entries: dict[tuple[int, int], sympy.Expr] = {}
    for j, column in enumerate(columns):
        for term in sympy.Add.make_args(sympy.expand(column)):
            weight, function = term.as_independent(*term.free_symbols, as_Add=False)
            if weight != 0:
                row = basis.setdefault(function, len(basis))
                if row == len(scales):
                    scales.append(power_of_ten(weight))
                exact = sympy.nsimplify(weight * scales[row], rational=True)
                entries[row, j] = entries.get((row, j), sympy.S.Zero) + exact
    matrix = sympy.Matrix(
        max(len(basis), 1), len(columns), lambda i, j: entries.get((i, j), sympy.S.Zero)
    )
    return tuple(
        {p: weight for p, weight in zip(parameters, vector, strict=True) if weight != 0}
        for vector in matrix.nullspace()
    )


def power_of_ten(weight: sympy.Expr) -> sympy.Expr:
    """What brings an extreme weight near 1; 1 for any other.

    Scaling a row does not change the null space, and a number such as exp(-1e4), which expanding a
    Gaussian gives, would be a fraction of thousands of digits.
    """
    exponent = int(sympy.floor(sympy.log(sympy.Abs(sympy.N(weight)), 10)))
    return sympy.Integer(10) ** -exponent if abs(exponent) > _EXTREME else sympy.S.One


def describe_direction(direction: Direction) -> str:
    """Say which parameters trade against each other: ``m +1, J -0.25``; or ``m +m, l -l``."""
    return ", ".join(f"{p} {_signed(weight)}" for p, weight in direction.items())


def _signed(weight: sympy.Expr) -> str:
    if weight.is_number:
        return f"{float(weight):+.4g}"
    text = str(rounded(weight))
    return f"+({text})" if weight.is_Add else text if text.startswith("-") else f"+{text}"


def rounded(expression: sympy.Expr) -> sympy.Expr:
    """An expression with six digits where a number is no simple fraction."""
    return expression.xreplace(
        {
            x: sympy.Float(x, _DIGITS)
            for x in expression.atoms(sympy.Rational)
            if max(abs(x.p), x.q) >= _SIMPLE
        }
    )


def describe_combinations(direction: Direction) -> str:
    """Say what is identifiable of the parameters that trade: ``m + 4 J``."""
    (pivot, size), *others = direction.items()
    combinations = []
    for p, weight in others:
        ratio = -float(weight) / float(size)  # what p + ratio * pivot is worth does not change
        first, second, factor = (p, pivot, ratio) if abs(ratio) > 1 else (pivot, p, 1 / ratio)
        scale = "" if abs(factor) == 1 else f"{abs(factor):.4g} "
        combinations.append(f"{first} {'+' if factor > 0 else '-'} {scale}{second}")
    return ", ".join(combinations)
