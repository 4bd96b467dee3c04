"""What all classes of documents have in common, and members that they share with results by name.

What the two have alike is said by their fields alone, all the way down; a call names only what
differs.
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
    """A field's description in the schema."""
    return Meta(description=text)


def plain(document: object) -> dict[str, Any]:
    """A document, or its members, as JSON has them: what is not finite is None."""
    return dict(json.decode(json.encode(document, enc_hook=to_json)))


def schema_of(document: type[JsonObject]) -> str:
    """The member ``schema`` of a document, its name and version."""
    return str(document.__struct_config__.tag)


class WrittenResult(JsonObject, frozen=True, kw_only=True, rename={"written_belief": "belief"}):
    """A result of any kind, and what it is worth."""

    written_belief: Annotated[
        Literal["believed", "with care", "not believed"] | UnsetType,
        about("How far the numbers can be believed; left out in files of earlier versions."),
    ] = UNSET


class WrittenKnown(JsonObject, frozen=True, kw_only=True):
    """A parameter that is declared as known."""

    value: float
    sd: Annotated[float, about("0 for an exact value.")]


def by_name(names: Iterable[str], values: ArrayLike) -> dict[str, float]:
    """Values of an array by the names of what they are of."""
    return dict(zip(names, np.ravel(values).tolist(), strict=True))


def check_sizes(
    of: str,
    names: Sequence[str],
    matrices: Mapping[str, Matrix | UnsetType | None],
    numbers: Mapping[str, Mapping[str, Any] | UnsetType | None],
) -> None:
    """Refuse matrices and numbers of a document that are of other parameters than it has.

    Parameters
    ----------
    of : str
        What the parameters are of, for the message.
    names : sequence of str
        Of the parameters.
    matrices, numbers : mapping
        By member: one row and one column, or one number, for each parameter. A member that the
        document lacks is passed over.

    Raises
    ------
    DataError
    """
    count, listed = len(names), ", ".join(names) or "none"
    for member, matrix in matrices.items():
        lengths = [len(row) for row in matrix or ()]
        if isinstance(matrix, tuple) and lengths != [count] * count:
            raise DataError(
                f"{member} of {of} has {len(lengths)} rows of {lengths} numbers, and there are "
                f"{count} parameters ({listed})",
                code="result-file",
            )
    for member, by_parameter in numbers.items():
        if isinstance(by_parameter, Mapping) and {*by_parameter} != {*names}:
            raise DataError(
                f"{member} of {of} has the parameters {', '.join(by_parameter) or 'none'}, and "
                f"there are {listed}",
                code="result-file",
            )


_Written = TypeVar("_Written", bound=Struct)


_Result = TypeVar("_Result")


#: Members that have another name in files than in results.
_OF_FILES = {
    "written_belief": "belief",
    "held_out_equation": "equation",
    "interval_95": "interval",
    "not_evaluated": "missing",
    "squares_by_block": "squares",
    "unsettled": "undetermined",
}


_OF_RESULTS = {name: member for member, name in _OF_FILES.items()}


_hints: Callable[[Any], Mapping[str, Any]] = cache(get_type_hints)


def written_as(kind: type[_Written], result: object, /, **others: Any) -> _Written:
    """A result's members as those of a document.

    An array is written as tuples, a dataclass as the object that the annotation names, and a number
    that is not finite as None where the annotation has that.

    Parameters
    ----------
    kind : type
        Of the object of a document.
    result : object
        Has every member by its name, but for the others.
    **others
        What is to be written of members that are made in another way.
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
    """A dataclass with the members of a document's object; what was not finite is not a number.

    Where it was infinite, the annotation says so.

    Parameters
    ----------
    kind : type
        A dataclass, each of whose fields is a member of the same name, but for the others and for
        those that no document has, which keep their defaults.
    written : JsonObject
    **others
        Fields that are made in another way.
    """
    names = [field.name for field in fields(kind)]  # type: ignore[arg-type]  # of a dataclass
    same = {
        name: _restored(_hints(kind)[name], getattr(written, member))
        for name in names
        for member in [_OF_RESULTS.get(name, name)]
        if name not in others and hasattr(written, member)
    }
    return kind(**same, **others)


def _plain(value: Any, hint: Any) -> Any:
    """A member of a document for one of a result, as its annotation has it."""
    if isinstance(value, np.ndarray):
        return _plain(tuple(value.tolist()), hint)
    if isinstance(value, Mapping):
        return {name: _plain(each, hint) for name, each in value.items()}
    if isinstance(value, (tuple, list)):
        return tuple(_plain(each, hint) for each in value)
    if is_dataclass(value) and (objects := [k for k in _kinds(hint) if issubclass(k, JsonObject)]):
        return written_as(objects[0], value)
    # What the schema wants a number of stays one, of which no document is made.
    return finite_or_none(value) if isinstance(value, float) and NoneType in _kinds(hint) else value


def _restored(hint: Any, value: Any) -> Any:
    """A member of a result for one of a document, as the result's annotation has it."""
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
    """The classes in an annotation."""
    inside = [kind for each in get_args(hint) for kind in _kinds(each)]
    return (hint, *inside) if isinstance(hint, type) else tuple(inside)
