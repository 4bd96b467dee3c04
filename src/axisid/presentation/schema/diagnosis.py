"""What was measured of a result, and the checks."""

from collections.abc import Mapping
from typing import Annotated

from msgspec import UNSET, UnsetType

from .values import JsonObject, WrittenResult, about


class WrittenLawCheck(JsonObject, frozen=True, kw_only=True):
    """The declared control law against the record."""

    passed: Annotated[bool | None, about("null where it could not be made.")]
    factors: Annotated[
        Mapping[str, float] | UnsetType,
        about("Of the law's own terms; each is 1 if the law is the drive's."),
    ] = UNSET
    residual_percent: float | UnsetType | None = UNSET
    fitted_residual_percent: float | UnsetType | None = UNSET
    delay: Annotated[
        int | UnsetType,
        about("Samples by which the control follows the law best."),
    ] = UNSET
    meaning: str


class WrittenExcitation(JsonObject, frozen=True, kw_only=True):
    """What the motion shows of one parameter."""

    share: Annotated[float, about("Of the force's norm.")]
    inflation: Annotated[float | None, about("Variance inflation.")]
    alike: tuple[str, ...]
    lacking: Annotated[tuple[str, ...], about("What the motion lacks, in words.")]
    rows: Annotated[
        float | UnsetType,
        about("How many rows of equal weight would tell of it what the rows do."),
    ] = UNSET
    largest_share: Annotated[
        float | UnsetType | None,
        about("Its largest part of the force along the record over the largest force."),
    ] = UNSET
    natural: Annotated[
        float | UnsetType | None,
        about("What the force and the motion of the record make of its unit."),
    ] = UNSET


class WrittenAlignment(JsonObject, frozen=True, kw_only=True):
    """The delay of the force."""

    best: Annotated[float | None, about("Samples earlier at which the force fits the motion best.")]
    deviation: Annotated[
        float | UnsetType | None, about("Of it, samples, by twins; HAC without them.")
    ] = UNSET
    at_the_end: Annotated[
        bool | UnsetType, about("It left the range in which it is looked for.")
    ] = UNSET
    by_instruments: Annotated[
        bool | UnsetType, about("By the simulated loop and its twins; else by least squares.")
    ] = UNSET
    sensitivity: Annotated[
        Mapping[str, float] | UnsetType,
        about("Change of each parameter per sample."),
    ] = UNSET
    reason: Annotated[str | UnsetType, about("Why it could not be measured.")] = UNSET


class WrittenExplainedLaw(JsonObject, frozen=True, kw_only=True):
    """A ready law with the gains that explain a control best."""

    law: Annotated[str, about("Its name, in `axisid.control` and in TOML.")]
    words: Annotated[Mapping[str, str], about("Its arguments that are no numbers.")]
    gains: Annotated[Mapping[str, float], about("SI, in the control's unit.")]
    sd: Annotated[
        Mapping[str, float],
        about("Of the gains that the record tells apart, for autocorrelated residuals."),
    ]
    delay: Annotated[int, about("Samples between computing a control and logging it.")]
    period: Annotated[float, about("s, of the log.")]
    held_out_percent: Annotated[
        float, about("What it leaves of the control on rows that are held out.")
    ]
    fitted_percent: Annotated[float, about("The same on the rows that its gains are from.")]
    same: Annotated[str, about("What else gives the same control.")]
    toml: Annotated[str, about("How a TOML declaration has it.")]


class WrittenLawSearch(
    WrittenResult, frozen=True, kw_only=True, tag_field="schema", tag="axisid.law/1"
):
    """What `axisid law --json` writes."""

    axis: str
    unit: Annotated[str, about("Of the control.")]
    explained: Annotated[bool, about("Whether the first leaves as little as the law check allows.")]
    as_well: Annotated[int, about("How many of the first leave as little as the best.")]
    laws: Annotated[
        tuple[WrittenExplainedLaw, ...],
        about("By what they leave; of those that leave as little, few gains first."),
    ]
