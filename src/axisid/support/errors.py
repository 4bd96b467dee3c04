"""Errors with their codes, what cannot be told, checks of what is given, and values in messages.

Every message says what was given, what was expected and what to do. An exception that is not an
`AxisidError` is a fault of the program, not of its user. This is imported without NumPy.
"""

import math
import os
import re
import sys
from collections.abc import Callable, Collection, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, is_dataclass
from functools import wraps
from typing import (
    TYPE_CHECKING,
    Any,
    ClassVar,
    Concatenate,
    ParamSpec,
    TypeAlias,
    TypeGuard,
    TypeVar,
)

#: Of a thousand and more to few digits; what is part of a word, a name or a formula stays.
_RAISED = re.compile(r"""(?<![\w.^*/)'"+-])([+-]?)(\d(?:\.\d+)?)e\+0([1-5])(?![\w^*/'"]|\.\w)""")
_PLAIN = 1e5  # up to which numbers of a sentence are written out


def range_text(low: float, high: float, between: str = " .. ", *, digits: int = 4) -> str:
    """Return two bounds with enough digits to differ: ``10.98 .. 11.04``, never ``11 .. 11``.

    Parameters
    ----------
    low, high : float
    between : str
        What stands between them.
    digits : int
        Significant ones, if that is enough.
    """
    width, most = abs(high - low), max(abs(low), abs(high))
    if 0 < width < math.inf:
        digits = max(
            digits, min(math.floor(math.log10(most)) - math.floor(math.log10(width)) + 2, 15)
        )
    return f"{low:.{digits}g}{between}{high:.{digits}g}"


def or_dash(value: float | None, form: str) -> str:
    """Return a number in a format, such as ``.4g``; a dash for None."""
    return "-" if value is None else format(value, form)


def plain_numbers(text: str) -> str:
    """Return a sentence with numbers up to 1e5 written out: ``100 N``, never ``1e+02 N``."""
    return _RAISED.sub(_written_out, text) if "e+0" in text else text


def _written_out(found: re.Match[str]) -> str:
    sign, figures, exponent = found.groups()
    value = float(f"{figures}e{exponent}")
    places = max(len(figures.partition(".")[2]) - int(exponent), 0)
    return f"{sign}{value:.{places}f}" if value <= _PLAIN else found[0]


class AxisidError(ValueError):
    """Base of all errors with a message for the user.

    Parameters
    ----------
    sentence : str
        What was given, what was expected and what to do. A setting stands in it as ``gaps="split"``
        or ``columns position=NAME``: an option of the command line (``--gaps split``), a key of a
        ``run.toml``, and an argument in Python.
    code : str, optional
        Tells the error from others of its class.

    Attributes
    ----------
    code : str
        What a program can tell the error by; of the class where the error has none of its own.
    """

    exit_code: ClassVar[int] = 1
    code: str = "error"

    def __init__(self, sentence: str, *, code: str = "") -> None:
        super().__init__(plain_numbers(sentence))
        if code:
            self.code = code  # kept by pickle, as attributes are


class UsageError(AxisidError):
    """An option or argument is wrong in itself, whatever the axis and the record."""

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
    mistakes : tuple of str
        Each may have several lines.
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


#: Whether something is wrong, what is said of it without the full stop, and a code of its own.
Refusal: TypeAlias = tuple[object, str] | tuple[object, str, str]


def refuse(error: type[AxisidError], *refusals: Refusal, before: str = "", code: str = "") -> None:
    """Raise an error with the sentence of the first condition that is true, if any.

    Parameters
    ----------
    error : type of AxisidError
    *refusals : (object, str) or (object, str, str)
    before : str
        What every sentence begins with.
    code : str
        Of those that have none of their own.
    """
    for is_wrong, said, *own in refusals:
        if is_wrong:
            raise error(f"{before}{said}.", code=own[0] if own else code)


def asks_for_tracebacks() -> bool:
    """Return whether ``AXISID_DEBUG`` is set: a fault then ends the program where it is."""
    return bool(os.environ.get("AXISID_DEBUG"))


Found = TypeVar("Found")
Made = TypeVar("Made")
Further = ParamSpec("Further")


@dataclass(frozen=True, slots=True)
class Missing:
    """Placeholder, with the reason, for a quantity that could not be measured, drawn or computed.

    Attributes
    ----------
    reason : str
        Why, as the end of a sentence, and what can be done: ``"the axis declares no control law"``.
    """

    reason: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "reason", plain_numbers(self.reason))

    def __str__(self) -> str:
        return self.reason


def unless_missing(
    make: Callable[Concatenate[Found, Further], Made],
) -> Callable[Concatenate[Found | Missing, Further], Made | Missing]:
    """Decorate a function so that it passes on a missing first argument with its reason.

    Parameters
    ----------
    make : callable
        Its first parameter, by place, is what was found.
    """

    @wraps(make)
    def made(
        found: Found | Missing, /, *further: Further.args, **named: Further.kwargs
    ) -> Made | Missing:
        return found if isinstance(found, Missing) else make(found, *further, **named)

    return made


