"""Two results side by side."""

from collections.abc import Mapping
from typing import Annotated, Any

from .base import JsonObject, about
from .diagnosis import WrittenCheck


class WrittenDifference(JsonObject, frozen=True, kw_only=True):
    """One parameter of one method in both results."""

    method: str
    name: str
    unit: str
    first: float
    second: float
    sd_first: Annotated[float, about("HAC.")]
    sd_second: Annotated[float, about("HAC.")]
    deviations: Annotated[
        float | None,
        about("`difference` over the root of the summed variances; null where both are zero."),
    ]
    difference: Annotated[float, about("The second less the first.")]


class WrittenAlone(JsonObject, frozen=True, kw_only=True):
    """Methods and parameters that only one has."""

    first: tuple[str, ...]
    second: tuple[str, ...]


class WrittenResultComparison(
    JsonObject, frozen=True, kw_only=True, tag_field="schema", tag="axisid.result_comparison/1"
):
    """What `axisid compare-results --json` writes; a pair is of the first and the second result."""

    first: Annotated[str, about("File, axis and record.")]
    second: Annotated[str, about("File, axis and record.")]
    differences: tuple[WrittenDifference, ...]
    errors_percent: Annotated[
        Mapping[str, tuple[float | None, float | None]],
        about("By method and kind."),
    ]
    alone: Annotated[WrittenAlone, about("Methods and parameters that only one has.")]
    settings: Annotated[Mapping[str, tuple[Any, Any]], about("Those that differ.")]
    verdict: Annotated[
        Mapping[str, tuple[WrittenCheck | None, WrittenCheck | None]],
        about("Checks whose status differs; null where a result does not have it."),
    ]
