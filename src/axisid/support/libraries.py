"""Optional libraries, and their errors as messages on one line."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from textwrap import shorten
from types import ModuleType

from .errors import AxisidError, DataError


def library(name: str, extra: str, file: Path) -> ModuleType:
    """Import and return an optional library; refuse with the command that installs it.

    Parameters
    ----------
    name : str
        Module to import.
    extra : str
        Extra of axisid that installs it.
    file : Path
        The file that needs it, for the message.

    Raises
    ------
    DataError
        The library is not installed.
    """
    from importlib import import_module

    try:
        return import_module(name)
    except ImportError as error:
        raise DataError(
            f"{file} needs the library {name.partition('.')[0]}, which is not installed. Install "
            f"axisid with the extra {extra}, or run: pip install {name.partition('.')[0]}",
            code="missing-library",
        ) from error


def one_line(error: Exception) -> str:
    """Return the message of a third-party error on one line of at most 200 characters.

    An error without a message is named by its type.
    """
    if isinstance(error, MemoryError):
        return "there is not enough memory for the content that it declares"
    plain = "".join(letter if letter.isprintable() else " " for letter in str(error))
    return shorten(plain.rstrip(". "), 200, placeholder=" ...") or type(error).__name__


@contextmanager
def refusing(damaged: str) -> Iterator[None]:
    """Convert any error of a library that reads a file into a `DataError`, within the context.

    The message is `damaged`, a sentence without its full stop, followed by the message of the
    library. Libraries raise errors of all types for damaged files, from zip and zlib errors to
    MemoryError, IndexError and NameError.
    """
    try:
        yield
    except AxisidError:
        raise
    except Exception as error:
        raise DataError(f"{damaged}: {one_line(error)}.", code="log-file") from error
