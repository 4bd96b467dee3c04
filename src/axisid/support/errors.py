"""The errors a user can meet, each with the exit code of the command line.

Every message says what was given, what was expected and what to do. An exception that is not an
`AxisidError` is a fault of the program, not of its user.
"""

from collections.abc import Sequence
from typing import ClassVar


class AxisidError(ValueError):
    """Base of all errors that speak to the user."""

    exit_code: ClassVar[int] = 1


class UsageError(AxisidError):
    """An option or argument is wrong in itself, whatever the axis and the record."""

    exit_code = 2


class ModelError(AxisidError):
    """The declared axis is wrong, or cannot do what is asked of it."""

    exit_code = 4


class DeclarationError(ModelError):
    """A file declares an axis wrongly: every mistake in it.

    Attributes
    ----------
    headline : str
    mistakes : tuple of str
        Each may have several lines.
    """

    def __init__(self, headline: str, mistakes: Sequence[str]) -> None:
        super().__init__(headline, mistakes)
        self.headline = headline
        self.mistakes = tuple(mistakes)

    def __str__(self) -> str:
        listed = "\n".join(self.mistakes).replace("\n", "\n  ")
        return f"{self.headline}\n  {listed}"


class DataError(AxisidError):
    """The record is missing, malformed, or cannot serve what is asked of it."""

    exit_code = 3


class EstimationError(AxisidError):
    """The record was read, but no estimate came of it."""

    exit_code = 6
