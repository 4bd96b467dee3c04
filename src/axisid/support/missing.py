"""Placeholders, with a reason, for quantities that could not be determined.

This module is imported without NumPy.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Concatenate, ParamSpec, TypeVar

from .wording import plain_numbers

Found = TypeVar("Found")
Made = TypeVar("Made")
Further = ParamSpec("Further")


@dataclass(frozen=True, slots=True)
class Missing:
    """Placeholder, with a reason, for a quantity that could not be measured, drawn or computed.

    Attributes
    ----------
    reason : str
        The reason as the end of a sentence, and what can be done about it: ``"the axis declares no
        control law"``.
    """

    reason: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "reason", plain_numbers(self.reason))

    def __str__(self) -> str:
        return self.reason


def unless_missing(
    make: Callable[Concatenate[Found, Further], Made],
) -> Callable[Concatenate[Found | Missing, Further], Made | Missing]:
    """Return a function that calls `make`, unless its first argument is `Missing`.

    A first argument that is `Missing` is returned unchanged.

    Parameters
    ----------
    make : callable
        The decorated function. Its first argument is a quantity that may be missing.
    """

    @wraps(make)
    def made(
        found: Found | Missing, /, *further: Further.args, **named: Further.kwargs
    ) -> Made | Missing:
        return found if isinstance(found, Missing) else make(found, *further, **named)

    return made
