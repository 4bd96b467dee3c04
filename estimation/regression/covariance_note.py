"""Notes on covariances: estimator, lags, corrections, and simulated replicas."""

from dataclasses import dataclass
from typing import Literal

CovarianceKind = Literal["published", "classical", "robust", "hac", "ar1", "other"]
LagRule = Literal["none", "plug-in", "plug-in, capped", "given"]


@dataclass(frozen=True, slots=True, kw_only=True)
class CovarianceNote:
    """Note on the estimator of a covariance.

    Attributes
    ----------
    kind : {"published", "classical", "robust", "hac", "ar1", "other"}
        Kind of the estimator, in this order: for independent residuals of equal variance, which is
        estimated with ``n - 1``, or with ``n - k``; robust to heteroscedasticity; consistent for
        heteroscedasticity and autocorrelation; for AR(1) residuals; another estimator, which
        `label` names.
    degrees : int or None
        ``n - 1`` of a published covariance; None for other kinds.
    lags : int or None
        Number of lags of a HAC covariance; None for other kinds.
    lag_rule : {"none", "plug-in", "plug-in, capped", "given"}
        Rule for the number of lags of a HAC covariance.
    is_prewhitened : bool
        True if the scores were prewhitened by an AR(1).
    is_corrected : bool
        True if the matrix was multiplied by ``n/(n - k)``.
    is_at_least_ar1 : bool
        True if a standard error was raised to that of AR(1) residuals, as few scores are
        independent.
    replicas : int
        Number of simulated replicas of the records whose scatter scales the covariance; 0 for none.
    noise : tuple of str
        Sentence on the noise of each record in its replicas; empty without replicas.
    is_silent : bool
        True if replicas were requested, but the loops show no noise.
    no_replicas : str
        Reason why requested replicas are missing; empty if none were requested, or if there are
        replicas.
    label : str
        Name of an estimator of the kind ``other``.
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
