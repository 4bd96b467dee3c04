"""Tests of the residuals."""

from typing import Annotated

from .base import JsonObject, about


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
