"""Errors with a sentence for the user, a code and an exit code.

Every message says what was given, what was expected and what to do. An exception that is not an
`AxisidError` is a fault of the program, not of its user. This module is imported without NumPy.
"""

import os
from collections.abc import Sequence
from typing import ClassVar

from .wording import plain_numbers


class AxisidError(ValueError):
    """Base of all errors with a message for the user.

    Parameters
    ----------
    sentence : str
        What was given, what was expected and what to do. Settings in it are spelled by
        `axisid.support.settings.setting`. Numbers up to 1e5 are written without exponent.
    code : str, optional
        Identifies the error among the errors of its class.

    Attributes
    ----------
    code : str
        Identifies the error to a program. An error without its own code has that of its class.
    """

    exit_code: ClassVar[int] = 1
    code: str = "error"

    def __init__(self, sentence: str, *, code: str = "") -> None:
        super().__init__(plain_numbers(sentence))
        if code:
            self.code = code  # kept by pickle, as attributes are


class UsageError(AxisidError):
    """An option or argument is wrong, independently of the axis and the record."""

    exit_code = 2
    code = "usage"


class ModelError(AxisidError):
    """The declared axis is wrong, or does not allow the requested operation."""

    exit_code = 4
    code = "model"


class DataError(AxisidError):
    """The record is missing, malformed, or not suited to the requested operation."""

    exit_code = 3
    code = "data"


class FileError(AxisidError):
    """A file of a user has mistakes; the error lists all of them.

    Attributes
    ----------
    headline : str
        Message without the mistakes.
    mistakes : tuple of str
        A text for each mistake, which may have several lines.
    """

    def __init__(self, headline: str, mistakes: Sequence[str] = (), *, code: str = "") -> None:
        super().__init__(headline, code=code)
        self.args = (headline, mistakes)  # for pickle
        self.headline = headline
        self.mistakes = tuple(mistakes)

    def __str__(self) -> str:
        listed = "\n".join(("", *self.mistakes)).replace("\n", "\n  ")
        return f"{self.headline}{listed}"


class DeclarationError(FileError, ModelError):
    """A declaration of an axis has mistakes; the error lists all of them."""

    code = "declaration"


class RunFileError(FileError, DataError):
    """A run.toml has mistakes; the error lists all of them."""

    code = "run-file"


class EstimationError(AxisidError):
    """The record was read, but no estimate could be computed."""

    exit_code = 6
    code = "estimation"


class CandidateError(EstimationError):
    """A user's own candidate term fails, so the other candidates were not tested."""

    code = "candidate"


def asks_for_tracebacks() -> bool:
    """Return True if ``AXISID_DEBUG`` is set: an internal fault then raises its traceback."""
    return bool(os.environ.get("AXISID_DEBUG"))
