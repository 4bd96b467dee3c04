"""Members of results that JSON has otherwise: numbers that are not finite, and arrays.

A dataclass of such members is its own document: msgspec writes, reads and describes it, with the
three functions for what it does not know itself.
"""

import math
from numbers import Real
from typing import TYPE_CHECKING, Any, TypeAlias

import msgspec
import numpy as np

if TYPE_CHECKING:
    MaybeNan: TypeAlias = float
    MaybeInfinite: TypeAlias = float
else:

    class MaybeNan(Real):
        """A float; JSON's null is not a number."""

    class MaybeInfinite(Real):
        """A float; JSON's null is infinite."""

    MaybeNan.register(float)
    MaybeInfinite.register(float)

#: What a number was that JSON has as null, by its annotation.
OF_NULL: dict[Any, float] = {MaybeInfinite: math.inf, MaybeNan: math.nan, float: math.nan}


def to_json(value: Any) -> Any:
    """A number or an array of NumPy as Python's."""
    return value.tolist()


def from_json(kind: Any, value: Any) -> Any:
    """What is of `MaybeNan`, `MaybeInfinite` or `Array` for a value of JSON.

    Raises
    ------
    ValueError
        It is none.
    """
    try:
        if kind in OF_NULL:
            return OF_NULL[kind] if value is None else msgspec.convert(value, float)
        return np.array(msgspec.convert(value, list[float | None]), dtype=float)
    except msgspec.ValidationError as error:
        raise ValueError(str(error)) from error


def schema_of_kind(kind: Any) -> dict[str, Any]:
    """The JSON schema of the same."""
    number = {"type": ["number", "null"]}
    return number if kind in OF_NULL else {"type": "array", "items": number}
