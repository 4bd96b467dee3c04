"""Power density of rows, by Welch's method over rows that follow each other."""

import numpy as np

from axisid.estimation.signals import Neighbours
from axisid.estimation.thresholds import MIN_SEGMENT_ROWS
from axisid.support.arrays import Array
from axisid.support.missing import Missing

# of the rows in stretches of a segment or more, from which there is a spectrum
_MIN_SEGMENTED_SHARE = 0.5

_SEGMENT = 256  # rows


def power_density(
    values: Array, rate: float, neighbours: Neighbours
) -> tuple[Array, Array] | Missing:
    """Frequencies in Hz and the power density of values at each, (f,) or (f, k), but for the mean.

    Where rows are missing, segments are at most as long as the stretches that hold half of the
    rows; what is in shorter stretches is left out.

    Parameters
    ----------
    values : (n,) or (n, k) array
    rate : float
        Rows that follow each other in a second.
    neighbours : Neighbours
        Which of the rows do.
    """
    from scipy.signal import welch

    lengths = np.sort(neighbours.lengths)[::-1]
    enough = int(np.searchsorted(np.cumsum(lengths), _MIN_SEGMENTED_SHARE * len(values)))
    segment = min(_SEGMENT, int(lengths[enough]))
    if segment < (least := MIN_SEGMENT_ROWS.value):
        return Missing(f"half of the rows follow each other in less than {least} at a time")
    powers, weights = [], []
    for piece in neighbours.split(values):
        if len(piece) < segment:
            continue
        frequencies, power = welch(piece, rate, nperseg=segment, axis=0)
        powers.append(power)
        overlap = segment // 2
        weights.append((len(piece) - overlap) // (segment - overlap))  # segments averaged
    return frequencies[1:], np.average(powers, axis=0, weights=weights)[1:]
