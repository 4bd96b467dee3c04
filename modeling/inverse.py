"""The inverse dynamic model: its regressor, with the proof that it is one."""

from dataclasses import dataclass

import sympy

from .errors import ModelError


@dataclass(frozen=True, slots=True, kw_only=True)
class Regressor:
    """One row of a regressor, ``y = columns . parameters + known``.

    Attributes
    ----------
    columns : tuple of sympy.Expr
        One per parameter, without parameters in them.
    known : sympy.Expr
        The part that no parameter scales.
    """

    columns: tuple[sympy.Expr, ...]
    known: sympy.Expr


def inverse_regressor(force: sympy.Expr, parameters: tuple[sympy.Symbol, ...]) -> Regressor:
    """Split the inverse dynamics into its regressor and what is known.

    The force is affine in the parameters exactly when none of its derivatives with respect to them
    contains one; the derivatives are then the columns.

    Raises
    ------
    ModelError
        The force is not linear in the parameters; the offending term is named.

    References
    ----------
    Equations (3) and (4) of [Brunot2015]_.
    """
    expanded = sympy.expand_mul(force)
    columns = tuple(sympy.expand_mul(expanded.diff(p)) for p in parameters)
    if any(column.free_symbols & set(parameters) for column in columns):
        raise _not_linear(expanded, parameters)
    return Regressor(columns=columns, known=expanded.subs(dict.fromkeys(parameters, 0)))


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
