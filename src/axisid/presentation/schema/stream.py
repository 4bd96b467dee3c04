"""An estimate of a log that was read in blocks."""

from collections.abc import Mapping
from typing import Annotated

from msgspec import UNSET, UnsetType

from .base import JsonObject, about
from .record import WrittenPrefilter, WrittenStreamRecord
from .values import WrittenValue


class WrittenStream(
    JsonObject, frozen=True, kw_only=True, tag_field="schema", tag="axisid.stream/1"
):
    """Least squares on a log that was read in blocks."""

    axis: str
    signature: Annotated[str, about("Of the generated code.")]
    left_out: Annotated[
        Mapping[str, float] | UnsetType,
        about("What stands for the parameters that were left out, SI, by name."),
    ] = UNSET
    record: Annotated[WrittenStreamRecord, about("Where the data come from.")]
    prefilter: WrittenPrefilter
    parameters: Annotated[Mapping[str, WrittenValue], about("By name.")]
    beyond_bounds: Annotated[
        str | None,
        about("Which parameters are outside their declared bounds; null for none."),
    ]
    time_base: Annotated[
        str | None,
        about("What speaks against the log's sampling period; null for nothing."),
    ]
    rows: Annotated[int, about("Of the regression.")]
    lags: Annotated[int, about("Of the HAC covariance.")]
    equation_error_percent: float
    condition_number: Annotated[float | None, about("Of the regressor.")]
