"""How large an expression may be, before anything is derived from it.

What deriving takes is counted where the work is done, not guessed from how a formula looks.
"""

import sympy

from axisid.support.errors import ModelError

#: Operations and operands of an expression: different ones, and each as often as it stands there.
MOST_NODES, _MOST_STANDING = 4000, 40_000


def check_size(value: sympy.Expr, what: str) -> None:
    """Refuse an expression that is too large to be walked through again and again.

    Raises
    ------
    ModelError
        It has too many nodes or levels.
    """
    different: set[sympy.Basic] = set()
    try:
        for standing, node in enumerate(sympy.preorder_traversal(value)):
            different.add(node)
            if standing >= _MOST_STANDING or len(different) > MOST_NODES:
                raise ModelError(
                    f"{what} has more than {MOST_NODES} different operations and operands, or "
                    f"{_MOST_STANDING} with those that repeat; declare a smaller model, or name "
                    "what repeats as a parameter.",
                    code="expression-size",
                )
    except RecursionError as error:
        raise ModelError(f"{what} is nested too deeply; simplify it.") from error
