"""All checks in one sentence: whether the numbers can be believed."""

from collections.abc import Sequence

from .check import Check

#: Where one of these fails the numbers may mean something else than what they are called.
_GRAVE = (
    "control law",
    "rests",
    "simulation",
    "bounds",
    "fixed values",
    "force against control",
    "control against limit",
    "self-test",
)
#: What the others are worth, the cause before what follows from it.
_NEXT = (
    "alignment",
    "least squares against instruments",
    "physical parameters",
    "excitation",
    "instrument strength",
    "precision",
    "residuals against the motion",
    "filter bias",
)


def conclusion(checks: Sequence[Check]) -> str:
    """Whether the numbers can be believed, from the checks of a result."""
    failed = [check for check in by_weight(checks) if check.status == "fail"]
    if not failed:
        return "Nothing that was checked speaks against these numbers."
    if failed[0].name in _GRAVE:
        return f"Do not believe these numbers before this is mended: {failed[0].name}."
    names = ", ".join(check.name for check in failed)
    return f"Believe these numbers with care; to look at: {names}."


def by_weight(checks: Sequence[Check]) -> list[Check]:
    """Checks by what it means for the numbers that they fail, the gravest first."""
    order = (*_GRAVE, *_NEXT)
    place = {name: i for i, name in enumerate(order)}
    return sorted(checks, key=lambda check: place.get(check.name, len(order)))
