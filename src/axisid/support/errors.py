"""The errors a user can meet, each with a code, a remedy and the exit code of the command line.

Every message says what was given, what was expected and what to do. An exception that is not an
`AxisidError` is a fault of the program, not of its user.
"""

import os
from collections.abc import Sequence
from typing import ClassVar

from .remedy import Note, Remedy, Wording, as_arguments


class AxisidError(ValueError):
    """Base of all errors that speak to the user.

    Parameters
    ----------
    problem : str
        What was given and what was expected; what to do, unless a remedy says it.
    remedy : Remedy, optional
        What to do, where that is to set something. It goes on where the problem ends.
    code : str, optional
        Tells the error from others of its class.

    Attributes
    ----------
    code : str
        What a program can tell the error by; of the class where the error has none of its own.
    problem, remedy
        As they were given; the text of the error is both, its settings as arguments of Python.
    """

    exit_code: ClassVar[int] = 1
    code: str = "error"

    def __init__(self, problem: str, remedy: Remedy | None = None, *, code: str = "") -> None:
        super().__init__(problem)  # the others are kept by pickle as attributes
        self.problem = problem
        self.remedy = remedy
        if code:
            self.code = code

    @property
    def note(self) -> Note:
        """What it says, to be worded later."""
        return Note(self.problem, self.remedy)

    def worded(self, wording: Wording) -> str:
        """What it says, with the settings as options or as arguments."""
        return self.note.worded(wording)

    def __str__(self) -> str:
        return self.worded(as_arguments)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({str(self)!r})"


class UsageError(AxisidError):
    """An option or argument is wrong in itself, whatever the axis and the record."""

    exit_code = 2
    code = "usage"


class ModelError(AxisidError):
    """The declared axis is wrong, or cannot do what is asked of it."""

    exit_code = 4
    code = "model"


class DataError(AxisidError):
    """The record is missing, malformed, or cannot serve what is asked of it."""

    exit_code = 3
    code = "data"


class FileError(AxisidError):
    """A file that a user wrote is wrong: every mistake in it.

    Attributes
    ----------
    headline : str
    mistakes : tuple of str
        Each may have several lines.
    """

    def __init__(self, headline: str, mistakes: Sequence[str] = (), *, code: str = "") -> None:
        listed = "\n".join(("", *mistakes)).replace("\n", "\n  ")
        super().__init__(f"{headline}{listed}", code=code)
        self.args = (headline, mistakes)  # for pickle
        self.headline = headline
        self.mistakes = tuple(mistakes)


class DeclarationError(FileError, ModelError):
    """A file declares an axis wrongly: every mistake in it."""

    code = "declaration"


class RunFileError(FileError, DataError):
    """A file says wrongly what a log is: every mistake in it."""

    code = "run-file"


class EstimationError(AxisidError):
    """The record was read, but no estimate came of it."""

    exit_code = 6
    code = "estimation"


def asks_for_tracebacks() -> bool:
    """Whether ``AXISID_DEBUG`` is set: a fault then ends the program where it is."""
    return bool(os.environ.get("AXISID_DEBUG"))
