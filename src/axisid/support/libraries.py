"""Libraries that axisid may lack, and their errors on one line."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from textwrap import shorten
from types import ModuleType

from .errors import AxisidError, DataError


def library(name: str, extra: str, file: Path) -> ModuleType:
    """Import an optional library, or say how to install it."""
    from importlib import import_module

    try:
        return import_module(name)
    except ImportError as error:
        raise DataError(
            f"{file} needs the library {name.partition('.')[0]}, which is not installed. Run: "
            f"pip install {name.partition('.')[0]} (or install axisid with the extra {extra})",
            code="missing-library",
        ) from error


def one_line(error: Exception) -> str:
    """A third-party error message on one line, shortened."""
    if isinstance(error, MemoryError):
        return "there is not enough memory for the content that it declares"
    plain = "".join(letter if letter.isprintable() else " " for letter in str(error))
    return shorten(plain.rstrip(". "), 200, placeholder=" ...") or type(error).__name__


@contextmanager
def refusing(damaged: str) -> Iterator[None]:
    """Refuse what a library cannot read, by its own words after a sentence.

    Damaged files raise errors of all kinds: of zip, zlib, struct, memory, index and name.
    """
    try:
        yield
    except AxisidError:
        raise
    except Exception as error:
        raise DataError(f"{damaged}: {one_line(error)}.", code="log-file") from error
