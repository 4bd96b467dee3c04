"""Progress of a long computation."""

from collections.abc import Callable, Iterable, Iterator
from typing import TypeAlias, TypeVar

T = TypeVar("T")

#: Function called with the number of steps done, the total, and a text on the next step.
Progress: TypeAlias = Callable[[int, int, str], None]


def with_progress(
    items: Iterable[T], progress: Progress | None, text_of: Callable[[T], str]
) -> Iterator[T]:
    """Yield items one by one, and report each item to `progress` before it is yielded.

    Parameters
    ----------
    items : iterable
    progress : callable or None
        Called with the number of items done, the total, and the text of the item; None for no
        report.
    text_of : callable
        Returns the text of an item.
    """
    every = list(items)
    for done, item in enumerate(every):
        if progress is not None:
            progress(done, len(every), text_of(item))
        yield item
