"""Tests of an estimate's residuals, with what their figures need.

Likeness of neighbours (Durbin-Watson), autocorrelation, and power density by Welch's method. Rows
are neighbours that follow each other in time; a row that is missing counts as one of zero in
correlations over a lag, as in [Parzen1963]_, which keeps their deviations from growing.
"""

from dataclasses import dataclass

import numpy as np

from axisid.estimation.signals import RowTimes
from axisid.estimation.thresholds import MAX_CHANCE_DEVIATION, MIN_SEGMENT_ROWS
from axisid.support.arrays import Array, Exact, MaybeNan
from axisid.support.errors import Missing

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
class ResidualTests(Exact):
    """Tests of the residuals with the data of their plots.

    Attributes
    ----------
    durbin_watson : float
        2 for independent neighbours, towards 0 for alike ones; not a number if no row follows
        another.
    autocorrelation : Autocorrelation
    """

    durbin_watson: MaybeNan
    autocorrelation: Autocorrelation


def residual_tests(
    residuals: Array, lags: int | None = None, neighbours: RowTimes | None = None
) -> ResidualTests:
    """Test whether residuals are like their neighbours.

    Parameters
    ----------
    residuals : (n,) array
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
