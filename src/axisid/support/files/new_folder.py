"""A folder to write into, which goes again where nothing comes of it."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def kept_if_filled(place: Path) -> Iterator[None]:
    """A folder, which is not left behind empty where it is new and what is done ends early.

    Raises
    ------
    OSError
        It cannot be made.
    """
    fresh = not place.exists()
    place.mkdir(parents=True, exist_ok=True)
    try:
        yield
    except BaseException:
        if fresh:
            with suppress(OSError):
                place.rmdir()
        raise
