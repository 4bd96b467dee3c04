"""Notes on covariances: estimator, lags, corrections, and simulated replicas."""

from dataclasses import dataclass
from typing import Literal

CovarianceKind = Literal["published", "classical", "robust", "hac", "ar1", "other"]
LagRule = Literal["none", "plug-in", "plug-in, capped", "given"]


@dataclass(frozen=True, slots=True, kw_only=True)
class CovarianceNote:
    """Note on a covariance: how it was estimated.

    Attributes
    ----------
    kind : {"published", "classical", "robust", "hac", "ar1", "other"}
        Independent residuals with the variance by ``n - 1``, and by ``n - k``; heteroscedasticity
        robust; heteroscedasticity and autocorrelation consistent; AR(1) residuals; as `label` says.
    degrees : int or None
        ``n - 1`` of a published one.
    lags : int or None
        Of a HAC covariance.
    lag_rule : {"none", "plug-in", "plug-in, capped", "given"}
    is_prewhitened : bool
        Whether scores were whitened by an AR(1).
    is_corrected : bool
        Whether it is times ``n/(n - k)``.
    is_at_least_ar1 : bool
        Whether a deviation was raised to that of AR(1) residuals, as few scores are independent.
    replicas : int
        Simulated replicas of the records whose scatter scales it; 0 for none.
    noise : tuple of str
        Noise of each record in its replicas.
    is_silent : bool
        Whether replicas were asked for, but the loops show no noise.
    no_replicas : str
        Why there are no replicas, where they were asked for.
    label : str
        Its name, where a file has no more of it.
    """

    kind: CovarianceKind
    degrees: int | None = None
    lags: int | None = None
    lag_rule: LagRule = "none"
    is_prewhitened: bool = False
    is_corrected: bool = False
    is_at_least_ar1: bool = False
    replicas: int = 0
    noise: tuple[str, ...] = ()
    is_silent: bool = False
    no_replicas: str = ""
    label: str = ""
