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

from axisid.support.arrays import Array, frozen
from axisid.support.errors import DataError, UsageError

Span = tuple[int, int]

_RIPPLE_DB = 0.05
_DECIMATION_ORDER = 8
_SETTLED = 1e-3
_LOWEST = 1e-4  # of the Nyquist frequency
_ROUNDED = 0.05  # of a step, that the low-pass still lacks
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

    def check(self, samples: int, period: float, what: str = "the record") -> None:
        """Refuse a record, or its longest segment, that these settings cannot serve.

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
        needed = self.needed(period)
        if samples < needed:
            start, end = self.dropped(period)
            raise DataError(
                f"{what} has {samples} samples; {start} + {end} are dropped and the filters' "
                f"transients take {needed - 1 - start - end}. Record longer, drop fewer, raise the "
                "cutoff, or lower the order or the decimation."
            )

    def needed(self, period: float) -> int:
        """Samples that a stretch needs to give a row."""
        padding = 3 * _DECIMATION_ORDER if self.decimate > 1 else 0
        return max(3 * self.order, padding, 2 * self.decimate) + sum(self.dropped(period)) + 1

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
        """Filtered position, velocity and acceleration of one stretch, each (N,), SI."""
        from scipy.signal import sosfiltfilt

        sections = _low_pass(self.order, 2 * self.cutoff * period)
        q = np.asarray(sosfiltfilt(sections.copy(), position, padlen=3 * self.order), dtype=float)
        dq = np.gradient(q, period)
        return q, dq, np.gradient(dq, period)

    def reduce(self, signals: Array, period: float) -> Array:
        """Drop the ends of one stretch and decimate: (N,) or (N, k) to (n,) or (n, k).

        Ends that are named are cut off first, as in the published recipe. By default the ends have
        no weight: the decimation filter would otherwise carry what is wrong there inwards, or
        continue the record from the last sample that is kept, and give it much weight.
        """
        weighted = np.array(signals, dtype=float)
        for first, last in self.silent_ends(len(signals), period):
            weighted[first:last] = 0.0
        start, end = self.cut_before(period)
        kept = weighted[start : len(weighted) - end]
        if self.decimate > 1:
            kept = self.smoothed(kept)
        return kept[self.rows_between(len(signals), period, 0, len(signals)) - start]

    def silent_ends(self, samples: int, period: float) -> tuple[Span, ...]:
        """Samples without weight at the ends of one stretch; none where ends are cut off."""
        if self.drop is not None:
            return ()
        end = self._transient(period, _SETTLED)
        return (0, end), (samples - end, samples)

    def smoothed(self, signals: Array) -> Array:
        """Signals, (N,) or (N, k), through the decimation filter, none of them left out."""
        from scipy.signal import sosfiltfilt

        sections = _decimation_filter(self.decimate)
        return np.asarray(
            sosfiltfilt(sections.copy(), signals, axis=0, padlen=3 * _DECIMATION_ORDER), dtype=float
        )

    @property
    def row_gain(self) -> float:
        """Weight of a row whose samples all have weight: an even Chebyshev filter's is below 1."""
        return 1.0 if self.decimate == 1 else 10.0 ** (-2 * _RIPPLE_DB / 20)

    def rows(self, samples: int, period: float) -> Array:
        """Sample numbers of the rows of one stretch, (n,)."""
        return self.rows_between(samples, period, 0, samples).astype(np.float64)

    def cut_before(self, period: float) -> tuple[int, int]:
        """Samples that the decimation filter does not see, at start and end."""
        return self.dropped(period) if self.drop is not None else (0, 0)

    def rows_between(self, samples: int, period: float, start: int, stop: int) -> NDArray[np.int64]:
        """Rows of one stretch of so many samples, from `start` to before `stop`."""
        low, high = self.dropped(period)
        cut, cut_end = self.cut_before(period)
        first = cut + self._first(samples - cut - cut_end)
        first += max(-(-(max(start, low) - first) // self.decimate), 0) * self.decimate
        return np.arange(first, min(stop, samples - high), self.decimate)

    def turn_reach(self, period: float) -> int:
        """Samples to both sides of a reversal over which the low-pass rounds it."""
        return self._transient(period, _ROUNDED)

    def _first(self, samples: int) -> int:
        if self.decimation == "scipy":
            return 0
        return self.decimate - (self.decimate * math.ceil(samples / self.decimate) - samples) - 1


def matching_decimation(cutoff: float, period: float) -> int:
    """Rows to keep one of, so that the decimation filter's edge is at the cut-off or below."""
    return max(2, math.ceil(_EDGE / (cutoff * period) - 1e-9))


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
