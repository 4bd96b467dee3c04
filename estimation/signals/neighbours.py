"""Which rows follow each other in time.

Rows are missing where samples are masked or left out, between segments and between records. What
is said of rows a lag apart, a covariance or a run of one sign, is said of those that are, not of
those that stand a lag apart in an array.

References
----------
[Parzen1963]_ for correlations of a series with missing values.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from axisid.support.arrays import Array

Index = slice | NDArray[np.intp]

_APART = 1 << 40  # rows, more than any lag, however often pieces are joined


@dataclass(frozen=True, eq=False)
class Neighbours:
    """Places of rows on a grid of one row each; rows of adjacent places are neighbours.

    Attributes
    ----------
    places : (n,) array of int
        Strictly increasing. Rows of two segments, or of two records, are further apart than any
        lag.
    """

    places: NDArray[np.int64]

    @classmethod
    def consecutive(cls, rows: int) -> "Neighbours":
        """Rows of which none is missing."""
        return cls(np.arange(rows, dtype=np.int64))

    @classmethod
    def of(cls, samples: NDArray[np.int64], step: int) -> "Neighbours":
        """Rows of which each is of a sample, and of which one in so many samples is one."""
        return cls(samples // step)

    @classmethod
    def joined(cls, pieces: Sequence["Neighbours"]) -> "Neighbours":
        """Pieces one after the other, none of whose rows is a neighbour of another piece's."""
        if len(pieces) == 1:
            return pieces[0]
        places, following = [], 0
        for piece in (piece for piece in pieces if len(piece)):
            places.append(piece.places - piece.places[0] + following)
            following = int(places[-1][-1]) + _APART
        return cls(np.concatenate(places) if places else np.empty(0, dtype=np.int64))

    def __len__(self) -> int:
        return len(self.places)

    def __getitem__(self, rows: Index) -> "Neighbours":
        return Neighbours(self.places[rows])

    @cached_property
    def whole(self) -> bool:
        """Whether no row is missing between the first and the last."""
        return not len(self) or int(self.places[-1] - self.places[0]) == len(self) - 1

    @cached_property
    def breaks(self) -> NDArray[np.intp]:
        """Rows that do not follow the row before them; the first of all is none."""
        return np.flatnonzero(np.diff(self.places) > 1) + 1

    @property
    def lengths(self) -> NDArray[np.int64]:
        """How many rows each stretch of rows that follow each other has."""
        return np.diff(np.concatenate([[0], self.breaks, [len(self)]]))

    def split(self, values: Array) -> list[Array]:
        """Values, (n,) or (n, k), in stretches of rows that follow each other."""
        return list(np.split(values, self.breaks))

    def on_grid(self, values: Array, reach: int) -> Array:
        """Values, (n, k), at their places, with zeros between; no two rows further than a reach."""
        return values if self.whole else _filled(values, np.minimum(np.diff(self.places), reach))

    def pairs(self, lag: int) -> tuple[Index, Index]:
        """Rows that are a lag, 0 or more, after others, and those others."""
        if self.whole:
            return slice(lag, None), slice(0, max(len(self) - lag, 0))
        wanted = self.places - lag
        found = np.searchsorted(self.places, wanted)
        there = self.places[found] == wanted
        return np.flatnonzero(there), found[there]


def _filled(values: Array, steps: NDArray[np.int64]) -> Array:
    """Values, (n,) or (n, k), so many places apart, and zeros between."""
    places = np.concatenate([[0], np.cumsum(steps)])
    filled = np.zeros((int(places[-1]) + 1, *values.shape[1:]))
    filled[places] = values
    return filled
