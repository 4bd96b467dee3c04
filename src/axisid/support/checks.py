"""Checks of arguments: refuse a wrong argument with a sentence, or return it in a common form.

This module is imported without NumPy.
"""

import sys
from collections.abc import Collection, Container, Iterable, Mapping
from typing import TYPE_CHECKING, Any, TypeAlias, TypeGuard

from .errors import AxisidError, UsageError
from .wording import quoted

if TYPE_CHECKING:  # an axis is declared without NumPy
    from numpy.typing import ArrayLike

    from .arrays import Array

#: Condition that is true if an argument is wrong, the sentence of the error without its full stop,
#: and optionally the code of the error.
Refusal: TypeAlias = tuple[object, str] | tuple[object, str, str]


def refuse(error: type[AxisidError], *refusals: Refusal, before: str = "", code: str = "") -> None:
    """Raise an error with the sentence of the first condition that is true; otherwise do nothing.

    Parameters
    ----------
    error : type of AxisidError
    *refusals : (object, str) or (object, str, str)
        Condition, sentence without its full stop, and optionally the code of the error.
    before : str
        Beginning of every sentence.
    code : str
        Code of an error whose refusal has no code.
    """
    for is_wrong, sentence, *own_code in refusals:
        if is_wrong:
            raise error(f"{before}{sentence}.", code=own_code[0] if own_code else code)


def is_among(value: object, names: Container[str]) -> TypeGuard[str]:
    """Return True if a value, of any type, is a text and one of the names."""
    return isinstance(value, str) and value in names


_KINDS = {"c": "complex", "U": "text", "S": "text"}


def is_real(value: object) -> TypeGuard[float]:
    """Return True if a value is one real number, possibly infinite or NaN, and not a bool.

    A whole number that is too large for a float is refused.
    """
    if isinstance(value, int) and not isinstance(value, bool):
        return abs(value) <= sys.float_info.max
    return isinstance(value, float) or _is_numpys(value, "integer", "floating")


def is_whole(value: object) -> TypeGuard[int]:
    """Return True if a value is one whole number of an integer type, and not a bool."""
    return not isinstance(value, bool) and (isinstance(value, int) or _is_numpys(value, "integer"))


def _is_numpys(value: object, *kinds: str) -> bool:
    """Return True if a value is a NumPy number of given kinds; False if NumPy is not loaded."""
    numpy = sys.modules.get("numpy")
    return numpy is not None and isinstance(value, tuple(getattr(numpy, kind) for kind in kinds))


def is_nothing(count: object) -> bool:
    """Return True if a count is None or the whole number 0; False for a value of another type."""
    return count is None or (isinstance(count, int) and count == 0)


def real_array(values: "ArrayLike", what: str, error: type[AxisidError] = UsageError) -> "Array":
    """Return values as an array of floats.

    Parameters
    ----------
    values : array_like
    what : str
        Description of the values, for messages.
    error : type of AxisidError

    Raises
    ------
    AxisidError
        The values are masked, complex, ragged or not numbers.
    """
    import numpy as np

    if type(values) is np.ndarray and values.dtype == np.float64:
        return values
    if isinstance(values, np.ma.MaskedArray) and (masked := int(np.sum(values.mask))):
        raise error(
            f"{what}: {masked} of the values are masked. Remove or repair the masked values.",
            code="record",
        )
    try:
        array = np.asarray(values)
        if array.dtype.kind == "O":  # float() refuses None, which NumPy would convert to NaN
            array = np.array([float(each) for each in array.ravel()]).reshape(array.shape)
    except (TypeError, ValueError, OverflowError) as reason:
        raise error(
            f"{what}: the values are not numeric ({reason}). Give real numbers."
        ) from reason
    if array.dtype.kind not in "biuf":
        kind = _KINDS.get(array.dtype.kind, f"of the type {array.dtype}")
        raise error(f"{what}: the values are {kind}. Give real numbers.", code="record")
    return np.asarray(array, dtype=float)


def listed(given: object) -> tuple[Any, ...]:
    """Return the elements of an iterable as a tuple; a single value or a text as a 1-tuple."""
    return tuple(given) if isinstance(given, Iterable) and not isinstance(given, str) else (given,)


def by_name(given: object, what: str) -> Mapping[str, Any]:
    """Return a mapping of values by name; empty for None.

    Parameters
    ----------
    given : object
    what : str
        Description of the values, for the message.

    Raises
    ------
    UsageError
        `given` is not a mapping.
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
    *rows : (str, object, collection of str)
        Description of the value, the value, and its choices.

    Raises
    ------
    UsageError
        A value is not among its choices.
    """
    for what, given, choices in rows:
        if not is_among(given, choices):
            raise UsageError(
                f"there is no {what} {quoted(given)}. Choose from {', '.join(choices) or 'none'}.",
                code="method",
            )
