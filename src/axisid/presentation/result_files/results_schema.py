"""The JSON schema of all written documents, generated from their classes."""

import inspect
import re
from typing import Any

from msgspec import json

from axisid.support.arrays import schema_of_kind

from .identification import WrittenIdentification
from .output_fit import SavedFitValidation, WrittenOutputFit
from .result_comparison import ResultComparison
from .studies import SavedMonteCarlo, WrittenComparison, WrittenLawSearch, WrittenSweep

#: Documents that ``--json`` writes.
_DOCUMENTS = (
    WrittenIdentification,
    WrittenSweep,
    WrittenComparison,
    ResultComparison,
    WrittenLawSearch,
    WrittenOutputFit,
    SavedFitValidation,
    SavedMonteCarlo,
)


_REFERENCE = "#/$defs/{name}"

#: Names and descriptions of members in the docstring of a class.
_ATTRIBUTE = re.compile(r"^(\w[\w, ]*) : .*((?:\n    .+)+)", re.MULTILINE)

#: Schema of the member that documents have only in files.
_DIGEST = {
    "description": "sha256 of the other members as JSON with sorted keys. A changed file is "
    "rejected. Absent in files of earlier versions.",
    "type": "string",
}


def results_schema() -> dict[str, Any]:
    """Return the schema of every document written by ``--json``, draft 2020-12."""
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
    """Return the schema name of a class: ``WrittenHeldOut`` is ``held_out``."""
    name = of_class.removeprefix("Written").removeprefix("Saved")
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()


def _worded(part: Any) -> Any:
    """Return a part of the schema with descriptions from docstrings, closed to unknown members.

    A docstring's list of attributes becomes the descriptions of the members.
    """
    if isinstance(part, list):
        return [_worded(each) for each in part]
    if not isinstance(part, dict):
        return part
    worded = {key: _worded(value) for key, value in part.items()}
    if "$ref" in part:
        worded["$ref"] = _REFERENCE.format(name=_name(part["$ref"].rpartition("/")[2]))
    if isinstance(part.get("description"), str):
        text, _, attributes = inspect.cleandoc(part["description"]).partition("\nAttributes\n---")
        worded["description"] = " ".join(text.split())
        for names, description in _ATTRIBUTE.findall(attributes):
            for name in {*names.split(", ")} & {*worded["properties"]}:
                worded["properties"][name]["description"] = " ".join(description.split())
    if "properties" in part and isinstance(part.get("title"), str):
        del worded["title"]
        worded["required"] = [
            name
            for name, each in worded["properties"].items()
            if name in worded["required"] or "default" in each
        ]
        if "schema" in worded["properties"]:
            worded["properties"]["digest"] = _DIGEST
        worded["additionalProperties"] = False
    return worded
