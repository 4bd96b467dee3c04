"""Products of errors so many samples apart, between masks too."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.support.arrays import Array

# of the errors, in pairs so far apart between masks: measured with half of the samples masked, at
# random or in blocks, 0.9 to 1.4 times the scatter is claimed
_MIN_PAIRS = 0.25

_LONGEST = 0.1  # s, of an autoregression
_FEWEST = 20  # orders that are tried, whatever the period
_ROWS_PER_ORDER = 10


@dataclass(frozen=True, slots=True)
class LagCovariances:
    """Covariances of errors of one output or several.

    Attributes
    ----------
    values : (p + 1, m, m) array
        Of ``e_t`` with ``e_(t - k)``, for k = 0, ..., p.
    samples : int
        Measured ones, from which they are found.
    """

    values: Array
    samples: int


def lag_covariances(
    pieces: Sequence[Array], period: float, counted: Sequence[NDArray[np.bool_]] | None
) -> LagCovariances:
    """Covariances up to the longest lag of an autoregression.

    Parameters
    ----------
    pieces : sequence of (n, m) array
        Errors of the outputs in stretches without gaps; none follows another.
    period : float
        s
    counted : sequence of (n,) array of bool, optional
        Which samples are measured; the errors of others are 0, and no pair with one counts.
    """
    rows = sum(map(len, pieces))
    used = rows if counted is None else int(sum(map(np.sum, counted)))
    outputs = pieces[0].shape[1]
    if not used:
        return LagCovariances(np.zeros((1, outputs, outputs)), 0)
    most = min(max(round(_LONGEST / period), _FEWEST), used // (_ROWS_PER_ORDER * outputs))
    products = _products(pieces, most)
    if used < rows and counted is not None:
        whole = _products([np.ones((len(e), 1)) for e in pieces], most)
        pairs = np.rint(_products([each[:, None].astype(float) for each in counted], most))
        few = np.flatnonzero(pairs < _MIN_PAIRS * used)
        told = slice(0, int(few[0]) if len(few) else None)
        products = products[told] * np.rint(whole[told]) / pairs[told]
        used = int(pairs[told].min())  # a criterion that reckons with all takes what chance made
    return LagCovariances(products / rows, used)


def _products(pieces: Sequence[Array], most: int) -> Array:
    """Sums of the products of values so many lags apart, (most + 1, m, m)."""
    from scipy.signal import correlate

    outputs = range(pieces[0].shape[1])
    products = np.zeros((most + 1, len(outputs), len(outputs)))
    for e in pieces:
        lags = min(most, len(e) - 1)
        for i in outputs:
            for j in outputs:
                found = correlate(e[:, i], e[:, j], method="fft")[len(e) - 1 : len(e) + lags]
                products[: lags + 1, i, j] += found
    return products
