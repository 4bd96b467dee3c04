"""Documents as plain data, and read from files."""

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

import msgspec

from axisid.support.errors import DataError
from axisid.support.files.result_file import GIVE_RESULT, WRITE_AGAIN, read_result
from axisid.support.remedy import Note

from .base import JsonObject

Expected = TypeVar("Expected", bound=JsonObject)
_SHOWN = 40  # letters


def plain(document: JsonObject | Mapping[str, Any]) -> dict[str, Any]:
    """A document, or its members, as dictionaries, lists, numbers and texts."""
    return dict(_listed(msgspec.to_builtins(document, enc_hook=_number)))


def _number(value: Any) -> Any:
    """A number of NumPy as one of Python's."""
    return value.item()


def _listed(value: Any) -> Any:
    """With lists for tuples, as JSON reads them."""
    if isinstance(value, dict):
        return {name: _listed(each) for name, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_listed(each) for each in value]
    return value


def schema_of(document: type[JsonObject]) -> str:
    """The member ``schema`` of a document, its name and version."""
    return str(document.__struct_config__.tag)


def read_document(
    file: Path,
    *expected: type[Expected],
    refused: Mapping[str, Note] = MappingProxyType({}),
) -> Expected:
    """Read a result that was written as JSON.

    Parameters
    ----------
    file : Path
    *expected : type of JsonObject
        Which documents will do.
    refused : mapping of str to Note
        What to say of documents that will not, by their `schema_of`: ``"is of a stream; ..."``.

    Raises
    ------
    DataError
        The file cannot be read, is no JSON, is another document, or lacks something of its schema.
    """
    content = read_result(file, DataError)
    found = _schema(file, content)
    for document in expected:
        if found == schema_of(document):
            return _decoded(file, content, document)
    if found in refused:
        said = refused[found]
        raise DataError(f"{file} {said.text}", said.remedy, code="other-document")
    what = f"its schema is {found[:_SHOWN]!r}" if found else "it has no schema"
    raise DataError(
        f"{file} is not the result of one identification ({what}, not "
        f"{schema_of(expected[0])!r}). ",
        GIVE_RESULT,
    )


def _schema(file: Path, content: bytes) -> str:
    """Which document it says that it is; empty if it does not."""
    try:
        found = msgspec.json.decode(content)
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
        raise DataError(f"{file} is not JSON: {_said(error)}. ", GIVE_RESULT) from error
    schema = found.get("schema") if isinstance(found, dict) else None
    return schema if isinstance(schema, str) else ""


def _decoded(file: Path, content: bytes, document: type[Expected]) -> Expected:
    try:
        return msgspec.json.decode(content, type=document)
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
        raise DataError(
            f"{file} lacks what its schema promises: {_said(error)}. ",
            WRITE_AGAIN,
            code="broken-schema",
        ) from error


def _said(error: Exception) -> str:
    """What the decoder says, within a sentence: ``expected float, got str at $.rows``."""
    text = str(error).replace("`", "").replace(" - at ", " at ").removeprefix("JSON is malformed: ")
    return text[:1].lower() + text[1:]
