"""Documents as plain data, read from files, and the JSON schema that is made of their classes."""

import inspect
import re
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

import msgspec
from msgspec import json

from axisid.support.arrays import from_json, schema_of_kind, to_json
from axisid.support.errors import DataError
from axisid.support.files import GIVE_RESULT, WRITE_AGAIN, is_unchanged, read_result

from .diagnosis import WrittenLawSearch
from .identification import WrittenIdentification, WrittenSweep
from .studies import (
    ResultComparison,
    WrittenComparison,
    WrittenFitValidation,
    WrittenMonteCarlo,
    WrittenOutputFit,
)
from .values import JsonObject

Expected = TypeVar("Expected", bound=JsonObject)
_SHOWN = 40  # letters
_DOCUMENTS = (
    WrittenIdentification,
    WrittenSweep,
    WrittenComparison,
    ResultComparison,
    WrittenLawSearch,
    WrittenOutputFit,
    WrittenFitValidation,
    WrittenMonteCarlo,
)
_REFERENCE = "#/$defs/{name}"
#: Of a class's docstring: names of members, and what is said of them.
_ATTRIBUTE = re.compile(r"^(\w[\w, ]*) : .*((?:\n    .+)+)", re.MULTILINE)
#: What a document has as a file alone.
_DIGEST = {
    "description": "sha256 of the other members as JSON with sorted keys: a file that was changed "
    "is refused; left out in files of earlier versions.",
    "type": "string",
}


def plain(document: object) -> dict[str, Any]:
    """A document, or its members, as JSON has them: what is not finite is None."""
    return dict(json.decode(json.encode(document, enc_hook=to_json)))


def schema_of(document: type[JsonObject]) -> str:
    """The member ``schema`` of a document, its name and version."""
    return str(document.__struct_config__.tag)


def read_document(
    file: Path,
    *expected: type[Expected],
    refused: Mapping[str, str] = MappingProxyType({}),
) -> Expected:
    """Read a result that was written as JSON.

    Parameters
    ----------
    file : Path
    *expected : type of JsonObject
        Which documents will do.
    refused : mapping of str to str
        What to say of documents that will not, by their `schema_of`: ``"is of a stream; ..."``.

    Raises
    ------
    DataError
        The file cannot be read, is no JSON, was changed after it was written, is another document,
        or lacks something of its schema.
    """
    content = read_result(file, DataError)
    found = _schema(file, content)
    for document in expected:
        if found == schema_of(document):
            return _decoded(file, content, document)
    if found in refused:
        raise DataError(f"{file} {refused[found]}", code="result-file")
    what = f"its schema is {found[:_SHOWN]!r}" if found else "it has no schema"
    raise DataError(
        f"{file} is not the result of one identification ({what}, not "
        f"{schema_of(expected[0])!r}). {GIVE_RESULT}"
    )


def _schema(file: Path, content: bytes) -> str:
    """Which document it says that it is; empty if it does not."""
    try:
        found = msgspec.json.decode(content)
        members = found if isinstance(found, dict) else {}
        changed = not is_unchanged(members)
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
        raise DataError(f"{file} is not JSON: {_said(error)}. {GIVE_RESULT}") from error
    if changed:
        raise DataError(
            f"{file} was changed after it was written: its digest is of other numbers or words. "
            "Give the file as it was written, or take its member digest out to have it read as it "
            "is.",
            code="changed-result",
        )
    schema = members.get("schema")
    return schema if isinstance(schema, str) else ""


def _decoded(file: Path, content: bytes, document: type[Expected]) -> Expected:
    try:
        return msgspec.json.decode(content, type=document, dec_hook=from_json)
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
        raise DataError(
            f"{file} lacks what its schema promises: {_said(error)}. {WRITE_AGAIN}",
            code="result-file",
        ) from error


def _said(error: Exception) -> str:
    """What the decoder says, within a sentence: ``expected float, got str at $.rows``."""
    text = str(error).replace("`", "").replace(" - at ", " at ").removeprefix("JSON is malformed: ")
    return text[:1].lower() + text[1:]


def results_schema() -> dict[str, Any]:
    """The schema of every document that ``--json`` writes, draft 2020-12."""
    refs, components = json.schema_components(
        _DOCUMENTS, schema_hook=schema_of_kind, ref_template=_REFERENCE
    )
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Results of axisid, version 1",
        "description": "SI units. Numbers that are not finite are null.",
        "oneOf": [_worded(each) for each in refs],
        "$defs": {_name(name): _worded(each) for name, each in components.items()},
    }


def _name(of_class: str) -> str:
    """``WrittenHeldOut`` is ``held_out``."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", of_class.removeprefix("Written")).lower()


def _worded(part: Any) -> Any:
    """A part of the schema, closed against members that it does not name."""
    if isinstance(part, list):
        return [_worded(each) for each in part]
    if not isinstance(part, dict):
        return part
    made = {key: _worded(value) for key, value in part.items()}
    if "$ref" in part:
        made["$ref"] = _REFERENCE.format(name=_name(part["$ref"].rpartition("/")[2]))
    if isinstance(part.get("description"), str):
        text, _, attributes = inspect.cleandoc(part["description"]).partition("\nAttributes\n---")
        made["description"] = " ".join(text.split())
        for names, said in _ATTRIBUTE.findall(attributes):
            for name in {*names.split(", ")} & {*made["properties"]}:
                made["properties"][name]["description"] = " ".join(said.split())
    if "properties" in part and isinstance(part.get("title"), str):
        del made["title"]
        defaults = {name for name, each in made["properties"].items() if "default" in each}
        made["required"] = [n for n in made["properties"] if n in {*made["required"], *defaults}]
        if "schema" in made["properties"]:
            made["properties"]["digest"] = _DIGEST
        made["additionalProperties"] = False
    return _joined(made)


def _joined(part: dict[str, Any]) -> dict[str, Any]:
    """A choice of plain types as one list of them."""
    choices = part.get("anyOf")
    if isinstance(choices, list) and all([*choice] == ["type"] for choice in choices):
        joined = {"type": [choice["type"] for choice in choices]}
        return {key: value for key, value in part.items() if key != "anyOf"} | joined
    return part
