"""One of several records in a result."""

from collections.abc import Mapping
from typing import Annotated

from msgspec import UNSET, UnsetType

from .base import JsonObject, about
from .diagnosis import WrittenAlignment, WrittenCheck, WrittenLackOfFit, WrittenLawCheck
from .record import WrittenPrefilter, WrittenRecord
from .values import WrittenKnown


class WrittenApart(JsonObject, frozen=True, kw_only=True):
    """A record alone beside all of them, in the parameters of its own axis."""

    own: Annotated[Mapping[str, float], about("As the record alone has them, SI.")]
    common: Annotated[Mapping[str, float], about("As all records have them, SI.")]
    deviations: Annotated[Mapping[str, float], about("Of the difference, HAC.")]
    statistic: Annotated[float, about("Wald's, over its degrees of freedom.")]
    freedom: Annotated[tuple[float, float], about("Of F.")]
    p_value: Annotated[float, about("That chance alone makes as much, of one record.")]
    share_percent: Annotated[float, about("Force that the difference makes, of the record's.")]


class WrittenMember(JsonObject, frozen=True, kw_only=True):
    """One of several records, by the estimate that is judged."""

    name: Annotated[str, about("As the verdict names it.")]
    record: WrittenRecord
    prefilter: WrittenPrefilter
    known: Annotated[Mapping[str, WrittenKnown], about("What is known of it, SI, by name.")]
    rows: int
    weight: Annotated[float, about("Of its rows, by the inverse of its noise.")]
    noise: Annotated[float, about("Root mean square of its residuals.")]
    equation_error_percent: float
    simulation_error_percent: float | None
    apart: Annotated[
        WrittenApart | None, about("null where the record alone does not tell the parameters.")
    ]
    law_check: WrittenLawCheck
    alignment: WrittenAlignment
    verdict: Annotated[tuple[WrittenCheck, ...], about("The checks that are of one record.")]
    lack_of_fit: WrittenLackOfFit | UnsetType = UNSET
