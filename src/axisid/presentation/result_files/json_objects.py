"""Base of all document classes, and conversion between results and documents.

Members that have the same name in a result and in its document are converted by their annotations.
A call of `written_as` or `read_as` gives only the other members.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from types import NoneType
from typing import Annotated, Any, Literal, TypeAlias, TypeVar, get_args, get_type_hints

import numpy as np
from msgspec import UNSET, Meta, Struct, UnsetType, json
from numpy.typing import ArrayLike

from axisid.support.arrays import OF_NULL, Array, finite_or_none, to_json
from axisid.support.errors import DataError

Matrix: TypeAlias = tuple[tuple[float, ...], ...]


class JsonObject(Struct, frozen=True, kw_only=True):
    """One object of a document; its members are written in the order of the fields."""


def about(text: str) -> Meta:
    """Return the description of a field in the schema."""
    return Meta(description=text)


def plain(document: object) -> dict[str, Any]:
    """Return a document as plain data; non-finite numbers are None."""
    return dict(json.decode(json.encode(document, enc_hook=to_json)))


def schema_of(document: type[JsonObject]) -> str:
    """Return the member ``schema`` of a document: its name and version."""
    return str(document.__struct_config__.tag)


class WrittenResult(JsonObject, frozen=True, kw_only=True, rename={"written_belief": "belief"}):
    """A result of any kind, with its overall quality."""

    written_belief: Annotated[
        Literal["believed", "with care", "not believed"] | UnsetType,
        about("Conclusion of the verdict; absent in files of earlier versions."),
    ] = UNSET


class WrittenKnown(JsonObject, frozen=True, kw_only=True):
    """A parameter that is declared as known."""

    value: float
    sd: Annotated[float, about("Standard error; 0 for an exact value.")]


def by_name(names: Iterable[str], values: ArrayLike) -> dict[str, float]:
    """Return the values of an array by name."""
    return dict(zip(names, np.ravel(values).tolist(), strict=True))


def check_sizes(
    of: str,
    names: Sequence[str],
    matrices: Mapping[str, Matrix | UnsetType | None],
    numbers: Mapping[str, Mapping[str, Any] | UnsetType | None],
) -> None:
    """Refuse a document whose matrices or numbers do not match its parameters.

    Parameters
    ----------
    of : str
        Part of the document that has the parameters, for the message.
    names : sequence of str
        Names of the parameters.
    matrices : mapping of str to Matrix, UnsetType or None
        Matrices by member, with one row and one column per parameter; UNSET and None are skipped.
    numbers : mapping of str to mapping, UnsetType or None
        Numbers by member and parameter; UNSET and None are skipped.

    Raises
    ------
    DataError
        A matrix has another size, or a number is for another parameter.
    """
    count, listed = len(names), ", ".join(names) or "none"
    for member, matrix in matrices.items():
        lengths = [len(row) for row in matrix or ()]
        if isinstance(matrix, tuple) and lengths != [count] * count:
            raise DataError(
                f"{member} of {of} has {len(lengths)} rows with {lengths} numbers, but there are "
                f"{count} parameters ({listed})",
                code="result-file",
            )
    for member, by_parameter in numbers.items():
        if isinstance(by_parameter, Mapping) and {*by_parameter} != {*names}:
            raise DataError(
                f"{member} of {of} has the parameters {', '.join(by_parameter) or 'none'}, but the "
                f"document has {listed}",
                code="result-file",
            )


_Written = TypeVar("_Written", bound=Struct)
_Result = TypeVar("_Result")

#: Names in results, by the different name of the member in files.
_OF_FILES = {
    "written_belief": "belief",
    "held_out_equation": "equation",
    "interval_95": "interval",
    "not_evaluated": "missing",
    "squares_by_block": "squares",
    "unsettled": "undetermined",
}


#: Names in files, by the different name in results.
_OF_RESULTS = {name: member for member, name in _OF_FILES.items()}


_hints: Callable[[Any], Mapping[str, Any]] = cache(get_type_hints)


def written_as(kind: type[_Written], result: object, /, **others: Any) -> _Written:
    """Return an object of a document with the members of a result.

    Arrays become tuples, dataclasses become the annotated object, and non-finite numbers become
    None if the annotation allows None.

    Parameters
    ----------
    kind : type
        Class of the document object.
    result : object
        Object that has every member as attribute, except for those in `others`.
    **others
        Members that are given explicitly.
    """
    members = {
        name: others[name] if name in others else getattr(result, _OF_FILES.get(name, name))
        for name in _hints(kind)
    }
    return kind(**{name: _plain(each, _hints(kind)[name]) for name, each in members.items()})


def read_as(
    kind: type[_Result],
    written: JsonObject,
    /,
    **others: Any,
) -> _Result:
    """Return a dataclass with the members of an object of a document.

    None becomes NaN or infinity if the annotation of the dataclass states it.

    Parameters
    ----------
    kind : type
        Dataclass with fields named like members. Fields without a member keep their defaults.
    written : JsonObject
    **others
        Fields that are given explicitly.
    """
    names = [field.name for field in fields(kind)]  # type: ignore[arg-type]  # of a dataclass
    restored = {}
    for name in names:
        member = _OF_RESULTS.get(name, name)
        if name not in others and hasattr(written, member):
            restored[name] = _restored(_hints(kind)[name], getattr(written, member))
    return kind(**restored, **others)


def _plain(value: Any, hint: Any) -> Any:
    """Return a value of a result as the annotation `hint` of the document requires it."""
    if isinstance(value, np.ndarray):
        return _plain(tuple(value.tolist()), hint)
    if isinstance(value, Mapping):
        return {name: _plain(each, hint) for name, each in value.items()}
    if isinstance(value, (tuple, list)):
        return tuple(_plain(each, hint) for each in value)
    if is_dataclass(value):
        objects = [kind for kind in _kinds(hint) if issubclass(kind, JsonObject)]
        if objects:
            return written_as(objects[0], value)
    # Without None in the annotation, a non-finite number stays and cannot be written.
    if isinstance(value, float) and NoneType in _kinds(hint):
        return finite_or_none(value)
    return value


def _restored(hint: Any, value: Any) -> Any:
    """Return a value of a document as the annotation `hint` of the result requires it."""
    if isinstance(value, Mapping):
        return {n: _restored(hint, v) for n, v in value.items()}
    if Array in (hint, *get_args(hint)):
        return value if value is None else np.array(value, dtype=float)
    if isinstance(value, tuple):
        return tuple(_restored(hint, each) for each in value)
    if value is None or value is UNSET:
        kinds = _kinds(hint)
        figures = [OF_NULL[kind] for kind in kinds if kind in OF_NULL]
        return figures[0] if figures and NoneType not in kinds else None
    return value


@cache
def _kinds(hint: Any) -> tuple[type, ...]:
    """Return all classes that occur in an annotation, also inside others."""
    inside = [kind for each in get_args(hint) for kind in _kinds(each)]
    return (hint, *inside) if isinstance(hint, type) else tuple(inside)
