"""A Monte-Carlo study."""

from collections.abc import Mapping
from typing import Annotated, Literal

from msgspec import UNSET, UnsetType

from axisid.estimation.twins import Chain

from .base import JsonObject, WrittenResult, about
from .record import WrittenRequest
from .values import WrittenLevels


class WrittenMean(JsonObject, frozen=True, kw_only=True):
    """A figure over the runs."""

    value: float | None
    error: Annotated[float | None, about("Its standard error over the runs.")]


class WrittenShare(JsonObject, frozen=True, kw_only=True):
    """How often something happened."""

    count: int
    of: int
    interval_95: Annotated[tuple[float, float], about("Wilson's, of the probability.")]


class WrittenEstimand(JsonObject, frozen=True, kw_only=True):
    """What the runs tell of one parameter by one method."""

    method: str
    name: str
    kind: Annotated[
        Literal["parameter", "direct", "physical"],
        about("As it is identified, of the direct model, or declared and following from others."),
    ]
    unit: str
    truth: Annotated[float | None, about("Null where the twins have no such parameter.")]
    runs: Annotated[int, about("That gave an estimate.")]
    bias: Annotated[WrittenMean, about("Mean error of the value without its bias.")]
    raw_bias: Annotated[WrittenMean, about("Mean error of the value itself.")]
    scatter: Annotated[WrittenMean, about("Standard deviation over the runs.")]
    deviations: Annotated[
        Mapping[str, float],
        about("Root mean square of the stated one, by covariance; `model` of the model's error."),
    ]
    coverage: Annotated[
        Mapping[str, WrittenShare],
        about(
            "How often the 95 % interval of each holds the truth; empty without a truth, and of "
            "what follows from a known value with a deviation, whose error all runs share."
        ),
    ]


class WrittenCheckFigures(JsonObject, frozen=True, kw_only=True):
    """How often a check ended in each way, of the runs that were judged."""

    name: str
    fails: Annotated[WrittenShare, about("Of the runs in which it was evaluated.")]
    notes: WrittenShare
    passes: WrittenShare
    not_evaluated: Annotated[WrittenShare, about("Of all that were judged.")]


class WrittenFailedRun(JsonObject, frozen=True, kw_only=True):
    """Why a run gave no numbers."""

    run: Annotated[int, about("From 0.")]
    of: Annotated[str, about("The method, or `simulation`, or `verdict`.")]
    reason: str


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
    levels: Annotated[
        WrittenLevels | UnsetType, about("Left out in files of earlier versions.")
    ] = UNSET
    estimands: tuple[WrittenEstimand, ...]
    judged: Annotated[int, about("Runs with a verdict.")]
    objected: Annotated[WrittenShare, about("Verdicts in which any check fails.")]
    checks: tuple[WrittenCheckFigures, ...]
    failures: tuple[WrittenFailedRun, ...]
