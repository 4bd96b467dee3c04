"""How the size of an error counts: as its square, or for less where it is large."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from axisid.estimation.choices.outputs import HUBER, SOFT_L1, SQUARES
from axisid.estimation.thresholds import MEDIAN_OF_NORMAL
from axisid.support.arrays import Array

#: Takes squares of errors over the loss's scale, (n,), and gives the loss with its first two
#: derivatives, (3, n).
Loss = Callable[[Array], Array]


def _squares(z: Array) -> Array:
    return np.array([z, np.ones_like(z), np.zeros_like(z)])


def _soft_l1(z: Array) -> Array:
    root = np.sqrt(1 + z)
    return np.array([2 * (root - 1), 1 / root, -0.5 / root**3])


def _huber(z: Array) -> Array:
    beyond = z > 1
    root = np.sqrt(np.where(beyond, z, 1.0))
    return np.array(
        [
            np.where(beyond, 2 * root - 1, z),
            1 / root,
            np.where(beyond, -0.5 / root**3, 0.0),
        ]
    )


LOSSES: Mapping[str, Loss] = MappingProxyType({SQUARES: _squares, SOFT_L1: _soft_l1, HUBER: _huber})


def counting_for(loss: Loss, shares: Array) -> Loss:
    """The same loss of errors whose weights were multiplied by the roots of shares, (n,).

    An error is as large a one as it was, and counts by its share.
    """

    def shared(z: Array) -> Array:
        value, first, second = loss(z / shares)
        return np.array([shares * value, first, second / shares])

    return shared


def deviation_by_median(errors: Array) -> float:
    """Standard deviation of normal errors, from the median of their distances from the median."""
    return float(np.median(np.abs(errors - np.median(errors)))) / MEDIAN_OF_NORMAL.value
