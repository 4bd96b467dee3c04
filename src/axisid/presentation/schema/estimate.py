"""One method's estimate."""

from collections.abc import Mapping
from typing import Annotated, Literal

from msgspec import UNSET, UnsetType

from axisid.estimation.regression import Drawn, ResidualTests
from axisid.estimation.twins import Chain

from .values import (
    JsonObject,
    Matrix,
    WrittenDirectValue,
    WrittenPhysical,
    WrittenValue,
    about,
)


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
    residual_tests: ResidualTests
    remarks: tuple[str, ...]
    drawn: Annotated[Mapping[str, Drawn] | UnsetType | None, about("With draws=.")] = UNSET
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
