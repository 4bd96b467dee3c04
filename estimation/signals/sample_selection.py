"""Selection of samples, the rows that they give, and the times of the rows.

Rows are missing where samples are masked or left out, between segments and between records.
Quantities of rows that are a lag apart, such as an autocovariance or a run of one sign, are those
of rows a lag apart in time, not in the array.

References
----------
[Parzen1963]_ for correlations of a series with missing values.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

from axisid.estimation.thresholds import MIN_ROW_WEIGHT, REST_SPEED
from axisid.support.arrays import Array, mask_of, runs

from .prefilter import SampledFilter, Span

#: Selection of rows: a slice, or their indices.
Index = slice | NDArray[np.intp]

_APART = 1 << 40  # row periods between pieces: more than any lag
_AT_ONCE = 8  # number of columns that are filtered together

#: Number of lags, and of lags times rows, from which Fourier transforms compute the products.
_MANY_LAGS, _MANY_PRODUCTS = 32, 960_000


@dataclass(frozen=True, eq=False)
class RowTimes:
    """Times of rows in row periods; rows at consecutive times are neighbours.

    Attributes
    ----------
    places : (n,) array of int
        Time of each row in row periods, strictly increasing. Rows of different segments or records
        are further apart than any lag.
    """

    places: NDArray[np.int64]

    @classmethod
    def consecutive(cls, rows: int) -> "RowTimes":
        """Return the times of a number of rows without gaps."""
        return cls(np.arange(rows, dtype=np.int64))

    @classmethod
    def joined(cls, pieces: Sequence["RowTimes"]) -> "RowTimes":
        """Return the times of the rows of all pieces, with gaps between the pieces."""
        if len(pieces) == 1:
            return pieces[0]
        places, following = [], 0
        for piece in (piece for piece in pieces if len(piece)):
            places.append(piece.places - piece.places[0] + following)
            following = int(places[-1][-1]) + _APART
        return cls(np.concatenate(places) if places else np.empty(0, dtype=np.int64))

    def __len__(self) -> int:
        return len(self.places)

    def __getitem__(self, rows: Index) -> "RowTimes":
        return RowTimes(self.places[rows])

    @cached_property
    def whole(self) -> bool:
        """True if no row is missing between the first and the last."""
        return not len(self) or int(self.places[-1] - self.places[0]) == len(self) - 1

    @cached_property
    def breaks(self) -> NDArray[np.intp]:
        """Indices of rows after a gap, without the first row."""
        return np.flatnonzero(np.diff(self.places) > 1) + 1

    @property
    def lengths(self) -> NDArray[np.int64]:
        """Number of rows of each stretch without gaps, (s,)."""
        return np.diff(np.concatenate([[0], self.breaks, [len(self)]]))

    def split(self, values: Array) -> list[Array]:
        """Return values, (n,) or (n, k), split into stretches without gaps."""
        return list(np.split(values, self.breaks))

    def on_grid(self, values: Array, reach: int) -> Array:
        """Return values of rows, (n, k), on an even grid of times, (m, k), with 0 for missing rows.

        Gaps are shortened so that consecutive rows are at most `reach` row periods apart.
        """
        if self.whole:
            return values
        steps = np.minimum(np.diff(self.places), reach)
        places = np.concatenate([[0], np.cumsum(steps)])
        filled = np.zeros((int(places[-1]) + 1, *values.shape[1:]))
        filled[places] = values
        return filled

    def autocovariances(self, scores: Array, lags: int) -> Array:
        """Return the sums ``sum_t s_t s_(t-l)'`` for lags l from 0 to `lags`, (lags + 1, k, k).

        `scores` has the row s_t of each time t, (n, k).
        """
        placed = self.on_grid(scores, lags + 1)
        rows = len(placed)
        if lags >= _MANY_LAGS and (lags + 1) * rows >= _MANY_PRODUCTS:
            # The cost of Fourier transforms does not grow with the lags.
            length = next_fast_len(rows + lags, real=True)
            spectra, k = rfft(placed, length, axis=0), placed.shape[1]
            products = np.empty((lags + 1, k, k))
            for i, j in np.ndindex(k, k):
                products[:, i, j] = irfft(spectra[:, i] * spectra[:, j].conj(), length)[: lags + 1]
            return products
        return np.array([placed[lag:].T @ placed[: max(rows - lag, 0)] for lag in range(lags + 1)])

    def pairs(self, lag: int) -> tuple[Index, Index]:
        """Return the indices of all pairs of rows that are a lag (0 or more) apart.

        The first value has the later rows, the second value the earlier rows.
        """
        if self.whole:
            return slice(lag, None), slice(0, max(len(self) - lag, 0))
        wanted = self.places - lag
        indices = np.searchsorted(self.places, wanted)
        matched = self.places[indices] == wanted
        return np.flatnonzero(matched), indices[matched]


@dataclass(frozen=True, kw_only=True)
class Sampling:
    """Selection of the samples of one record for a prefilter, and the rows that they give.

    Each segment is filtered separately, without the transients at both ends. A segment that is too
    short for the filters is left out, and so are rows whose filters reach a masked sample.

    Attributes
    ----------
    filter : SampledFilter
        Prefilter at the sampling period of the record.
    samples : int
        Number of samples of the record.
    segments : tuple of (int, int)
        First sample and the one after the last of each segment of a record with gaps; empty for a
        record without gaps. The same applies to the pieces below.
    masked : tuple of (int, int)
        Pieces on which no row may depend.
    excluded : tuple of (int, int)
        Pieces near reversals and rests that have no weight.
    """

    filter: SampledFilter
    samples: int
    segments: tuple[Span, ...] = ()
    masked: tuple[Span, ...] = ()
    excluded: tuple[Span, ...] = ()

    @property
    def excluded_samples(self) -> int:
        """Number of samples near reversals and rests that have no weight."""
        return sum(stop - start for start, stop in self.excluded)

    @cached_property
    def spans(self) -> tuple[Span, ...]:
        """First sample and the one after the last of each segment that is long enough.

        The whole record is one segment if it has no gaps.
        """
        stretches, needed = self.segments or ((0, self.samples),), self.filter.needed
        return tuple(span for span in stretches if span[1] - span[0] >= needed)

    def motion(
        self, position: Array, velocity: Array | None = None, acceleration: Array | None = None
    ) -> tuple[Array, Array, Array]:
        """Return filtered position, velocity and acceleration, each (N,), SI.

        In segments that are left out, the position is unfiltered, and velocity and acceleration are
        0. Velocity and acceleration are differences unless they were measured, see
        `SampledFilter.motion`.
        """
        q = np.array(position, dtype=float)
        dq, ddq = np.zeros_like(q), np.zeros_like(q)
        for start, stop in self.spans:
            measured = (None if v is None else v[start:stop] for v in (velocity, acceleration))
            q[start:stop], dq[start:stop], ddq[start:stop] = self.filter.motion(
                position[start:stop], *measured
            )
        return q, dq, ddq

    def reduce(self, signals: Array) -> Array:
        """Return the rows of signals, (n,) or (n, k), from samples (N,) or (N, k).

        The ends are dropped, the signals are filtered and decimated, and rows whose filters reach
        masked samples, or that have hardly any weight, are left out.
        """
        if signals.ndim == 1:
            return self._reduced(signals)[self._selected]
        # The rows of a column of 1 or -1, as of an offset, are the weights or minus the weights.
        known = np.array([abs(of[0]) == 1 and np.all(of == of[0]) for of in signals.T], dtype=bool)
        rows = np.empty((len(self.rows), len(known)))
        rows[:, known] = self.weights[:, None] * signals[0, known]
        # Few columns at a time, as filters need several copies in memory.
        others = np.flatnonzero(~known)
        for first in range(0, len(others), _AT_ONCE):
            few = others[first : first + _AT_ONCE]
            rows[:, few] = self._reduced(signals[:, few])[self._selected]
        return rows

    @cached_property
    def rows(self) -> Array:
        """Sample numbers of the rows from `reduce`, (n,)."""
        return self._all_rows[self._selected]

    @cached_property
    def weights(self) -> Array:
        """Weight of each row, (n,): the row of a signal that is 1 in every sample.

        It is smaller near samples without weight.
        """
        return self.reduce(np.ones(self.samples))

    @property
    def used(self) -> NDArray[np.bool_]:
        """True for samples that are kept and not excluded, (N,)."""
        return self.kept & ~mask_of(self.excluded, self.samples)

    @cached_property
    def kept(self) -> NDArray[np.bool_]:
        """True for samples that are not dropped, masked or in a segment that is left out, (N,)."""
        start, end = self.filter.dropped
        filtered = mask_of([(a + start, b - end) for a, b in self.spans], self.samples)
        return filtered & ~mask_of(self.masked, self.samples)

    @cached_property
    def neighbours(self) -> RowTimes:
        """Times of the rows, in row periods."""
        numbers = self.rows.astype(np.int64)
        starts = [start for start, _ in self.spans[1:]]
        pieces = np.split(numbers, np.searchsorted(numbers, starts))
        return RowTimes.joined([RowTimes(p // self.filter.settings.decimate) for p in pieces])

    @property
    def masked_rows(self) -> int:
        """Number of rows that are left out because their filters reach a masked sample."""
        return int(np.sum(~self._clean))

    def turns(self, velocity: Array, fastest: float = 0.0) -> tuple[Span, ...]:
        """Return the pieces of samples near a reversal or rest of a filtered velocity.

        Parameters
        ----------
        velocity : (N,) array
            Filtered velocity, m/s or rad/s.
        fastest : float
            Largest speed of other records of the machine, m/s or rad/s.

        Returns
        -------
        tuple of (int, int)
            First sample and the one after the last of each piece.
        """
        # Noise at rest is equal in all records of a machine, so one rest speed applies to all.
        speeds = (float(np.abs(velocity[a:b]).max()) for a, b in self.spans)
        rest = REST_SPEED.value * max(fastest, *speeds)
        reach = self.filter.turn_reach
        return tuple(
            stretch
            for a, b in self.spans
            for stretch in runs(near_turns(velocity[a:b], reach, rest), a)
        )

    def _reduced(self, signals: Array) -> Array:
        """Return the rows of all segments, (m,) or (m, k), from samples (N,) or (N, k).

        Rows that depend on masked samples, and rows without weight, are included.
        """
        weighted = signals
        if self.excluded:
            weighted = np.array(signals, dtype=float)
            weighted[mask_of(self.excluded, self.samples)] = 0.0
        return np.concatenate([self.filter.reduce(weighted[a:b]) for a, b in self.spans])

    @cached_property
    def _all_rows(self) -> Array:
        """Sample numbers of the rows of all segments, with masked and excluded rows, (m,)."""
        return np.concatenate([a + self.filter.rows(b - a) for a, b in self.spans]).astype(
            np.float64
        )

    @cached_property
    def _clean(self) -> NDArray[np.bool_]:
        """True for rows of all segments whose filters do not reach a masked sample, (m,)."""
        if not self.masked:  # the reach of the filters is not needed
            return np.ones(len(self._all_rows), dtype=bool)
        reach = self.filter.memory * self.filter.settings.decimate
        ends = ((start - reach, stop + reach) for start, stop in self.masked)
        reached = (np.searchsorted(self._all_rows, each).tolist() for each in ends)
        return ~mask_of(reached, len(self._all_rows))

    @cached_property
    def _selected(self) -> NDArray[np.bool_]:
        """True for rows of all segments that are kept, (m,): neither masked nor excluded."""
        if not self.excluded:
            return self._clean
        return self._clean & (self._reduced(np.ones(self.samples)) > MIN_ROW_WEIGHT.value)


def near_turns(velocity: Array, reach: int, rest: float) -> NDArray[np.bool_]:
    """Return True for samples of a stretch near a change of direction or a rest, (N,).

    Parameters
    ----------
    velocity : (N,) array
        Filtered velocity.
    reach : int
        Largest distance from the change of direction or the rest, in samples.
    rest : float
        Speed below which the axis counts as at rest.
    """
    from scipy.ndimage import maximum_filter1d

    direction = np.sign(velocity) * (np.abs(velocity) > rest)
    turns = direction == 0
    turns[1:] |= direction[1:] != direction[:-1]
    return np.asarray(maximum_filter1d(turns.astype(np.int8), 2 * reach + 1), dtype=bool)
