"""How large an expression is, and may become: a bound before anything multiplies it out.

Expanding `(a + b + c)**50` would take hours; counting its terms takes none.
"""

import math

import sympy

from axisid.support.errors import ModelError

#: Nodes of an expression, and terms it may have when it is multiplied out.
MOST_NODES, MOST_TERMS = 4000, 500
_MOST_WAVES = 2000  # exponentials of products of sines, which take longer than they are many


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
            "or name what repeats as a parameter.",
            code="expression-size",
        )
    if terms > MOST_TERMS:
        raise ModelError(
            f"{what} may have more than {MOST_TERMS} terms when it is multiplied out; write less "
            "of it, smaller powers of sums, or fewer sines and cosines in a product.",
            code="equation-size",
        )


def exceeds_nodes(value: sympy.Expr) -> bool:
    """Whether there are more nodes than allowed; counting stops there."""
    return any(count >= MOST_NODES for count, _ in enumerate(sympy.preorder_traversal(value)))


def most_terms(value: sympy.Expr) -> int:
    """Bound on the terms of an expression, or of one in it, once it and a derivative expand.

    It stops counting at one more than `MOST_TERMS`, which it also is where products of sines and
    cosines become more waves than allowed.
    """
    if _waves(value) > _MOST_WAVES:
        return MOST_TERMS + 1
    return _terms(value)


def _terms(value: sympy.Expr) -> int:
    return _joined(value, [_terms(argument) for argument in value.args], MOST_TERMS + 1)


def _waves(value: sympy.Expr) -> int:
    """The same with two exponentials for each sine: a product of n sines has 2**n.

    A root is a factor by itself, whatever is in it.
    """
    parts = [_waves(argument) for argument in value.args]
    if max(parts, default=1) > _MOST_WAVES:
        return _MOST_WAVES + 1
    if value.is_Pow and not value.exp.is_Integer:
        return 1
    if isinstance(value, (sympy.sin, sympy.cos)):
        return 2
    return _joined(value, parts, _MOST_WAVES + 1)


def _joined(value: sympy.Expr, parts: list[int], most: int) -> int:
    """Bound on the terms of an expression whose arguments have so many; it stops at `most`."""
    if value.is_Add:
        return min(sum(parts), most)
    if value.is_Mul:
        return min(math.prod(parts), most)
    if value.is_Pow and parts[0] > 1:
        power = float(value.exp) if value.exp.is_Number else 0.5
        times = math.ceil(abs(power)) + (0 if power.is_integer() and power > 0 else 2)
        return min(math.comb(parts[0] + times - 1, times), most)
    inside = max(parts, default=1)
    return inside if inside >= most else 1
