"""What all classes of documents have in common, and values with their uncertainty."""

from collections.abc import Mapping
from typing import Annotated, Literal, TypeAlias

from msgspec import UNSET, Meta, Struct, UnsetType

Matrix: TypeAlias = tuple[tuple[float, ...], ...]


class JsonObject(Struct, frozen=True, kw_only=True):
    """One object of a document; its members are written in the order of the fields."""


def about(text: str) -> Meta:
    """A field's description in the schema."""
    return Meta(description=text)


class WrittenResult(JsonObject, frozen=True, kw_only=True):
    """A result of any kind, and what it is worth."""

    belief: Annotated[
        Literal["believed", "with care", "not believed"] | UnsetType,
        about("How far the numbers can be believed; left out in files of earlier versions."),
    ] = UNSET


class WrittenValue(JsonObject, frozen=True, kw_only=True):
    """A number with unit, deviations and interval."""

    value: Annotated[float, about("In `unit`.")]
    unit: Annotated[str, about("Coherent SI.")]
    sd: Annotated[
        float,
        about("Standard deviation for independent residuals, as in the published tables."),
    ]
    relative_sd_percent: Annotated[float | None, about("100 sd / |value|; null for a value of 0.")]
    sd_robust: Annotated[float, about("For residuals of any variance.")]
    sd_hac: Annotated[float, about("For autocorrelated residuals too.")]
    interval_95: Annotated[
        tuple[float, float],
        about(
            "About the value less filter_bias, from the chosen covariance and Student's "
            "distribution."
        ),
    ]
    sd_gain: Annotated[
        float,
        about("What the drive gain's declared deviation adds, in no other figure."),
    ]
    filter_bias: Annotated[
        float | None,
        about(
            "What filter and noise move the value by, as twins of the record tell; the value "
            "contains it, the interval does not; null without twins."
        ),
    ]
    deviations: Annotated[
        Mapping[str, float] | UnsetType,
        about("Under covariances that have no member of their own."),
    ] = UNSET


class WrittenDirectValue(WrittenValue, frozen=True, kw_only=True):
    """A parameter of the direct model."""

    expression: Annotated[str, about("In physical parameters.")]


class WrittenKnown(JsonObject, frozen=True, kw_only=True):
    """A parameter that is declared as known."""

    value: float
    sd: Annotated[float, about("0 for an exact value.")]


class WrittenHeld(JsonObject, frozen=True, kw_only=True):
    """A parameter that is held at a declared bound."""

    unit: str
    bound: float
    free: Annotated[float, about("Without the bound, less its bias if it is known.")]
    deviation: Annotated[float, about("Of `free`, by the chosen covariance.")]
    interval_95: Annotated[tuple[float, float], about("To one side of the bound.")]


class WrittenPhysical(JsonObject, frozen=True, kw_only=True):
    """Declared parameters from the base parameters and from what is declared as known.

    Absent where the estimate is of the declared parameters and none is known.
    """

    parameters: Annotated[Mapping[str, WrittenValue], about("Those that follow, by name.")]
    covariance_hac: Annotated[Matrix, about("Of these, in their order.")]
    base: Annotated[
        Mapping[str, str],
        about("Base parameters that are no declared ones, in declared ones."),
    ]
    fixed: Annotated[Mapping[str, WrittenKnown], about("What is declared as known, by name.")]
    unsettled: Annotated[
        tuple[str, ...],
        about("Which parameters do not follow, and what would have to be known."),
    ]
    statistic: Annotated[
        float,
        about("Squared distance of what was fixed from the record in deviations, Hotelling's."),
    ]
    dof: Annotated[int, about("Its degrees of freedom; 0 where nothing can contradict.")]
    p_value: float | None
    remarks: tuple[str, ...]
    covariances: Annotated[
        Mapping[str, Matrix] | UnsetType,
        about("Of `parameters`: the chosen one, where it has no member of its own."),
    ] = UNSET
