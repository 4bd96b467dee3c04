"""Where a motion turns or rests: there the low-pass rounds what friction does at once."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.thresholds import REST_SPEED
from axisid.support.arrays import Array


def rest_below(velocities: Iterable[Array], beside: float = 0.0) -> float:
    """Speed below which an axis rests, from the stretches of its filtered velocity.

    `beside` is the largest speed of other records of the machine: what noise makes of a rest is
    the same in all of them.
    """
    fastest = max((float(np.abs(v).max()) for v in velocities if len(v)), default=0.0)
    return REST_SPEED.value * max(fastest, beside)


def near_turns(velocity: Array, reach: int, rest: float) -> NDArray[np.bool_]:
    """Which samples of a stretch are near a change of direction or a rest, (N,).

    Parameters
    ----------
    velocity : (N,) array
        Filtered.
    reach : int
        Samples to both sides that count as near.
    rest : float
        Speed below which the axis rests.
    """
    from scipy.ndimage import maximum_filter1d

    direction = np.sign(velocity) * (np.abs(velocity) > rest)
    turns = direction == 0
    turns[1:] |= direction[1:] != direction[:-1]
    return np.asarray(maximum_filter1d(turns.astype(np.int8), 2 * reach + 1), dtype=bool)
