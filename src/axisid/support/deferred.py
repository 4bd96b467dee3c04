"""A value that is worked out when it is first asked for."""

from collections.abc import Callable
from typing import Any, Generic, TypeVar

from .arrays import same

T = TypeVar("T")


class Deferred(Generic[T]):
    """A value that is worked out when it is first asked for, once.

    A pickle or a copy has the value, not the way to it; two are equal if their values are.

    Parameters
    ----------
    make : callable
        Gives the value; let go of when it has.
    """

    __slots__ = ("_made", "_make")

    def __init__(self, make: Callable[[], T]) -> None:
        self._make: Callable[[], T] | None = make
        self._made: list[T] = []

    @classmethod
    def of(cls, value: T) -> "Deferred[T]":
        """A value that there is already."""
        made = cls(lambda: value)
        _ = made.value
        return made

    @property
    def value(self) -> T:
        """The value; whatever making it raises, every time that it is asked for."""
        make = self._make
        if make is not None and not self._made:
            self._made.append(make())
        self._make = None
        return self._made[0]

    def __reduce__(self) -> tuple[Any, ...]:
        return Deferred.of, (self.value,)

    def __copy__(self) -> "Deferred[T]":
        return self

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Deferred) and same(self.value, other.value)

    __hash__ = None  # type: ignore[assignment]
