"""The inverse dynamic model: its regressor, with the proof that it is one.

Most axes are linear in all parameters. Some have a few that enter nonlinearly (a Stribeck velocity,
an exponent); such an axis is *partially linear*, and its regressor is that of the force linearised
about given parameters.
"""

from dataclasses import dataclass, replace

import sympy

from axisid.modeling.algebra import intercept, multiplied_out, slope, without
from axisid.support.errors import ModelError

_LEAST = sympy.Float(1e-300)


@dataclass(frozen=True, slots=True, kw_only=True)
class Regressor:
    """One row of a regressor, ``y = columns . parameters + intercept``.

    Attributes
    ----------
    columns : tuple of sympy.Expr
        One per parameter, the derivative of the force; without parameters in them if the axis is
        linear.
    intercept : sympy.Expr
        What the columns leave over: the part that no parameter scales, if the axis is linear.
    nonlinear : tuple of sympy.Symbol
        The parameters that enter nonlinearly, in the axis's order; empty for a linear axis.
        Of the parameters, only these and the weights of their terms are in the columns.
    """

    columns: tuple[sympy.Expr, ...]
    intercept: sympy.Expr
    nonlinear: tuple[sympy.Symbol, ...] = ()

    def at_rest(self, acceleration: sympy.Symbol) -> "Regressor":
        """The row where the acceleration is 0; the columns are affine in it."""
        still = {acceleration: sympy.S.Zero}
        columns = tuple(column.xreplace(still) for column in self.columns)
        return replace(self, columns=columns, intercept=self.intercept.xreplace(still))


def inverse_regressor(force: sympy.Expr, parameters: tuple[sympy.Symbol, ...]) -> Regressor:
    """Split the inverse dynamics into its regressor and its intercept.

    A parameter is nonlinear if the derivative by it depends on it. In the others the force
    must be affine together, which it is exactly when no derivative by one of them has another.

    Raises
    ------
    ModelError
        The force is not affine in its linear parameters (it has their product), the offending term
        is named; or it jumps with a parameter.

    References
    ----------
    Equations (3) and (4) of [Brunot2015]_; [GolubPereyra1973]_ for partially linear models.
    """
    columns = tuple(slope(force, p, "the force") for p in parameters)
    nonlinear = tuple(
        p for p, column in zip(parameters, columns, strict=True) if without(column, {p}) is None
    )
    linear = frozenset(parameters) - set(nonlinear)
    row = tuple(
        without(column, linear) if p in linear else _finite_at_rest(column)
        for p, column in zip(parameters, columns, strict=True)
    )
    slopes = {p: column for p, column in zip(parameters, row, strict=True) if p in linear}
    free = None if None in row else intercept(force, slopes)
    if free is None:
        raise _not_linear(multiplied_out(force, powers=False), parameters)
    bends = (p * column for p, column in zip(parameters, row, strict=True) if p in nonlinear)
    return Regressor(
        columns=row, intercept=sympy.Add(free, *(-bend for bend in bends)), nonlinear=nonlinear
    )


def _finite_at_rest(column: sympy.Expr) -> sympy.Expr:
    """The derivative of ``x**p`` by p is ``x**p log(x)``, which is 0 for x = 0, not 0 times -oo."""
    return column.replace(
        lambda node: isinstance(node, sympy.log) and not node.args[0].is_positive,
        lambda node: sympy.log(sympy.Max(node.args[0], _LEAST)),
    )


def _not_linear(force: sympy.Expr, parameters: tuple[sympy.Symbol, ...]) -> ModelError:
    unknown = set(parameters)
    for term in sympy.Add.make_args(force):
        inside = sorted(term.free_symbols & unknown, key=str)
        if any(term.diff(p).free_symbols & unknown for p in inside):
            names = " and ".join(map(str, inside))
            product = len(inside) > 1 and set(inside) <= set(term.args)
            hint = (
                f"Declare the product as one parameter in place of {names}."
                if product
                else "Replace one by a known number, or declare parameters that enter linearly."
            )
            return ModelError(
                f"the inverse dynamic model is not linear in {names}: see the term {term}. {hint}"
            )
    return ModelError(f"the inverse dynamic model is not linear in its parameters: {force}.")
