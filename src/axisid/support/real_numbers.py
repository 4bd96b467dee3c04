"""Numbers that a caller gives: real ones, or a sentence that says what they are."""

import sys
from typing import TYPE_CHECKING, TypeGuard

from .errors import AxisidError, UsageError

if TYPE_CHECKING:  # an axis is declared without NumPy
    from numpy.typing import ArrayLike

    from .arrays import Array

_KINDS = {"c": "complex", "U": "text", "S": "text"}


def is_real(value: object) -> TypeGuard[float]:
    """Whether a value is one real number within floating point or infinite, and no truth value."""
    if isinstance(value, int) and not isinstance(value, bool):
        return abs(value) <= sys.float_info.max
    return isinstance(value, float) or _is_numpys(value, "integer", "floating")


def is_whole(value: object) -> TypeGuard[int]:
    """Whether a value is one whole number of a type for those, and no truth value."""
    if isinstance(value, int):
        return not isinstance(value, bool)
    return _is_numpys(value, "integer")


def _is_numpys(value: object, *kinds: str) -> bool:
    """Whether a value is a NumPy number, which there is only where NumPy is loaded."""
    numpy = sys.modules.get("numpy")
    return numpy is not None and isinstance(value, tuple(getattr(numpy, kind) for kind in kinds))


def is_nothing(count: object) -> bool:
    """Whether a count is 0 or left out; what is no count is left to what would count by it."""
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
            f"{what}: {masked} of the values are masked; leave them out, or repair them.",
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
        raise error(f"{what}: the values are {kind}; give real numbers.", code="record")
    return np.asarray(array, dtype=float)
