"""What no motion tells apart, in words."""

import sympy

from axisid.modeling.derivation import Direction
from axisid.modeling.quantities import rounded


def describe_loss(direction: Direction) -> str:
    """Say what no motion shows, and where all weights are numbers, what it shows of that."""
    lost = f"no motion shows a change of {describe_direction(direction)}"
    if len(direction) == 1 or not all(weight.is_Rational for weight in direction.values()):
        return lost
    return f"{lost}; only {describe_combinations(direction)} can be identified"


def describe_direction(direction: Direction) -> str:
    """Say which parameters trade against each other: ``m +1, J -0.25``; or ``m +m, l -l``."""
    return ", ".join(f"{p} {_signed(weight)}" for p, weight in direction.items())


def _signed(weight: sympy.Expr) -> str:
    if weight.is_number:
        return f"{float(weight):+.4g}"
    text = str(rounded(weight))
    return f"+({text})" if weight.is_Add else text if text.startswith("-") else f"+{text}"


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