_SHORT = 60  # letters of a value that is shown as it is
_DIGITS_OF_A_BIT = 0.30103


def quoted(value: object) -> str:
    """Return the repr of a value, or its type if the repr is long."""
    if isinstance(value, int) and value.bit_length() * _DIGITS_OF_A_BIT > _SHORT:
        # Python refuses to write numbers of some thousand digits.
        return f"a whole number of {value.bit_length() * _DIGITS_OF_A_BIT:.0f} digits"
    # What a dataclass says of itself reads as a sentence within another.
    written = "" if is_dataclass(value) else repr(value)
    if written and len(written) <= _SHORT and "\n" not in written:
        return written
    kind = type(value).__name__
    return f"{'an' if kind[0] in 'AEIOUaeiou' else 'a'} {kind}"


def is_among(value: object, names: Container[str]) -> TypeGuard[str]:
    """Return whether a value is one of some names, also if it has no hash or an array ``==``."""
    return isinstance(value, str) and value in names


def first_of(names: Sequence[str], most: int = 3) -> str:
    """Return the first of some names, and the number of the others."""
    left = len(names) - most
    return ", ".join(names[:most]) + (f" and {left} more" if left > 0 else "")


if TYPE_CHECKING:  # an axis is declared without NumPy
    from numpy.typing import ArrayLike

    from .arrays import Array

_KINDS = {"c": "complex", "U": "text", "S": "text"}


def is_real(value: object) -> TypeGuard[float]:
    """Return whether a value is one real float (or infinite), not a truth value."""
    if isinstance(value, int) and not isinstance(value, bool):
        return abs(value) <= sys.float_info.max
    return isinstance(value, float) or _is_numpys(value, "integer", "floating")


def is_whole(value: object) -> TypeGuard[int]:
    """Return whether a value is one whole number of a type for those, and no truth value."""
    return not isinstance(value, bool) and (isinstance(value, int) or _is_numpys(value, "integer"))


def _is_numpys(value: object, *kinds: str) -> bool:
    """Return whether a value is a NumPy number, which there is only where NumPy is loaded."""
    numpy = sys.modules.get("numpy")
    return numpy is not None and isinstance(value, tuple(getattr(numpy, kind) for kind in kinds))


def is_nothing(count: object) -> bool:
    """Return whether a count is 0 or None; other types are not checked here."""
    return count is None or (isinstance(count, int) and count == 0)


def real_array(values: "ArrayLike", what: str, error: type[AxisidError] = UsageError) -> "Array":
    """Return an array of floats; one that is none yet is made.

    Parameters
    ----------
    values : array_like
    what : str
        They are, for messages.
    error : type of AxisidError

    Raises
    ------
    AxisidError
        They are masked, complex, ragged or no numbers.
    """
    import numpy as np

    if type(values) is np.ndarray and values.dtype == np.float64:
        return values
    if isinstance(values, np.ma.MaskedArray) and (masked := int(np.sum(values.mask))):
        raise error(
            f"{what}: {masked} of the values are masked. Remove or repair them.",
            code="record",
        )
    try:
        array = np.asarray(values)
        if array.dtype.kind == "O":  # None would become not a number without a word
            array = np.array([float(each) for each in array.ravel()]).reshape(array.shape)
    except (TypeError, ValueError, OverflowError) as reason:
        raise error(f"{what}: the values are not numeric: {reason}.") from reason
    if array.dtype.kind not in "biuf":
        kind = _KINDS.get(array.dtype.kind, f"of the type {array.dtype}")
        raise error(f"{what}: the values are {kind}. Give real numbers.", code="record")
    return np.asarray(array, dtype=float)


def listed(given: object) -> tuple[Any, ...]:
    """Return one value or several as a tuple; a text is one value."""
    return tuple(given) if isinstance(given, Iterable) and not isinstance(given, str) else (given,)


def by_name(given: object, what: str) -> Mapping[str, Any]:
    """Return a mapping of values by name; empty for None.

    Raises
    ------
    UsageError
        It is no mapping; `what` says of what.
    """
    if given is not None and not isinstance(given, Mapping):
        raise UsageError(
            f"the {what} are {quoted(given)}. Give a mapping from names to values.",
            code="parameters",
        )
    return given or {}


def check_among(*rows: tuple[str, object, Collection[str]]) -> None:
    """Refuse values that are not among their choices.

    Parameters
    ----------
    *rows : tuple
        What it is, in words, what was given, and the choices.

    Raises
    ------
    UsageError
        It is none of them.
    """
    for what, given, choices in rows:
        if not is_among(given, choices):
            raise UsageError(
                f"there is no {what} {quoted(given)}. Choose from {', '.join(choices) or 'none'}.",
                code="method",
            )


def first_case(*cases: tuple[object, Found]) -> Found:
    """Return the value of the first case that holds; causes come before consequences."""
    return next(said for holds, said in cases if holds)
