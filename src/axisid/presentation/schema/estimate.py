"""One method's estimate."""

from collections.abc import Mapping
from typing import Annotated, Literal

from msgspec import UNSET, UnsetType

from axisid.estimation.twins import Chain

from .values import (
    JsonObject,
    Matrix,
    WrittenDirectValue,
    WrittenDrawn,
    WrittenPhysical,
    WrittenValue,
    about,
)


class WrittenAutocorrelation(JsonObject, frozen=True, kw_only=True):
    """Of the residuals, by lag."""

    values: Annotated[tuple[float | None, ...], about("From lag 0.")]
    bound_95: float | None


class WrittenNormality(JsonObject, frozen=True, kw_only=True):
    """Shape of the residuals against a normal distribution."""

    jarque_bera: float | None
    p_value: float | None
    skewness: float | None
    excess_kurtosis: float | None
    normal_quantiles: tuple[float | None, ...]
    residual_quantiles: Annotated[tuple[float | None, ...], about("Standardised.")]


class WrittenCrossCorrelation(JsonObject, frozen=True, kw_only=True):
    """Of the residuals with each instrument or regressor column."""

    largest: Annotated[float | None, about("In deviations.")]
    limit_95: float | None
    p_value: float | None
    lags: tuple[int, ...]
    columns: Annotated[
        tuple[tuple[float | None, ...], ...],
        about("By instrument (or regressor column), then by lag: e[t + lag] z[t]."),
    ]
    deviations: Annotated[tuple[float | None, ...], about("Of each, by Bartlett's formula.")]


class WrittenResidualTests(JsonObject, frozen=True, kw_only=True):
    """Tests of the residuals with the data of their plots."""

    durbin_watson: Annotated[float | None, about("2 for independent neighbours.")]
    autocorrelation: WrittenAutocorrelation
    normality: WrittenNormality
    cross_correlation: WrittenCrossCorrelation


class WrittenEstimate(JsonObject, frozen=True, kw_only=True):
    """One method's estimate."""

    method: Annotated[str, about("As identify takes it.")]
    parameters: Annotated[Mapping[str, WrittenValue], about("Physical, by name.")]
    theta_ddm: Annotated[Mapping[str, WrittenDirectValue] | None, about("Of the direct model.")]
    covariance: Annotated[Matrix, about("Of the physical parameters, for independent residuals.")]
    covariance_robust: Matrix
    covariance_hac: Matrix
    theta_ddm_covariance: Matrix | None
    theta_ddm_covariance_hac: Matrix | None
    correlation: Annotated[Matrix, about("Of the physical parameters, of the chosen covariance.")]
    covariance_names: Annotated[
        Mapping[str, str],
        about("What each covariance is, with lags and corrections."),
    ]
    chains: Annotated[
        tuple[Chain, ...] | UnsetType,
        about("The noise of each record, SI, as its twins have it; left out without twins."),
    ] = UNSET
    chosen_covariance: Annotated[
        str,
        about(
            "The covariance (hac, robust, iid or another) that interval_95, correlation, "
            "curvatures and draws are of."
        ),
    ]
    equation_error_percent: Annotated[
        float,
        about("100 ||y - X theta|| / ||y||; no quality of an instrumental estimate."),
    ]
    simulation_error_percent: Annotated[
        float | None,
        about("100 ||y - simulated|| / ||y||; null where the loop could not be simulated."),
    ]
    rows: int
    condition_number: Annotated[float, about("Of X, not scaled.")]
    iterations: Annotated[
        tuple[Mapping[str, float], ...],
        about("Physical parameters by iterate, SI; empty for least squares."),
    ]
    theta_ddm_iterations: Annotated[
        tuple[Mapping[str, float], ...] | None, about("The same of the direct model, SI.")
    ]
    iteration_simulation_errors_percent: tuple[float, ...]
    loss: Annotated[
        Literal["huber", "bisquare"] | UnsetType,
        about("How rows counted; left out where all do alike."),
    ] = UNSET
    light_rows: Annotated[
        int | UnsetType, about("Rows that counted for less than half, with such a loss.")
    ] = UNSET
    started: Annotated[
        Literal["least-squares", "nominal"] | UnsetType,
        about("Where the iteration started; left out for least squares."),
    ] = UNSET
    curvatures: Annotated[
        Mapping[str, float | None],
        about(
            "Second-order part of each physical deviation against the first; the delta method "
            "is enough up to 0.1."
        ),
    ]
    freedom: Annotated[
        Mapping[str, float] | UnsetType,
        about("Degrees of freedom, of Student's distribution, of each physical interval_95."),
    ] = UNSET
    residual_tests: WrittenResidualTests
    remarks: tuple[str, ...]
    drawn: Annotated[Mapping[str, WrittenDrawn] | UnsetType | None, about("With draws=.")] = UNSET
    physical: WrittenPhysical | UnsetType = UNSET
    covariances: Annotated[
        Mapping[str, Matrix] | UnsetType,
        about("Of the physical parameters, those that have no member of their own."),
    ] = UNSET
    theta_ddm_covariances: Annotated[
        Mapping[str, Matrix] | UnsetType,
        about("Of the direct model: the chosen one, where it has no member of its own."),
    ] = UNSET
    gain_relative_sd: Annotated[
        float, about("Of the drive gain; 0 where it is exact or the force was measured.")
    ]
    gain_slopes: Annotated[
        Mapping[str, float] | None,
        about(
            "Of the physical parameters by the logarithm of the drive gain; null for an exact one."
        ),
    ]
    theta_ddm_gain_slopes: Annotated[
        Mapping[str, float] | None, about("The same of the direct model.")
    ]
