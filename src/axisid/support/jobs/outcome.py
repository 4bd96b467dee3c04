"""What became of a job."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Literal, TypeAlias, TypeVar

Item = TypeVar("Item")
Value = TypeVar("Value")

#: Why there is no value: the function raised, the time limit ended it, or its worker was killed.
Kind: TypeAlias = Literal["error", "time", "killed"]


@dataclass(frozen=True, slots=True)
class Failure:
    """Why a job has no value.

    Attributes
    ----------
    kind : Kind
    reason : str
        A sentence without its full stop.
    """

    kind: Kind
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome(Generic[Value]):
    """What became of one item.

    Attributes
    ----------
    place : int
        Of the item among those that were given, from 0.
    value : object
        What the function gave; None where it failed.
    failure : Failure or None
    """

    place: int
    value: Value | None = None
    failure: Failure | None = None


def attempt(function: Callable[[Item], Value], item: Item) -> Value | Failure:
    """What a function makes of an item; what it raises as a failure."""
    try:
        return function(item)
    except Exception as error:
        return failure_of(error)


def failure_of(error: BaseException) -> Failure:
    """What is said of an exception that a job raised."""
    said = " ".join(f"{type(error).__name__}: {error}".removesuffix(": ").split())
    return Failure("error", said)


def timed_out(limit: float | None) -> Failure:
    """What is said of a job that went beyond its time limit, s."""
    return Failure("time", f"it did not end within the time limit of {limit:g} s")


def outcome_of(place: int, given: Value | Failure) -> Outcome[Value]:
    """The outcome of what `attempt` gave."""
    if isinstance(given, Failure):
        return Outcome(place=place, failure=given)
    return Outcome(place=place, value=given)
