"""How errors are coloured, whether of one output or of several."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from axisid.support.arrays import Array

from .autoregression import Autoregression, by_durbin
from .lag_products import lag_covariances
from .vector_autoregression import VectorAutoregression, by_whittle

#: An autoregression, of one output or of several.
Colour = Autoregression | VectorAutoregression


def autoregression_of(
    pieces: Sequence[Array],
    period: float,
    counted: Sequence[NDArray[np.bool_]] | None = None,
    outputs: int = 1,
) -> Colour:
    """The autoregression of errors by Yule and Walker, its order by Akaike's criterion.

    Parameters
    ----------
    pieces : sequence of (n,) array
        Stretches without gaps; none follows another.
    period : float
        s
    counted : sequence of (n,) array of bool, optional
        Which errors are measured; the others are 0, and no pair with one of them counts.
    outputs : int
        Whose rows of a sample are neighbours.
    """
    there = None if counted is None else [each[::outputs] for each in counted]
    found = lag_covariances([each.reshape(-1, outputs) for each in pieces], period, there)
    if outputs == 1:
        return by_durbin(found.values[:, 0, 0], found.samples)
    return by_whittle(found.values, found.samples)
