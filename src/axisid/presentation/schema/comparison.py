"""A comparison of candidates, and one of two results."""

from collections.abc import Mapping
from typing import Annotated, Any

from msgspec import UNSET, UnsetType

from .base import JsonObject, WrittenResult, about
from .diagnosis import WrittenCheck
from .estimate import WrittenEstimate
from .record import WrittenPrefilter, WrittenRecord
from .values import WrittenKnown


class WrittenHeldOut(JsonObject, frozen=True, kw_only=True):
    """Errors on rows that the estimate was not made from."""

    error_percent: float | None
    squares_by_block: tuple[float | None, ...]


class WrittenCriteria(JsonObject, frozen=True, kw_only=True):
    """Information criteria."""

    log_likelihood: float | None
    aic: float | None
    bic: float | None
    tic: Annotated[float | None, about("Takeuchi's, for autocorrelated rows.")]


class WrittenParameterCheck(JsonObject, frozen=True, kw_only=True):
    """What one parameter adds."""

    name: str
    p_value: Annotated[float | None, about("That it is zero, HAC.")]
    without_percent: Annotated[float | None, about("Held-out error without it.")]
    informed: Annotated[bool | None, about("Not judged: null, of a nonlinear parameter.")]
    not_tested: Annotated[str | None, about("Why there is no p-value.")]


class WrittenCandidate(JsonObject, frozen=True, kw_only=True):
    """One model of a comparison."""

    name: str
    axis: str
    signature: str
    left_out: Annotated[
        Mapping[str, float],
        about("What stands for the parameters that were left out, SI, by name."),
    ]
    estimate: WrittenEstimate
    criteria: WrittenCriteria
    held_out_equation: WrittenHeldOut
    held_out_simulation: WrittenHeldOut | None
    no_simulation: Annotated[str | None, about("Why not.")]
    parameter_checks: tuple[WrittenParameterCheck, ...]


class WrittenHeldOutBlocks(JsonObject, frozen=True, kw_only=True):
    """How rows were held out."""

    blocks: int
    gap_rows: int


class WrittenNestedTest(JsonObject, frozen=True, kw_only=True):
    """One candidate against a larger one that contains it."""

    smaller: str
    larger: str
    restrictions: int
    dof: int
    f: float | None
    f_p: float | None
    wald: Annotated[float | None, about("Over its restrictions, HAC.")]
    wald_p: float | None
    not_tested: Annotated[str | None, about("Why there are no statistics.")]


class WrittenComparison(
    WrittenResult, frozen=True, kw_only=True, tag_field="schema", tag="axisid.comparison/1"
):
    """What `axisid compare --json` writes."""

    record: WrittenRecord
    records: Annotated[
        tuple[WrittenRecord, ...] | UnsetType,
        about("Where there are several, all of them; `record` is the first."),
    ] = UNSET
    known: Annotated[
        Mapping[str, tuple[WrittenKnown, ...]] | UnsetType,
        about("What is known of each record, SI, by name."),
    ] = UNSET
    set_aside: Annotated[
        Mapping[str, str] | UnsetType,
        about("Records that could not be used, with the reason."),
    ] = UNSET
    prefilter: WrittenPrefilter
    method: str
    rows: int
    held_out: WrittenHeldOutBlocks
    candidates: tuple[WrittenCandidate, ...]
    failures: Annotated[
        Mapping[str, str],
        about("Candidates that the record does not identify, with the reason."),
    ]
    tests: tuple[WrittenNestedTest, ...]
    same: Annotated[tuple[tuple[str, ...], ...], about("One model in different parameters.")]
    recommended: str | None
    tied: tuple[str, ...]
    reason: str


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
