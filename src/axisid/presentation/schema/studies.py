"""Fits, studies of twins, and comparisons of candidates and of results."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from msgspec import UNSET, UnsetType

from axisid.estimation.checks import Check, Levels
from axisid.estimation.fitting import RecordError
from axisid.estimation.monte_carlo import CheckFigures, EstimandFigures, FailedRun, Share
from axisid.estimation.studies import Criteria, NestedTest, ParameterCheck
from axisid.estimation.twins import Chain
from axisid.support.presentable import Presentable

from .diagnosis import WrittenLawCheck
from .estimate import WrittenEstimate
from .record import WrittenPrefilter, WrittenRecord, WrittenRequest
from .values import JsonObject, WrittenKnown, WrittenResult, about


class WrittenFitted(JsonObject, frozen=True, kw_only=True):
    """A parameter of a fit."""

    value: Annotated[float, about("In `unit`.")]
    unit: Annotated[str, about("Coherent SI.")]
    sd: Annotated[float | None, about("Of the chosen covariance; null where nothing shows it.")]
    deviations: Annotated[
        Mapping[str, float | None],
        about(
            "By covariance: coloured errors, independent ones; where there are twins, "
            "bootstrap by them."
        ),
    ]
    interval_95: Annotated[
        tuple[float | None, float | None],
        about("On the allowed side alone where the parameter is at a bound."),
    ]
    start: Annotated[float, about("Where the search began.")]
    bounds: Annotated[tuple[float | None, float | None], about("In force; null for none.")]
    at_bound: Annotated[Literal["lower", "upper"] | None, about("Whether it is driven to one.")]
    fixed: Annotated[bool, about("Whether it was held.")]
    prior: Annotated[WrittenKnown | None, about("What was known before, and weighed.")]
    law_percent: Annotated[
        Mapping[str, float],
        about("What each term of the law, 1 % larger, moves it by, SI, by the term's gains."),
    ]
    law_move: Annotated[
        float | None, about("What the law as recorded, in place of the declared one, moves it by.")
    ]


@dataclass(frozen=True, kw_only=True)
class WrittenRecordError(RecordError):  # noqa: D101  # it has that of what it is of
    __doc__ = RecordError.__doc__

    noise: Annotated[
        float, about("Root mean square of what is noise of that error, in the output's unit.")
    ]


class WrittenLack(JsonObject, frozen=True, kw_only=True):
    """What errors ask for beside a model."""

    subject: Annotated[str, about("In words.")]
    size: Annotated[float, about("Of its factor, or by how much a parameter would be more.")]
    deviation: Annotated[float, about("Of the size.")]
    unit: Annotated[str, about("Of both.")]
    chance: Annotated[float, about("That noise asks for as much of it, over all its places.")]
    tests: Annotated[
        int | UnsetType, about("How many were looked for; of files before 2026-11-24.")
    ] = UNSET


class WrittenOutputFit(
    WrittenResult, frozen=True, kw_only=True, tag_field="schema", tag="axisid.fit/1"
):
    """What `axisid fit --json` writes."""

    axis: str
    signature: Annotated[str, about("sha256 of what the generated code was made from.")]
    left_out: Annotated[
        Mapping[str, float],
        about("What stands for the parameters that were left out, SI, by name."),
    ]
    records: tuple[WrittenRecord, ...]
    output: Annotated[str, about("What is followed; several are joined by and.")]
    unit: Annotated[str, about("Of the output; of several the first.")]
    position_unit: Annotated[str, about("Of the coordinate.")]
    encoder_step: Annotated[float, about("Of the coarsest encoder, SI; 0 where none is known.")]
    horizon: Annotated[float | UnsetType, about("Length of the windows of an open loop, s.")] = (
        UNSET
    )
    loss: str
    started: Annotated[str, about("Where the start is from.")]
    parameters: Annotated[Mapping[str, WrittenFitted], about("By name.")]
    covariance: Annotated[
        tuple[tuple[float | None, ...], ...],
        about("Of the parameters in their order, the chosen one; null for infinite."),
    ]
    chosen_covariance: str
    error: Annotated[
        float, about("Root mean square of what is left, in `unit`; of several outputs the first's.")
    ]
    error_percent: Annotated[float | None, about("Of the recorded output; the largest of all.")]
    percent_beyond_noise: Annotated[
        float | None,
        about("Part of the recorded output that is left beyond noise."),
    ]
    record_errors: Annotated[
        tuple[WrittenRecordError, ...], about("By record, and in each by output.")
    ]
    lacks: Annotated[
        tuple[WrittenLack, ...] | None,
        about("What is asked for beside the model, the strongest first; null where not looked."),
    ]
    unseen: Annotated[tuple[str, ...], about("What no output shows, in words.")]
    local: Annotated[
        Mapping[str, tuple[str, ...]] | UnsetType,
        about("Parameters that records have for themselves: their names by record."),
    ] = UNSET
    iterations: Annotated[
        tuple[Mapping[str, float], ...], about("Parameters where slopes were taken, SI.")
    ]
    iteration_errors: Annotated[tuple[float, ...], about("Root mean square there, in `unit`.")]
    costs: Annotated[tuple[float, ...], about("Of each search's end, where several were made.")]
    law_check: WrittenLawCheck
    verdict: tuple[Check, ...]
    believed: Annotated[bool, about("Whether no check fails.")]
    levels: Levels | UnsetType = UNSET
    remarks: tuple[str, ...]


class WrittenFitValidation(
    WrittenResult, frozen=True, kw_only=True, tag_field="schema", tag="axisid.fit_validation/1"
):
    """What `FitValidation.save` writes: a fit, frozen, on a second record."""

    record: WrittenRecord
    output: Annotated[str, about("What is held against the record.")]
    unit: Annotated[str, about("Of the output.")]
    horizon: Annotated[float | None, about("Length of the windows of an open loop, s.")]
    error: Annotated[float, about("Root mean square of what is left, in `unit`.")]
    percent: Annotated[float | None, about("Of the recorded output's.")]
    verdict: tuple[Check, ...]


class WrittenTwins(JsonObject, frozen=True, kw_only=True):
    """What was simulated."""

    axis: str
    signature: str
    right: Annotated[bool, about("Whether what was identified is what was simulated.")]
    noise: Annotated[
        Mapping[str, float | bool | None],
        about(
            "By the names of the options; of several autoregressions the deviation of their sum. "
            "In files without a chain null is the experiment's, or none."
        ),
    ]
    chain: Annotated[
        Chain | UnsetType, about("The same whole, SI; left out in files of earlier versions.")
    ] = UNSET
    position_noise: Annotated[float, about("The experiment's, in the coordinate's unit.")]
    resolution: Annotated[float, about("Likewise; 0 for none.")]
    unit: Annotated[str, about("Of the coordinate.")]
    drive_unit: str


class WrittenMonteCarlo(
    WrittenResult, frozen=True, kw_only=True, tag_field="schema", tag="axisid.monte_carlo/1"
):
    """What `axisid study --json` writes."""

    axis: str
    signature: str
    twins: WrittenTwins
    runs: Annotated[int, about("Asked for.")]
    done: Annotated[int, about("Fewer where the study was ended early.")]
    seed: int
    methods: tuple[str, ...]
    prefilter: Annotated[WrittenRequest, about("As the twins' rate has it.")]
    settings: Annotated[Mapping[str, str | int | None], about("What else was asked of identify.")]
    levels: Annotated[Levels | UnsetType, about("Left out in files of earlier versions.")] = UNSET
    estimands: tuple[EstimandFigures, ...]
    judged: Annotated[int, about("Runs with a verdict.")]
    objected: Annotated[Share, about("Verdicts in which any check fails.")]
    checks: tuple[CheckFigures, ...]
    failures: tuple[FailedRun, ...]


class WrittenHeldOut(JsonObject, frozen=True, kw_only=True):
    """Errors on rows that the estimate was not made from."""

    error_percent: float | None
    squares_by_block: tuple[float | None, ...]


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
    criteria: Criteria
    held_out_equation: WrittenHeldOut
    held_out_simulation: WrittenHeldOut | None
    no_simulation: Annotated[str | None, about("Why not.")]
    parameter_checks: tuple[ParameterCheck, ...]


class WrittenHeldOutBlocks(JsonObject, frozen=True, kw_only=True):
    """How rows were held out."""

    blocks: int
    gap_rows: int


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
    tests: tuple[NestedTest, ...]
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


class ResultComparison(
    Presentable,
    JsonObject,
    frozen=True,
    kw_only=True,
    tag_field="schema",
    tag="axisid.result_comparison/1",
    rename={"errors": "errors_percent", "checks": "verdict"},
):
    """What two results have in common, and where they part.

    It is what `axisid compare-results --json` writes; a pair is of the first and the second result.
    """

    first: Annotated[str, about("File, axis and record.")]
    second: Annotated[str, about("File, axis and record.")]
    differences: tuple[WrittenDifference, ...]
    errors: Annotated[
        Mapping[str, tuple[float | None, float | None]],
        about("By method and kind."),
    ]
    alone: Annotated[WrittenAlone, about("Methods and parameters that only one has.")]
    settings: Annotated[Mapping[str, tuple[Any, Any]], about("Those that differ.")]
    checks: Annotated[
        Mapping[str, tuple[Check | None, Check | None]],
        about("Checks whose status differs; null where a result does not have it."),
    ]
