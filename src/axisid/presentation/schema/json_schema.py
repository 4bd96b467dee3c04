"""The JSON schema of results, made from their classes."""

import re
from typing import Any

from msgspec import json

from .comparison import WrittenComparison, WrittenResultComparison
from .diagnosis import WrittenLawSearch
from .identification import WrittenIdentification, WrittenSweep
from .monte_carlo import WrittenMonteCarlo
from .output_fit import WrittenFitValidation, WrittenOutputFit

_DOCUMENTS = (
    WrittenIdentification,
    WrittenSweep,
    WrittenComparison,
    WrittenResultComparison,
    WrittenLawSearch,
    WrittenOutputFit,
    WrittenFitValidation,
    WrittenMonteCarlo,
)
_REFERENCE = "#/$defs/{name}"


def results_schema() -> dict[str, Any]:
    """The schema of every document that ``--json`` writes, draft 2020-12."""
    refs, components = json.schema_components(_DOCUMENTS, ref_template=_REFERENCE)
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
        made["description"] = " ".join(part["description"].split())
    if "properties" in part and isinstance(part.get("title"), str):
        del made["title"]
        made["additionalProperties"] = False
    return _joined(made)


def _joined(part: dict[str, Any]) -> dict[str, Any]:
    """A choice of plain types as one list of them."""
    choices = part.get("anyOf")
    if isinstance(choices, list) and all([*choice] == ["type"] for choice in choices):
        joined = {"type": [choice["type"] for choice in choices]}
        return {key: value for key, value in part.items() if key != "anyOf"} | joined
    return part
