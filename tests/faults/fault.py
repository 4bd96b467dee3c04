"""What the catalogue of faults is made of."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from axisid import AxisidError


@dataclass(frozen=True, kw_only=True)
class Fault:
    """Something wrong that a user gives the command line, and what must come of it.

    Attributes
    ----------
    name : str
        The class of the fault, as the test is named.
    make : callable or tuple
        Writes the bad input into an empty folder, the current one, and returns the arguments of the
        command; or these, of which callable ones write something and return its place, or None.
    code : int
        The exit code.
    says : str
        A regular expression found in what is said, on stderr where the code is not 0.
    after : callable, optional
        Looks at the folder and at standard output when the command has run.
    environment : mapping of str to str
        Variables of the command, with ``{folder}`` for the folder.
    is_slow : bool
        Whether it takes about a second or more.
    """

    name: str
    make: Callable[[Path], list[object]] | tuple[object, ...]
    code: int
    says: str
    after: Callable[[Path, str], None] | None = None
    environment: Mapping[str, str] = field(default_factory=dict)
    is_slow: bool = False


@dataclass(frozen=True, kw_only=True)
class Misuse:
    """A wrong call of the Python interface, and the error that must come of it."""

    name: str
    call: Callable[[], object]
    error: type[AxisidError]
    says: str
