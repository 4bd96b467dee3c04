"""Data filtering: position to velocity and acceleration, then parallel decimation.

The position is low-passed (Butterworth, forward and backward, so without phase) and differentiated
by central differences; then ``y`` and every column of ``X`` pass the same decimation filter, which
keeps the linear relation between them.

References
----------
[Brunot2015]_ section on data filtering; [Janot2019]_ for the record's own recipe.
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from axisid.support.arrays import Array, frozen, runs
from axisid.support.errors import DataError, UsageError

from .reversals import near_turns, rest_below

Span = tuple[int, int]

_RIPPLE_DB = 0.05
_DECIMATION_ORDER = 8
_SETTLED = 1e-3
_LOWEST = 1e-4  # of the Nyquist frequency
_ROUNDED = 0.05  # of a step, that the low-pass still lacks
LIGHT = 0.1  # weight below which a row is left out
_EDGE = 0.4  # of the decimation filter, of the rate that it leaves
_SAME = 1.01  # cutoff and decimation edge that count as one


@dataclass(frozen=True, slots=True, kw_only=True)
class Prefilter:
    """How a record becomes the rows of a regression.

    Attributes
    ----------
    cutoff : float
        Of the Butterworth low-pass on the position, Hz.
    order : int
        Of the Butterworth filter (once; it is applied forward and backward).
    decimate : int
        One row in so many is kept; 1 keeps all and applies no decimation filter.
    decimation : {"matlab", "scipy"}
        Which rows: aligned to the record's end as MATLAB's ``decimate``, or to its start as
        SciPy's. The filter is the same: Chebyshev type I, order 8, 0.05 dB, forward and backward.
    drop : (int, int) or None
        Samples cut off at start and end, before decimation. None gives the low-pass transient
        (decay to 1e-3) at both ends no weight: where the simulated loop starts from rest whatever
        the axis did, and where the filters continue the record from its last sample.
    hold : {"raw", "zoh"} or None
        ``zoh`` pairs the acceleration at a sample with the mean of the forces held before and
        after it, since a drive holds its force over the period; ``raw`` with the force after it,
        as the published recipe does. None takes ``zoh`` for a control that a drive holds, and
        ``raw`` where nothing is held: a measured force, or a continuous law.
    reversals : {"keep", "leave-out"} or None
        ``leave-out`` gives the samples near a reversal or a rest no weight, before the decimation:
        there the low-pass rounds what friction does at once, and at rest noise decides its sign.
        None leaves them out for an axis whose force depends on the direction of motion, unless a
        parameter would then keep less than a twentieth of its information, rests apart, as an
        inertia does where the axis accelerates only as it turns; ``keep`` is what the published
        recipe does.
    segments, masked, silent : tuple of (int, int)
        Of the record that `FilteredRecord.bind` fits the settings to. Each segment is filtered by
        itself, and loses its transients at both ends; one that is too short for that is left out.
        So are the rows whose filters reach a masked sample. What is silent has no weight.

    Raises
    ------
    UsageError
        A setting makes no sense for any record.
    """

    cutoff: float = 60.0
    order: int = 4
    decimate: int = 10
    decimation: Literal["matlab", "scipy"] = "matlab"
    drop: tuple[int, int] | None = None
    hold: Literal["raw", "zoh"] | None = None
    reversals: Literal["keep", "leave-out"] | None = None
    segments: tuple[Span, ...] = ()
    masked: tuple[Span, ...] = ()
    silent: tuple[Span, ...] = ()

    def __post_init__(self) -> None:
        ends = (0, 0) if self.drop is None else self.drop
        pair = isinstance(ends, (tuple, list)) and len(ends) == 2
        whole = (self.order, self.decimate, *(ends if pair else ()))
        if not pair or not all(isinstance(n, (int, np.integer)) for n in whole):
            raise UsageError(
                f"order {self.order!r}, decimation {self.decimate!r} and drop {self.drop!r}: give "
                "whole numbers, and two of them to drop."
            )
        if not isinstance(self.cutoff, (int, float, np.number)):
            raise UsageError(f"the cutoff is {self.cutoff!r}; give a number of hertz.")
        if not (math.isfinite(self.cutoff) and self.cutoff > 0):
            raise UsageError(f"the cutoff is {self.cutoff!r} Hz; give a positive number.")
        if not 1 <= self.order <= 10:
            raise UsageError(f"the filter order is {self.order!r}; give 1 to 10.")
        if self.decimate < 1:
            raise UsageError(
                f"the decimation is {self.decimate!r}; give 1 (keep every row) or more."
            )
        if self.decimation not in ("matlab", "scipy"):
            raise UsageError(f"the row alignment is {self.decimation!r}; give matlab or scipy.")
        if self.hold not in ("raw", "zoh", None):
            raise UsageError(f"the hold is {self.hold!r}; give raw or zoh.")
        if self.reversals not in ("keep", "leave-out", None):
            raise UsageError(f"the reversals are {self.reversals!r}; give keep or leave-out.")
        if self.drop is not None and min(self.drop) < 0:
            raise UsageError(f"the rows to drop are {self.drop!r}; give 0 or more at each end.")

    @classmethod
    def suited(cls, period: float, **settings: Any) -> "Prefilter":
        """Settings for a sampling period in s, the decimation chosen if it is not among them.

        It keeps one row in 10, or fewer where the force would be filtered less than the motion.
        """
        chosen = cls(**settings)
        if "decimate" in settings:
            return chosen
        return replace(
            chosen, decimate=max(chosen.decimate, matching_decimation(chosen.cutoff, period))
        )

    @property
    def silenced(self) -> int:
        """How many samples have no weight, near reversals and rests."""
        return sum(stop - start for start, stop in self.silent)

    def dropped(self, period: float) -> tuple[int, int]:
        """Samples left out at start and end, for a sampling period in s."""
        return (self._transient(period, _SETTLED),) * 2 if self.drop is None else self.drop

    def memory(self, period: float) -> int:
        """Rows over which both filters' responses decay to 1e-3, for a sampling period in s.

        Rows further apart are made of different samples.
        """
        motion, rows = self.settling(period, _SETTLED)
        return motion if self.decimate == 1 else math.ceil((motion + rows) / self.decimate)

    def settling(self, period: float, level: float) -> tuple[int, int]:
        """Samples over which the low-pass and the decimation filter decay to a level."""
        if self.decimate == 1:
            return self._transient(period, level), 0
        sections = _decimation_filter(self.decimate)
        slowest = max(float(np.abs(np.roots(section[3:])).max()) for section in sections)
        return self._transient(period, level), math.ceil(math.log(level) / math.log(slowest))

    def _transient(self, period: float, level: float) -> int:
        # The slowest pole of a Butterworth filter is the one nearest the imaginary axis.
        slowest = 2 * math.pi * self.cutoff * math.sin(math.pi / (2 * self.order))
        return math.ceil(-math.log(level) / slowest / period)

    def at_period(self, designed: float, period: float) -> "Prefilter":
        """The same filter for a record of another period: edges in Hz stay, counts follow.

        Parameters
        ----------
        designed, period : float
            Sampling periods that the settings are for, and of the record, s.
        """
        ratio = designed / period
        if abs(ratio - 1) < _SAME - 1:
            return self
        start, end = self.drop or (0, 0)
        return replace(
            self,
            decimate=max(math.ceil(self.decimate * ratio - 1e-9), 1),
            drop=None if self.drop is None else (round(start * ratio), round(end * ratio)),
        )

    def check(self, samples: int, period: float) -> None:
        """Refuse a record that these settings cannot serve.

        Raises
        ------
        UsageError
            The cutoff is not below the Nyquist frequency.
        DataError
            The record is shorter than the filters' transients.
        """
        nyquist = 0.5 / period
        if self.cutoff < _LOWEST * nyquist:
            raise UsageError(
                f"the cutoff {self.cutoff:g} Hz is too low for a record sampled at {2 * nyquist:g} "
                f"Hz; give {_LOWEST * nyquist:g} Hz or more, and check that time is in seconds."
            )
        if self.cutoff >= nyquist:
            raise UsageError(
                f"the cutoff {self.cutoff:g} Hz is not below {nyquist:g} Hz, half the sampling "
                f"frequency of the record; choose a lower one (about 3 to 10 times the bandwidth "
                "of the position loop), and check that time is in seconds."
            )
        needed = self._needed(period)
        longest = max((b - a for a, b in self.segments), default=samples)
        if longest < needed:
            start, end = self.dropped(period)
            what = "the record's longest segment" if self.segments else "the record"
            raise DataError(
                f"{what} has {longest} samples; {start} + {end} are dropped and the filters' "
                f"transients take {needed - 1 - start - end}. Record longer, drop fewer, raise the "
                "cutoff, or lower the order or the decimation."
            )

    def _needed(self, period: float) -> int:
        """Samples that a segment needs to give a row."""
        padding = 3 * _DECIMATION_ORDER if self.decimate > 1 else 0
        return max(3 * self.order, padding, 2 * self.decimate) + sum(self.dropped(period)) + 1

    def spans(self, samples: int, period: float) -> tuple[Span, ...]:
        """The segments that are long enough; of a record without gaps, the record."""
        if not self.segments:
            return ((0, samples),)
        needed = self._needed(period)
        return tuple(span for span in self.segments if span[1] - span[0] >= needed)

    def remarks(self, period: float) -> tuple[str, ...]:
        """What the settings do to the estimates, where that is not what one would want."""
        edge = _EDGE / (self.decimate * period) if self.decimate > 1 else 0.5 / period
        if edge <= self.cutoff * _SAME:
            return ()
        wanted = matching_decimation(self.cutoff, period)
        return (
            f"the motion is low-passed at {self.cutoff:g} Hz, the force only at {edge:.4g} Hz, by "
            "the decimation: they no longer belong together, which biases every method; decimate "
            f"by {wanted} or more, or raise the cutoff",
        )

    def motion(self, position: Array, period: float) -> tuple[Array, Array, Array]:
        """Filtered position, velocity and acceleration, each (N,), SI; at rest where left out."""
        q = np.array(position, dtype=float)
        dq, ddq = np.zeros_like(q), np.zeros_like(q)
        for start, stop in self.spans(len(q), period):
            piece = self._motion(position[start:stop], period)
            q[start:stop], dq[start:stop], ddq[start:stop] = piece
        return q, dq, ddq

    def _motion(self, position: Array, period: float) -> tuple[Array, Array, Array]:
        from scipy.signal import sosfiltfilt

        sections = _low_pass(self.order, 2 * self.cutoff * period)
        q = np.asarray(sosfiltfilt(sections.copy(), position, padlen=3 * self.order), dtype=float)
        dq = np.gradient(q, period)
        return q, dq, np.gradient(dq, period)

    def reduce(self, signals: Array, period: float) -> Array:
        """Drop the ends, decimate, leave out what is masked: (N,) or (N, k) to (n,) or (n, k).

        Ends that are named are cut off first, as in the published recipe. By default the ends have
        no weight: the decimation filter would otherwise carry what is wrong there inwards, or
        continue the record from the last sample that is kept, and give it much weight.
        """
        signals = self.weighted(signals, period)
        reduced = self.reduce_all(signals, period)
        selected = self._selected(len(signals), period)
        return reduced if selected is None else reduced[selected]

    def reduce_all(self, signals: Array, period: float) -> Array:
        """`reduce` with the rows that are masked or have no weight among them."""
        spans = self.spans(len(signals), period)
        pieces = [self._reduce(signals[start:stop], period) for start, stop in spans]
        return pieces[0] if len(pieces) == 1 else np.concatenate(pieces)

    def weighted(self, signals: Array, period: float) -> Array:
        """Signals with no weight on what is silent, nor on the ends unless they are cut off."""
        weighted = np.array(signals, dtype=float)
        for start, stop in (*self.silent, *self.silent_ends(len(signals), period)):
            weighted[start:stop] = 0.0
        return weighted

    def silent_ends(self, samples: int, period: float) -> tuple[Span, ...]:
        """Samples without weight at the ends of the segments; none where ends are cut off."""
        if self.drop is not None:
            return ()
        end = self._transient(period, _SETTLED)
        spans = self.spans(samples, period)
        return tuple(span for a, b in spans for span in ((a, a + end), (b - end, b)))

    def _selected(self, samples: int, period: float) -> NDArray[np.bool_] | None:
        """Which rows are neither masked nor silent; None for all."""
        if not (self.masked or self.silent):
            return None
        return _selected_rows(self, samples, period)

    def _reduce(self, signals: Array, period: float) -> Array:
        start, end = self.cut_before(period)
        kept = signals[start : len(signals) - end]
        if self.decimate > 1:
            kept = self.smoothed(kept)
        rows = self.rows_between(len(signals), period, 0, len(signals))
        return kept[rows - start]

    def smoothed(self, signals: Array) -> Array:
        """Signals, (N,) or (N, k), through the decimation filter, none of them left out."""
        from scipy.signal import sosfiltfilt

        sections = _decimation_filter(self.decimate)
        return np.asarray(
            sosfiltfilt(sections.copy(), signals, axis=0, padlen=3 * _DECIMATION_ORDER), dtype=float
        )

    def weights(self, samples: int, period: float) -> Array:
        """What each row makes of a signal that is 1 everywhere, (n,); see `row_gain`."""
        return self.reduce(np.ones(samples), period)

    @property
    def row_gain(self) -> float:
        """Weight of a row whose samples all have weight: an even Chebyshev filter's is below 1."""
        return 1.0 if self.decimate == 1 else 10.0 ** (-2 * _RIPPLE_DB / 20)

    def rows(self, samples: int, period: float) -> Array:
        """Sample numbers of the rows that `reduce` keeps, (n,)."""
        rows, selected = self._all_rows(samples, period), self._selected(samples, period)
        return rows if selected is None else rows[selected]

    def cut_before(self, period: float) -> tuple[int, int]:
        """Samples that the decimation filter does not see, at start and end."""
        return self.dropped(period) if self.drop is not None else (0, 0)

    def masked_rows(self, samples: int, period: float) -> int:
        """How many rows are left out because their filters reach a masked sample."""
        return int(np.sum(~self.clean(samples, period)))

    def kept(self, samples: int, period: float) -> NDArray[np.bool_]:
        """Samples that are neither dropped nor masked nor in a segment that is left out, (N,)."""
        start, end = self.dropped(period)
        kept = np.zeros(samples, dtype=bool)
        for first, last in self.spans(samples, period):
            kept[first + start : last - end] = True
        for first, last in self.masked:
            kept[first:last] = False
        return kept

    def _all_rows(self, samples: int, period: float) -> Array:
        spans = self.spans(samples, period)
        pieces = [a + self.rows_between(b - a, period, 0, b - a) for a, b in spans]
        return np.concatenate(pieces).astype(np.float64)

    def rows_between(self, samples: int, period: float, start: int, stop: int) -> NDArray[np.int64]:
        """Rows of one segment of so many samples, from `start` to before `stop`."""
        low, high = self.dropped(period)
        cut, cut_end = self.cut_before(period)
        first = cut + self._first(samples - cut - cut_end)
        first += max(-(-(max(start, low) - first) // self.decimate), 0) * self.decimate
        return np.arange(first, min(stop, samples - high), self.decimate)

    def near_reversals(self, position: Array, period: float) -> tuple[Span, ...]:
        """Samples near which the filtered velocity changes its sign or rests, by segment."""
        return self.turns(self.motion(position, period)[1], period)

    def turns(self, velocity: Array, period: float) -> tuple[Span, ...]:
        """`near_reversals` of a velocity that is filtered already, (N,)."""
        spans = self.spans(len(velocity), period)
        rest, reach = rest_below(velocity[a:b] for a, b in spans), self.turn_reach(period)
        return tuple(
            stretch for a, b in spans for stretch in runs(near_turns(velocity[a:b], reach, rest), a)
        )

    def turn_reach(self, period: float) -> int:
        """Samples to both sides of a reversal over which the low-pass rounds it."""
        return self._transient(period, _ROUNDED)

    def clean(self, samples: int, period: float) -> NDArray[np.bool_]:
        """Which rows no filter brings a masked sample into."""
        rows = self._all_rows(samples, period)
        clean = np.ones(len(rows), dtype=bool)
        reach = self.memory(period) * self.decimate
        for start, stop in self.masked:
            first, last = np.searchsorted(rows, (start - reach, stop + reach))
            clean[first:last] = False
        return clean

    def _first(self, samples: int) -> int:
        if self.decimation == "scipy":
            return 0
        return self.decimate - (self.decimate * math.ceil(samples / self.decimate) - samples) - 1


def matching_decimation(cutoff: float, period: float) -> int:
    """Rows to keep one of, so that the decimation filter's edge is at the cut-off or below."""
    return max(2, math.ceil(_EDGE / (cutoff * period) - 1e-9))


@lru_cache(maxsize=32)
def _selected_rows(prefilter: Prefilter, samples: int, period: float) -> NDArray[np.bool_]:
    """Rows that no masked sample reaches and that have weight."""
    selected = prefilter.clean(samples, period)
    if prefilter.silent:
        weights = prefilter.reduce_all(prefilter.weighted(np.ones(samples), period), period)
        selected = selected & (weights > LIGHT)
    return selected


# Designing a filter takes as long as applying it to a record; the designs are pure functions.
@lru_cache(maxsize=32)
def _low_pass(order: int, edge: float) -> Array:
    """Second-order sections of a Butterworth filter, its edge in units of the Nyquist frequency."""
    from scipy.signal import butter

    return frozen(butter(order, edge, output="sos"))


@lru_cache(maxsize=32)
def _decimation_filter(decimate: int) -> Array:
    """Second-order sections of the decimation filter."""
    from scipy.signal import cheby1

    return frozen(cheby1(_DECIMATION_ORDER, _RIPPLE_DB, 0.8 / decimate, output="sos"))
