"""Members that a result and its document share by name, written and read by one description.

What the two have alike is said by their fields alone; a call names only what differs.
"""

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any, TypeVar

import numpy as np

from axisid.presentation.schema import JsonObject
from axisid.support.arrays import Array, finite, frozen

_Written = TypeVar("_Written", bound=JsonObject)
_Result = TypeVar("_Result")
_NONE: Mapping[str, float] = {}


def written_as(kind: type[_Written], result: object, **others: Any) -> _Written:
    """A result's members as those of a document; a number that is not finite is None.

    Parameters
    ----------
    kind : type
        Of the object of a document.
    result : object
        Has every member by its name, but for the others.
    **others
        Members that are made in another way.
    """
    names = [name for name in kind.__struct_fields__ if name not in others]
    return kind(**{name: _plain(getattr(result, name)) for name in names}, **others)


def read_as(
    kind: type[_Result],
    written: JsonObject,
    otherwise: Mapping[str, float] = _NONE,
    **others: Any,
) -> _Result:
    """A dataclass with the members of a document's object; what was not finite is not a number.

    Parameters
    ----------
    kind : type
        A dataclass, each of whose fields is a member of the same name, but for the others.
    written : JsonObject
    otherwise : mapping of str to float
        What a number that was not finite was most likely, where that is not nan.
    **others
        Fields that are made in another way.
    """
    same = {
        field.name: _restored(field.type, getattr(written, field.name), otherwise.get(field.name))
        for field in fields(kind)  # type: ignore[arg-type]  # of a dataclass
        if field.name not in others
    }
    return kind(**same, **others)


def number(value: object, otherwise: float | None = None) -> float:
    """A figure; of one that was not finite, or not written, what it was most likely."""
    if isinstance(value, float):
        return value
    return math.nan if otherwise is None else otherwise


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return tuple(map(_plain, value.tolist()))
    if isinstance(value, Mapping):
        return {name: _plain(each) for name, each in value.items()}
    return finite(value) if isinstance(value, float) else value


def _restored(kind: object, value: Any, otherwise: float | None) -> Any:
    if kind is float:
        return number(value, otherwise)
    return frozen(value) if kind == Array else value
