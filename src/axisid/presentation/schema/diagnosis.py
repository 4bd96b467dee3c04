"""What was measured of a result, and the checks."""

from collections.abc import Mapping
from typing import Annotated, Literal

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


class WrittenStrength(JsonObject, frozen=True, kw_only=True):
    """How strongly the instruments move one column."""

    r_squared: float | None
    shea: float | None
    f: Annotated[float | None, about("null for an exact one.")]
    conditional_f: Annotated[
        float | None,
        about(
            "Conditional on the other columns (Sanderson and Windmeijer); null where it is exact."
        ),
    ]


class WrittenInstruments(JsonObject, frozen=True, kw_only=True):
    """First stage, by regressor column."""

    columns: tuple[WrittenStrength, ...]
    condition_number: Annotated[float | None, about("Of Z'X, unit columns.")]


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


class WrittenLackOfFit(JsonObject, frozen=True, kw_only=True):
    """What is left at phases of the reference that repeat, of the judged estimate."""

    period: Annotated[float | None, about("s; null where moves repeat in another order.")]
    span: Annotated[tuple[float, float], about("Since the record's first sample, s.")]
    times: Annotated[int, about("How often what repeats most often does.")]
    rows: Annotated[int, about("At phases that repeat.")]
    share: Annotated[float, about("Of these rows' power, what repeats.")]
    deviation: Annotated[float, about("Of the share, HAC over the phases.")]
    chance: Annotated[float, about("That noise alone repeats as much.")]
    repeated: Annotated[float, about("Root mean square, in the unit of the left side.")]
    noise: Annotated[float, about("The same of the noise.")]
    left: Annotated[float, about("The same of the left side.")]
    smoothness: Annotated[
        float,
        about("Correlation of the mean residual with that of the next phase."),
    ]
    hac_excess: Annotated[
        Mapping[str, float | None],
        about("HAC deviation in that of the noise alone, by parameter; null without noise."),
    ]
    time: Annotated[tuple[float, ...], about("Of the phases' first rows, s.")]
    mean: Annotated[tuple[float, ...], about("Mean residual by phase.")]
    count: Annotated[tuple[float, ...], about("Repeats by phase.")]


class WrittenBand(JsonObject, frozen=True, kw_only=True):
    """How far the model's error may move a parameter."""

    deviation: Annotated[float, about("Delete-one-group jackknife.")]
    interval_95: Annotated[tuple[float, float], about("Student's, groups less one.")]
    groups: int
    by: Annotated[str, about("What the groups of rows are of.")]
    exceeds: Annotated[bool, about("Whether it is noticeably wider than the interval for noise.")]


class WrittenHausmanTest(JsonObject, frozen=True, kw_only=True):
    """One estimate less another, one parameter."""

    difference: Annotated[float, about("Both less the bias of filter and noise where it is known.")]
    deviation: Annotated[float, about("HAC, of the difference.")]
    p_value: Annotated[float | None, about("Hausman, of this parameter.")]
    joint_p_value: Annotated[float | None, about("The same of all parameters at once.")]
    shift: Annotated[float, about("In deviations of the other estimate.")]


class WrittenMotionComparison(JsonObject, frozen=True, kw_only=True):
    """A measured velocity or acceleration beside the derivative of what is measured before it."""

    factor: Annotated[float | None, about("Of the measured one; null where nothing is alike.")]
    factor_deviation: float | None
    delay: Annotated[float | None, about("Of the measured one, samples.")]
    delay_deviation: float | None
    offset: Annotated[float | None, about("What is constant between the two, SI.")]
    offset_deviation: float | None
    size: Annotated[float, about("Root mean square of the derivative, SI.")]
    left_percent: Annotated[float, about("What remains of either beside the other.")]


class WrittenCheck(JsonObject, frozen=True, kw_only=True):
    """One check of the verdict."""

    name: str
    status: Literal["pass", "note", "fail", "not evaluated"]
    meaning: str
    figure: float | None
    threshold: float | None
    p_value: float | None
    source: Annotated[str, about("Where the threshold comes from.")]


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
