"""Progress of a long computation."""

from collections.abc import Callable, Iterable, Iterator
from typing import TypeAlias, TypeVar

T = TypeVar("T")

#: Function called with the number of steps done, the total, and a text on the next step.
Progress: TypeAlias = Callable[[int, int, str], None]


def with_progress(
    items: Iterable[T], progress: Progress | None, said: Callable[[T], str]
) -> Iterator[T]:
    """Yield items one by one; each is announced before it is yielded.

    Parameters
    ----------
    items : iterable
    progress : callable or None
        Called with the number done, the total, and the text of the item.
    said : callable
        Returns the text of an item.
    """
    listed = list(items)
    for done, item in enumerate(listed):
        if progress is not None:
            progress(done, len(listed), said(item))
        yield item
