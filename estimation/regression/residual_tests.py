"""Tests of residuals: Durbin-Watson, autocorrelation, and power density by Welch's method.

Neighbours are rows that follow each other in time. A missing row counts as zero in the
autocorrelation, as in [Parzen1963]_, which keeps its standard error from growing.
"""

from dataclasses import dataclass

import numpy as np

from axisid.estimation.signals import RowTimes
from axisid.estimation.thresholds import MAX_CHANCE_DEVIATION, MIN_SEGMENT_ROWS
from axisid.support.arrays import Array, Exact, MaybeNan
from axisid.support.missing import Missing

# share of the rows that must be in stretches without gaps that are as long as a segment
_MIN_SEGMENTED_SHARE = 0.5
_SEGMENT = 256  # rows of a segment of Welch's method, at most


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Autocorrelation(Exact):
    """Autocorrelation of the residuals by lag.

    Attributes
    ----------
    values : (lags + 1,) array
        ``sum e_t e_(t-l) / sum e_t^2`` of the residuals minus their mean, from lag 0.
    bound_95 : float
        Bound that independent residuals stay below in 95 % of the cases, ``1.96/sqrt(n)``.
    """

    values: Array
    bound_95: MaybeNan


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ResidualTests(Exact):
    """Tests of the residuals with the data of their plots.

    Attributes
    ----------
    durbin_watson : float
        ``sum (e_t - e_(t-1))^2 / sum e_t^2``: 2 for independent neighbours, near 0 for strongly
        correlated ones; not a number if no row follows another.
    autocorrelation : Autocorrelation
        Autocorrelation of the residuals by lag.
    """

    durbin_watson: MaybeNan
    autocorrelation: Autocorrelation


def residual_tests(
    residuals: Array, lags: int | None = None, neighbours: RowTimes | None = None
) -> ResidualTests:
    """Return the Durbin-Watson statistic and the autocorrelation of residuals.

    Parameters
    ----------
    residuals : (n,) array
        Residuals of the rows.
    lags : int, optional
        Largest lag of the autocorrelation; ``min(10 log10 n, n/5)`` by default.
    neighbours : RowTimes, optional
        Times of the rows; by default no row is missing.
    """
    n = len(residuals)
    count = int(min(10 * np.log10(n), n / 5)) if lags is None else lags
    order = neighbours or RowTimes.consecutive(n)
    late, early = order.pairs(1)
    changes = residuals[late] - residuals[early]
    # The sum over pairs of neighbours, scaled to the n - 1 pairs of rows without gaps.
    squares = np.nan
    if len(changes):
        squares = float(np.sum(changes**2)) * ((n - 1) / len(changes))
    products = order.autocovariances((residuals - residuals.mean())[:, None], count)[:, 0, 0]
    return ResidualTests(
        durbin_watson=squares / float(residuals @ residuals),
        autocorrelation=Autocorrelation(
            values=products / products[0], bound_95=MAX_CHANCE_DEVIATION.value / float(np.sqrt(n))
        ),
    )


def power_density(
    values: Array, rate: float, neighbours: RowTimes
) -> tuple[Array, Array] | Missing:
    """Return frequencies, Hz, (f,), and the power density by Welch's method, (f,) or (f, k).

    Missing if the stretches without gaps are too short.

    The zero frequency is left out. A segment has 256 rows, or fewer where rows are missing: half of
    the rows or more must be in stretches without gaps as long as a segment. Shorter stretches are
    not used. The densities of the stretches are averaged by their number of segments.

    Parameters
    ----------
    values : (n,) or (n, k) array
        Values of the rows.
    rate : float
        Row frequency, Hz.
    neighbours : RowTimes
        Times of the rows.
    """
    from scipy.signal import welch

    # The longest stretches, until they have half of the rows; the last of them is the shortest.
    lengths = np.sort(neighbours.lengths)[::-1]
    shortest = int(np.searchsorted(np.cumsum(lengths), _MIN_SEGMENTED_SHARE * len(values)))
    segment, least = min(_SEGMENT, int(lengths[shortest])), MIN_SEGMENT_ROWS.value
    if segment < least:
        return Missing(
            f"more than half of the rows are in stretches of fewer than {least} rows without a gap"
        )
    pieces = [piece for piece in neighbours.split(values) if len(piece) >= segment]
    spectra = [welch(piece, rate, nperseg=segment, axis=0) for piece in pieces]
    overlap = segment // 2
    segments = [(len(piece) - overlap) // (segment - overlap) for piece in pieces]
    density = np.average([power for _, power in spectra], axis=0, weights=segments)
    frequencies = spectra[0][0]
    return frequencies[1:], density[1:]
