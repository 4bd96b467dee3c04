"""A fit of a simulated output."""

from collections.abc import Mapping
from typing import Annotated, Literal

from msgspec import UNSET, UnsetType

from .base import JsonObject, WrittenResult, about
from .diagnosis import WrittenCheck, WrittenLawCheck
from .record import WrittenRecord
from .values import WrittenKnown, WrittenLevels


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


class WrittenRecordError(JsonObject, frozen=True, kw_only=True):
    """What a fit leaves of an output of one record."""

    output: Annotated[str | UnsetType, about("What is followed, where not `output` says it.")] = (
        UNSET
    )
    unit: Annotated[str | UnsetType, about("Of that output.")] = UNSET
    weight: Annotated[float | UnsetType, about("By which its errors count, over its unit.")] = UNSET
    rows: Annotated[int, about("Samples that count.")]
    error: Annotated[float, about("Root mean square, in the output's unit.")]
    percent: Annotated[float | None, about("Of the recorded output's.")]
    order: Annotated[int, about("Of the autoregression of the errors.")]
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
    verdict: tuple[WrittenCheck, ...]
    believed: Annotated[bool, about("Whether no check fails.")]
    levels: WrittenLevels | UnsetType = UNSET
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
    verdict: tuple[WrittenCheck, ...]
