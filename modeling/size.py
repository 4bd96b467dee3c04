"""How large an expression is, and may become: a bound before anything multiplies it out.

Expanding `(a + b + c)**50` would take hours; counting its terms takes none.
"""

import math

import sympy

from .errors import ModelError

#: Nodes of an expression, and terms it may have when it is multiplied out.
MOST_NODES, MOST_TERMS = 4000, 500


def check_size(value: sympy.Expr, what: str) -> None:
    """Refuse an expression whose derivation would take too long.

    Raises
    ------
    ModelError
        It has too many nodes or levels, or too many terms once it is multiplied out.
    """
    try:
        many, terms = exceeds_nodes(value), most_terms(value)
    except RecursionError as error:
        raise ModelError(f"{what} is nested too deeply; simplify it.") from error
    if many:
        raise ModelError(
            f"{what} has more than {MOST_NODES} operations and operands; declare a smaller model, "
            "or name what repeats as a parameter."
        )
    if terms > MOST_TERMS:
        raise ModelError(
            f"{what} may have more than {MOST_TERMS} terms when it is multiplied out; write less "
            "of it, or smaller powers of sums."
        )


def exceeds_nodes(value: sympy.Expr) -> bool:
    """Whether there are more nodes than allowed; counting stops there."""
    return any(count >= MOST_NODES for count, _ in enumerate(sympy.preorder_traversal(value)))


def most_terms(value: sympy.Expr) -> int:
    """Bound on the terms of an expression, or of one in it, once it and a derivative expand.

    It stops counting at one more than `MOST_TERMS`.
    """
    parts = [most_terms(argument) for argument in value.args]
    if value.is_Add:
        return min(sum(parts), MOST_TERMS + 1)
    if value.is_Mul:
        return min(math.prod(parts), MOST_TERMS + 1)
    if value.is_Pow and parts[0] > 1:
        power = abs(float(value.exp)) if value.exp.is_Number else 1
        times = math.ceil(power) + (0 if value.exp.is_Integer and value.exp > 0 else 2)
        return min(math.comb(parts[0] + times - 1, times), MOST_TERMS + 1)
    inside = max(parts, default=1)
    return inside if inside > MOST_TERMS else 1
