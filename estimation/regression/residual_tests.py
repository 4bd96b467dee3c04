"""Tests of an estimate's residuals, each with what a figure of it needs.

Independence (Durbin-Watson, Ljung-Box, runs of one sign), shape (Jarque-Bera), and what of the
motion is left in them (correlation with the instruments over lags).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, ndtr, ndtri

from axisid.support.arrays import Array

_QUANTILES = 99
_SIGNIFICANT = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class ResidualTests:
    """What the residuals look like.

    Attributes
    ----------
    durbin_watson : float
        Near 2 for uncorrelated neighbours, towards 0 for alike ones.
    ljung_box, ljung_box_p : float
        Over the lags of `autocorrelation`, chi-squared.
    jarque_bera, jarque_bera_p : float
        Normality, chi-squared with 2 degrees of freedom.
    skewness, excess_kurtosis : float
        0 for normal residuals.
    runs_z, runs_p : float
        Wald-Wolfowitz runs about zero, normal; negative for fewer runs than chance has.
    autocorrelation : (lags + 1,) array
        From lag 0.
    bound : float
        What a correlation of independent series stays below in 95 % of cases, ``1.96/sqrt(n)``.
    cross_correlation : (2 lags + 1, k) array
        Of the residuals with each instrument (or regressor), ``e[t + lag] z[t]``, from ``-lags``.
        Zero at lag 0 by construction.
    cross_deviations : (k,) array
        Standard deviations of its columns for unrelated series of the same autocorrelations
        (Bartlett's formula).
    cross_z, cross_limit, cross_p : float
        Its largest value in deviations, what that stays below in 95 % of cases, and its p-value,
        both for as many values as there are (Bonferroni).
    normal_quantiles, residual_quantiles : (q,) arrays
        Of a standard normal distribution and of the standardised residuals.
    run_lengths : (r,) array of int
        How many runs have 1, 2, ... r rows.
    """

    durbin_watson: float
    ljung_box: float
    ljung_box_p: float
    jarque_bera: float
    jarque_bera_p: float
    skewness: float
    excess_kurtosis: float
    runs_z: float
    runs_p: float
    autocorrelation: Array
    bound: float
    cross_correlation: Array
    cross_deviations: Array
    cross_z: float
    cross_limit: float
    cross_p: float
    normal_quantiles: Array
    residual_quantiles: Array
    run_lengths: NDArray[np.int64]


def residual_tests(residuals: Array, W: Array, lags: int | None = None) -> ResidualTests:
    """Test residuals for correlation, normality and sign changes.

    Parameters
    ----------
    residuals : (n,) array
    W : (n, k) array
        Instruments, or the regressor of least squares.
    lags : int, optional
        Of the correlations; ``min(10 log10 n, n/5)`` by default.
    """
    n = len(residuals)
    count = int(min(10 * np.log10(n), n / 5)) if lags is None else lags
    power = float(residuals @ residuals)
    correlations = np.array(
        [float(residuals[lag:] @ residuals[: n - lag]) / power for lag in range(count + 1)]
    )
    box = n * (n + 2) * float(np.sum(correlations[1:] ** 2 / (n - np.arange(1, count + 1))))
    standardised = (residuals - residuals.mean()) / residuals.std()
    skewness = float(np.mean(standardised**3))
    kurtosis = float(np.mean(standardised**4)) - 3
    bera = n / 6 * (skewness**2 + kurtosis**2 / 4)
    lengths = _run_lengths(residuals > 0)
    z = _runs_z(residuals > 0, len(lengths))
    crossed = _cross_correlation(residuals, W, count)
    deviations = _unrelated_deviations(correlations, W)
    largest = float(np.max(np.abs(crossed) / deviations))
    share = np.array([(i + 0.5) / _QUANTILES for i in range(_QUANTILES)])
    return ResidualTests(
        durbin_watson=float(np.sum(np.diff(residuals) ** 2)) / power,
        ljung_box=box,
        ljung_box_p=float(chdtrc(count, box)),
        jarque_bera=bera,
        jarque_bera_p=float(chdtrc(2, bera)),
        skewness=skewness,
        excess_kurtosis=kurtosis,
        runs_z=z,
        runs_p=float(2 * ndtr(-abs(z))),
        autocorrelation=correlations,
        bound=1.96 / float(np.sqrt(n)),
        cross_correlation=crossed,
        cross_deviations=deviations,
        cross_z=largest,
        cross_limit=float(-ndtri(_SIGNIFICANT / 2 / crossed.size)),
        cross_p=min(1.0, 2 * crossed.size * float(ndtr(-largest))),
        normal_quantiles=np.asarray(ndtri(share), dtype=float),
        residual_quantiles=np.asarray(np.quantile(standardised, share), dtype=float),
        run_lengths=np.bincount(lengths)[1:],
    )


def _cross_correlation(residuals: Array, W: Array, lags: int) -> Array:
    n = len(residuals)
    norms = np.linalg.norm(W, axis=0) * np.linalg.norm(residuals)
    rows = []
    for lag in range(-lags, lags + 1):
        late, early = max(lag, 0), max(-lag, 0)
        rows.append(W[early : n - late].T @ residuals[late : n - early])
    return np.asarray(np.array(rows) / norms, dtype=float)


def _unrelated_deviations(correlations: Array, W: Array) -> Array:
    """Bartlett's formula, tapered over the lags there are; never below that of white residuals."""
    n, lags = len(W), len(correlations) - 1
    power = np.sum(W**2, axis=0)
    variance = np.ones(W.shape[1])
    for lag in range(1, lags + 1):
        own = np.sum(W[lag:] * W[: n - lag], axis=0) / power
        variance = variance + 2 * (1 - lag / (lags + 1)) * correlations[lag] * own
    return np.asarray(np.sqrt(np.maximum(variance, 1.0) / n), dtype=float)


def _run_lengths(positive: NDArray[np.bool_]) -> NDArray[np.int64]:
    changes = np.flatnonzero(positive[1:] != positive[:-1]) + 1
    return np.diff(np.concatenate([[0], changes, [len(positive)]]))


def _runs_z(positive: NDArray[np.bool_], runs: int) -> float:
    """Standardised number of runs of one sign."""
    n, above = len(positive), int(positive.sum())
    below = n - above
    if not above or not below:
        return -np.inf
    mean = 2 * above * below / n + 1
    variance = (mean - 1) * (mean - 2) / (n - 1)
    return float((runs - mean) / np.sqrt(variance))
