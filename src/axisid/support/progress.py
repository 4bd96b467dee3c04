"""Progress of a long computation."""

from collections.abc import Callable, Iterable, Iterator
from typing import TypeAlias, TypeVar

T = TypeVar("T")

#: Called with how many steps are done, of how many, and what the next one is.
Progress: TypeAlias = Callable[[int, int, str], None]


def with_progress(
    items: Iterable[T], progress: Progress | None, said: Callable[[T], str]
) -> Iterator[T]:
    """Items one by one, each announced before it is worked on.

    Parameters
    ----------
    items : iterable
    progress : callable or None
    said : callable
        What is said of an item.
    """
    listed = list(items)
    for done, item in enumerate(listed):
        if progress is not None:
            progress(done, len(listed), said(item))
        yield item
