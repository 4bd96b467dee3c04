"""The one way to say that something cannot be told: in place of it, with the reason."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Concatenate, ParamSpec, TypeVar

from .number_text import plain_numbers

Found = TypeVar("Found")
Made = TypeVar("Made")
Further = ParamSpec("Further")


@dataclass(frozen=True, slots=True)
class Missing:
    """What stands in place of something that could not be measured, drawn or computed.

    Attributes
    ----------
    reason : str
        Why, as the end of a sentence, and what can be done: ``"the axis declares no control law"``.
    """

    reason: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "reason", plain_numbers(self.reason))

    def __str__(self) -> str:
        return self.reason


def of_found(
    make: Callable[Concatenate[Found, Further], Made],
) -> Callable[Concatenate[Found | Missing, Further], Made | Missing]:
    """What is made of something that was found: where that is missing, so is this, for its reason.

    Parameters
    ----------
    make : callable
        Its first parameter, by place, is what was found.
    """

    @wraps(make)
    def made(
        found: Found | Missing, /, *further: Further.args, **named: Further.kwargs
    ) -> Made | Missing:
        return found if isinstance(found, Missing) else make(found, *further, **named)

    return made
