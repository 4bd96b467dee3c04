"""Results as JSON, which knows no infinite numbers."""

import json
import math
from collections.abc import Iterator, Mapping
from hashlib import sha256
from typing import Any


def json_text(document: Mapping[str, Any]) -> str:
    """A result as JSON on several lines, with its `digest` if it has a schema.

    Raises
    ------
    EstimationError
        A number in it is infinite or none; where it stands is said.
    """
    from axisid.support.errors import EstimationError

    try:
        if "schema" in document:
            document = {**document, "digest": digest(document)}
        return json.dumps(document, indent=2, allow_nan=False) + "\n"
    except ValueError as error:
        place, value = next(_not_finite(document, ""))
        raise EstimationError(
            f"the result cannot be written as JSON, since {place} is {value}. Check the equation "
            "of motion over the positions and speeds of the record, and its units: something in it "
            "is beyond floating point.",
            code="result-file",
        ) from error


def digest(document: Mapping[str, Any]) -> str:
    """What no other document has: sha256 of its members but this one, whose numbers are floats.

    Other programs write 1.0 as 1.
    """
    others = {name: value for name, value in document.items() if name != "digest"}
    floats = json.loads(json.dumps(others), parse_int=float)
    return sha256(json.dumps(floats, sort_keys=True).encode()).hexdigest()


def is_unchanged(document: Mapping[str, Any]) -> bool:
    """Whether a document that was read is as it was written, as far as it says what that was."""
    return "digest" not in document or document["digest"] == digest(document)


def _not_finite(value: Any, place: str) -> Iterator[tuple[str, float]]:
    """Where numbers stand that JSON does not know."""
    if isinstance(value, float) and not math.isfinite(value):
        yield place, value
    items = enumerate(value) if isinstance(value, (list, tuple)) else ()
    for key, inner in value.items() if isinstance(value, Mapping) else items:
        yield from _not_finite(inner, f"{place}.{key}" if place else str(key))
