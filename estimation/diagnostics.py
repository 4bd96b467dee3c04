"""Statistics that say whether an estimate can be believed.

Instruments: first-stage F and Shea's partial R squared. Residuals: Durbin-Watson, Ljung-Box,
Jarque-Bera, runs, correlation with the instruments. Least squares against instruments:
Durbin-Wu-Hausman in regression form.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, fdtrc, ndtr, stdtr

from .arrays import Array
from .covariance import Covariance
from .linear import factor, least_squares


@dataclass(frozen=True, slots=True, kw_only=True)
class Strength:
    """How strongly the instruments move one column of the regressor."""

    r_squared: float
    shea: float
    f: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ResidualTests:
    """Tests of the residuals' independence and shape, with what a figure of each needs.

    Attributes
    ----------
    durbin_watson : float
        Near 2 for uncorrelated neighbours, towards 0 for alike ones.
    ljung_box, ljung_box_p : float
        Over `lags`, chi-squared.
    jarque_bera, jarque_bera_p : float
        Normality, chi-squared with 2 degrees of freedom.
    runs_z, runs_p : float
        Wald-Wolfowitz runs about zero, normal.
    autocorrelation : (lags + 1,) array
    instrument_correlation : (k,) array
        Correlation of the residuals with each instrument (or regressor).
    bound : float
        What a correlation of independent series stays below in 95 % of cases, ``1.96/sqrt(n)``.
    """

    durbin_watson: float
    ljung_box: float
    ljung_box_p: float
    jarque_bera: float
    jarque_bera_p: float
    runs_z: float
    runs_p: float
    autocorrelation: Array
    instrument_correlation: Array
    bound: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Endogeneity:
    """Durbin-Wu-Hausman in regression form.

    Attributes
    ----------
    statistic, p_value : float
        Wald statistic over its degrees of freedom, F distributed; never negative.
    by_parameter : tuple of float
        p-value of each column's residual from its instruments; NaN where instruments give the
        column exactly.
    """

    statistic: float
    p_value: float
    by_parameter: tuple[float, ...]


def instrument_strength(X: Array, Z: Array) -> tuple[Strength, ...]:
    """First stage of every column, as in linearmodels' diagnostics.

    Parameters
    ----------
    X, Z : (n, k) arrays
        Regressor and instruments, both of full column rank.
    """
    n, k = X.shape
    basis = np.linalg.qr(Z)[0]
    fitted = basis @ (basis.T @ X)
    scale = np.linalg.norm(X, axis=0)
    plain = np.diag(np.linalg.inv((X / scale).T @ (X / scale)))
    projected = np.diag(np.linalg.inv((fitted / scale).T @ (fitted / scale)))
    explained, left = np.sum(fitted**2, axis=0), np.sum((X - fitted) ** 2, axis=0)
    strengths = []
    for j in range(k):
        f = np.inf if left[j] == 0 else explained[j] / k / (left[j] / (n - k))
        strengths.append(
            Strength(
                r_squared=float(explained[j] / (explained[j] + left[j])),
                shea=float(plain[j] / projected[j]),
                f=float(f),
            )
        )
    return tuple(strengths)


def endogeneity(y: Array, X: Array, Z: Array, covariance: Covariance) -> Endogeneity:
    """Test whether the regressor's residuals from the instruments help to explain y.

    Parameters
    ----------
    y : (n,) array
    X, Z : (n, k) arrays
    covariance : Covariance
        Of the augmented regression.
    """
    k = X.shape[1]
    basis = np.linalg.qr(Z)[0]
    unexplained = X - basis @ (basis.T @ X)
    noisy = np.linalg.norm(unexplained, axis=0) > 1e-9 * np.linalg.norm(X, axis=0)
    if not np.any(noisy):
        return Endogeneity(statistic=0.0, p_value=1.0, by_parameter=(np.nan,) * k)
    augmented = np.column_stack([X, unexplained[:, noisy]])
    solution = least_squares(y, factor(augmented, [str(i) for i in range(augmented.shape[1])]))
    extra, block = solution.theta[k:], covariance.matrix(solution)[k:, k:]
    tested, dof = len(extra), len(y) - augmented.shape[1]
    wald = float(extra @ np.linalg.solve(block, extra)) / tested
    single = 2 * stdtr(dof, -np.abs(extra) / np.sqrt(np.diag(block)))
    by_parameter = np.full(k, np.nan)
    by_parameter[noisy] = single
    return Endogeneity(
        statistic=wald,
        p_value=float(fdtrc(tested, dof, wald)),
        by_parameter=tuple(map(float, by_parameter)),
    )


def residual_tests(residuals: Array, W: Array, lags: int | None = None) -> ResidualTests:
    """Test residuals for correlation, normality and sign changes.

    Parameters
    ----------
    residuals : (n,) array
    W : (n, k) array
        Instruments, or the regressor of least squares.
    lags : int, optional
        Of the autocorrelation; ``min(10 log10 n, n/5)`` by default.
    """
    n = len(residuals)
    count = int(min(10 * np.log10(n), n / 5)) if lags is None else lags
    power = float(residuals @ residuals)
    correlations = np.array(
        [float(residuals[lag:] @ residuals[: n - lag]) / power for lag in range(count + 1)]
    )
    box = n * (n + 2) * float(np.sum(correlations[1:] ** 2 / (n - np.arange(1, count + 1))))
    centred = residuals - residuals.mean()
    variance = float(np.mean(centred**2))
    skew = float(np.mean(centred**3)) / variance**1.5
    kurtosis = float(np.mean(centred**4)) / variance**2
    bera = n / 6 * (skew**2 + (kurtosis - 3) ** 2 / 4)
    z = _runs(residuals > 0)
    norms = np.linalg.norm(W, axis=0) * np.sqrt(power)
    return ResidualTests(
        durbin_watson=float(np.sum(np.diff(residuals) ** 2)) / power,
        ljung_box=box,
        ljung_box_p=float(chdtrc(count, box)),
        jarque_bera=bera,
        jarque_bera_p=float(chdtrc(2, bera)),
        runs_z=z,
        runs_p=float(2 * ndtr(-abs(z))),
        autocorrelation=correlations,
        instrument_correlation=np.asarray(W.T @ residuals / norms, dtype=float),
        bound=1.96 / float(np.sqrt(n)),
    )


def _runs(positive: NDArray[np.bool_]) -> float:
    """Standardised number of runs of one sign."""
    n = len(positive)
    above = int(positive.sum())
    below = n - above
    if not above or not below:
        return -np.inf
    runs = 1 + int(np.sum(positive[1:] != positive[:-1]))
    mean = 2 * above * below / n + 1
    variance = (mean - 1) * (mean - 2) / (n - 1)
    return float((runs - mean) / np.sqrt(variance))
