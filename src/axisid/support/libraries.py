"""Libraries that axisid may lack, and their errors on one line."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from textwrap import shorten
from types import ModuleType

from .errors import AxisidError, DataError


def library(name: str, extra: str, file: Path) -> ModuleType:
    """Return an optional library, imported; if it is not installed, say how to install it.

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
        It is not installed.
    """
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
    """Return the message of a third-party error on one line, shortened to 200 characters."""
    if isinstance(error, MemoryError):
        return "there is not enough memory for the content that it declares"
    plain = "".join(letter if letter.isprintable() else " " for letter in str(error))
    return shorten(plain.rstrip(". "), 200, placeholder=" ...") or type(error).__name__


@contextmanager
def refusing(damaged: str) -> Iterator[None]:
    """Turn any error of a library that reads a file into a `DataError`.

    The message is `damaged`, a sentence, followed by that of the library. Damaged files raise
    errors of all kinds: of zip, zlib, struct, memory, index and name.
    """
    try:
        yield
    except AxisidError:
        raise
    except Exception as error:
        raise DataError(f"{damaged}: {one_line(error)}.", code="log-file") from error
