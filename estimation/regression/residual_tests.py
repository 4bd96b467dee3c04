"""Tests of an estimate's residuals, each with what a figure of it needs.

Likeness of neighbours (Durbin-Watson), shape (Jarque-Bera), what of the motion is left in them
(correlation with the instruments over lags), and their power density by Welch's method. RowTimes
are rows that follow each other in time; a row that is missing counts as one of zero in correlations
over a lag, as in [Parzen1963]_, which keeps their deviations from growing.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc, ndtr, ndtri

from axisid.estimation.signals import RowTimes
from axisid.estimation.thresholds import MAX_CHANCE_DEVIATION, MIN_SEGMENT_ROWS, SIGNIFICANCE_LEVEL
from axisid.support.arrays import Array, Exact, MaybeNan
from axisid.support.errors import Missing

from .coloured_errors import score_products

_QUANTILES = 99
# of the rows in stretches of a segment or more, from which there is a spectrum
_MIN_SEGMENTED_SHARE = 0.5
_SEGMENT = 256  # rows


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Autocorrelation(Exact):
    """Of the residuals, by lag.

    Attributes
    ----------
    values : (lags + 1,) array
        Of the residuals less their mean, from lag 0.
    bound_95 : float
        What a correlation of independent series stays below in 95 % of cases, ``1.96/sqrt(n)``.
    """

    values: Array
    bound_95: MaybeNan


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Normality(Exact):
    """Shape of the residuals against a normal distribution.

    Attributes
    ----------
    jarque_bera, p_value : float
        Chi-squared with 2 degrees of freedom.
    skewness, excess_kurtosis : float
        0 for normal residuals.
    normal_quantiles : (q,) array
        Of a standard normal distribution.
    residual_quantiles : (q,) array
        Standardised.
    """

    jarque_bera: MaybeNan
    p_value: MaybeNan
    skewness: MaybeNan
    excess_kurtosis: MaybeNan
    normal_quantiles: Array
    residual_quantiles: Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CrossCorrelation(Exact):
    """Of the residuals with each instrument or regressor column.

    Attributes
    ----------
    largest : float
        In deviations.
    limit_95 : float
        What that stays below in 95 % of cases, for as many values as there are (Bonferroni).
    p_value : float
        Of the largest, likewise.
    lags : tuple of int
    columns : tuple of (2 lags + 1,) array
        By instrument (or regressor column), then by lag: e[t + lag] z[t]; zero at lag 0 by
        construction.
    deviations : (k,) array
        Of each, for unrelated series of the same autocorrelations, by Bartlett's formula.
    """

    largest: MaybeNan
    limit_95: MaybeNan
    p_value: MaybeNan
    lags: tuple[int, ...]
    columns: tuple[Array, ...]
    deviations: Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ResidualTests(Exact):
    """Tests of the residuals with the data of their plots.

    Attributes
    ----------
    durbin_watson : float
        2 for independent neighbours, towards 0 for alike ones; not a number if no row follows
        another.
    autocorrelation : Autocorrelation
    normality : Normality
    cross_correlation : CrossCorrelation
    """

    durbin_watson: MaybeNan
    autocorrelation: Autocorrelation
    normality: Normality
    cross_correlation: CrossCorrelation


def residual_tests(
    residuals: Array, W: Array, lags: int | None = None, neighbours: RowTimes | None = None
) -> ResidualTests:
    """Test residuals for correlation and normality.

    Parameters
    ----------
    residuals : (n,) array
    W : (n, k) array
        Instruments, or the regressor of least squares.
    lags : int, optional
        Of the correlations; ``min(10 log10 n, n/5)`` by default.
    neighbours : RowTimes, optional
        Which rows follow each other in time; by default all do.
    """
    n = len(residuals)
    count = int(min(10 * np.log10(n), n / 5)) if lags is None else lags
    order = neighbours or RowTimes.consecutive(n)
    late, early = order.pairs(1)
    changes = residuals[late] - residuals[early]
    # Of as many as there are without a gap.
    squares = float(np.sum(changes**2)) * ((n - 1) / len(changes)) if len(changes) else np.nan
    durbin_watson = squares / float(residuals @ residuals)
    about = residuals - residuals.mean()
    every = np.column_stack([np.ones(n), about, residuals, W])
    products = score_products(every, order, count)
    counts = np.rint(products[:, 0, 0]).astype(np.int64)
    sums = products[:, 1, 1] / products[0, 1, 1]
    standardised = about / residuals.std()
    skewness = float(np.mean(standardised**3))
    kurtosis = float(np.mean(standardised**4)) - 3
    bera = n / 6 * (skewness**2 + kurtosis**2 / 4)
    sizes = np.sqrt(np.diagonal(products[0]))[2:]
    # From the residuals before the columns to those after them.
    both = np.concatenate([products[::-1, 3:, 2], products[1:, 2, 3:]])
    crossed = both / (sizes[1:] * sizes[0])
    own = np.diagonal(products[:, 3:, 3:], axis1=1, axis2=2)
    # Bartlett's formula, tapered over the lags there are; never below that of white residuals.
    # Pairs that are missing are in the columns' own sums; the residuals' are those of all pairs.
    correlations = sums * ((n - np.arange(count + 1)) / np.maximum(counts, 1))
    weights = 2 * (1 - np.arange(1, count + 1) / (count + 1)) * correlations[1:]
    variance = 1 + weights @ (own[1:] / own[0])
    deviations = np.asarray(np.sqrt(np.maximum(variance, 1.0) / n), dtype=float)
    largest = float(np.max(np.abs(crossed) / deviations))
    share = np.array([(i + 0.5) / _QUANTILES for i in range(_QUANTILES)])
    return ResidualTests(
        durbin_watson=durbin_watson,
        autocorrelation=Autocorrelation(
            values=sums, bound_95=MAX_CHANCE_DEVIATION.value / float(np.sqrt(n))
        ),
        normality=Normality(
            jarque_bera=bera,
            p_value=float(chdtrc(2, bera)),
            skewness=skewness,
            excess_kurtosis=kurtosis,
            normal_quantiles=np.asarray(ndtri(share), dtype=float),
            residual_quantiles=np.asarray(np.quantile(standardised, share), dtype=float),
        ),
        cross_correlation=CrossCorrelation(
            largest=largest,
            limit_95=float(-ndtri(SIGNIFICANCE_LEVEL.value / 2 / crossed.size)),
            p_value=min(1.0, 2 * crossed.size * float(ndtr(-largest))),
            lags=tuple(range(-count, count + 1)),
            columns=tuple(crossed.T),
            deviations=deviations,
        ),
    )


def power_density(
    values: Array, rate: float, neighbours: RowTimes
) -> tuple[Array, Array] | Missing:
    """Frequencies in Hz and the power density of values at each, (f,) or (f, k), but for the mean.

    Where rows are missing, segments are at most as long as the stretches that hold half of the
    rows; what is in shorter stretches is left out.

    Parameters
    ----------
    values : (n,) or (n, k) array
    rate : float
        Rows that follow each other in a second.
    neighbours : RowTimes
        Which of the rows do.
    """
    from scipy.signal import welch

    lengths = np.sort(neighbours.lengths)[::-1]
    enough = int(np.searchsorted(np.cumsum(lengths), _MIN_SEGMENTED_SHARE * len(values)))
    segment = min(_SEGMENT, int(lengths[enough]))
    if segment < (least := MIN_SEGMENT_ROWS.value):
        return Missing(f"half of the rows follow each other in less than {least} at a time")
    pieces = [piece for piece in neighbours.split(values) if len(piece) >= segment]
    spectra = [welch(piece, rate, nperseg=segment, axis=0) for piece in pieces]
    overlap = segment // 2
    averaged = [(len(piece) - overlap) // (segment - overlap) for piece in pieces]
    density = np.average([power for _, power in spectra], axis=0, weights=averaged)
    return spectra[0][0][1:], density[1:]
