"""Data filtering: position to velocity and acceleration, then parallel decimation.

The position is low-passed (Butterworth, forward and backward, so without phase) and differentiated
by central differences; then ``y`` and every column of ``X`` pass the same decimation filter, which
keeps the linear relation between them.

References
----------
[Brunot2015]_ section on data filtering; [Janot2019]_ for the record's own recipe.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from axisid.modeling import UsageError

from .arrays import Array, frozen
from .errors import DataError

_RIPPLE_DB = 0.05
_DECIMATION_ORDER = 8
_SETTLED = 1e-3
_LOWEST = 1e-4  # of the Nyquist frequency
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
        Samples left out at start and end, before decimation. None leaves out the low-pass
        filter's transient (decay to 1e-3) at the start, where the simulated loop starts from rest
        whatever the axis did; the end is kept, as in the published recipe.
    hold : {"raw", "zoh"} or None
        ``zoh`` pairs the acceleration at a sample with the mean of the forces held before and
        after it, since a drive holds its force over the period; ``raw`` with the force after it,
        as the published recipe does. None takes ``zoh`` for a control that a drive holds, and
        ``raw`` where nothing is held: a measured force, or a continuous law.

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

    def __post_init__(self) -> None:
        whole = (self.order, self.decimate, *(self.drop or ()))
        if not all(isinstance(n, (int, np.integer)) for n in whole) or len(self.drop or "ab") != 2:
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
        if self.drop is not None and min(self.drop) < 0:
            raise UsageError(f"the rows to drop are {self.drop!r}; give 0 or more at each end.")

    def dropped(self, period: float) -> tuple[int, int]:
        """Samples left out at start and end, for a sampling period in s."""
        return (self._transient(period), 0) if self.drop is None else self.drop

    def memory(self, period: float) -> int:
        """Rows over which both filters' responses decay to 1e-3, for a sampling period in s.

        Rows further apart are made of different samples.
        """
        if self.decimate == 1:
            return self._transient(period)
        sections = _decimation_filter(self.decimate)
        slowest = max(float(np.abs(np.roots(section[3:])).max()) for section in sections)
        samples = self._transient(period) + math.log(_SETTLED) / math.log(slowest)
        return math.ceil(samples / self.decimate)

    def _transient(self, period: float) -> int:
        # The slowest pole of a Butterworth filter is the one nearest the imaginary axis.
        slowest = 2 * math.pi * self.cutoff * math.sin(math.pi / (2 * self.order))
        return math.ceil(-math.log(_SETTLED) / slowest / period)

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
                f"Hz; give {_LOWEST * nyquist:g} Hz or more."
            )
        if self.cutoff >= nyquist:
            raise UsageError(
                f"the cutoff {self.cutoff:g} Hz is not below {nyquist:g} Hz, half the sampling "
                f"frequency of the record; choose a lower one (about 3 to 10 times the bandwidth "
                "of the position loop), and check that time is in seconds."
            )
        padding = 3 * _DECIMATION_ORDER if self.decimate > 1 else 0
        needed = max(3 * self.order, padding, 2 * self.decimate) + sum(self.dropped(period)) + 1
        if samples < needed:
            start, end = self.dropped(period)
            raise DataError(
                f"the record has {samples} samples; {start} + {end} are dropped and the filters' "
                f"transients take {needed - 1 - start - end}. Record longer, drop fewer, raise the "
                "cutoff, or lower the order or the decimation."
            )

    def remarks(self, period: float) -> tuple[str, ...]:
        """What the settings do to the estimates, where that is not what one would want."""
        edge = 0.4 / (self.decimate * period) if self.decimate > 1 else 0.5 / period
        if edge <= self.cutoff * _SAME:
            return ()
        wanted = math.ceil(0.4 / (self.cutoff * period))
        return (
            f"the motion is low-passed at {self.cutoff:g} Hz, the force only at {edge:.4g} Hz, by "
            "the decimation: they no longer belong together, which biases every method; decimate "
            f"by {wanted} or more, or raise the cutoff",
        )

    def motion(self, position: Array, period: float) -> tuple[Array, Array, Array]:
        """Filtered position, velocity and acceleration, each (N,), SI."""
        from scipy.signal import sosfiltfilt

        sections = _low_pass(self.order, 2 * self.cutoff * period)
        q = np.asarray(sosfiltfilt(sections.copy(), position, padlen=3 * self.order), dtype=float)
        dq = np.gradient(q, period)
        return q, dq, np.gradient(dq, period)

    def reduce(self, signals: Array, period: float) -> Array:
        """Drop the ends and decimate: (N,) or (N, k) to (n,) or (n, k)."""
        start, end = self.dropped(period)
        kept = signals[start : len(signals) - end]
        if self.decimate == 1:
            return kept
        from scipy.signal import sosfiltfilt

        sections = _decimation_filter(self.decimate)
        smooth = sosfiltfilt(sections.copy(), kept, axis=0, padlen=3 * _DECIMATION_ORDER)
        return np.asarray(smooth[self._first(len(kept)) :: self.decimate], dtype=float)

    def rows(self, samples: int, period: float) -> Array:
        """Sample numbers of the rows that `reduce` keeps, (n,)."""
        start, end = self.dropped(period)
        first = self._first(samples - start - end)
        return np.arange(start + first, samples - end, self.decimate, dtype=float)

    def _first(self, samples: int) -> int:
        if self.decimation == "scipy":
            return 0
        return self.decimate - (self.decimate * math.ceil(samples / self.decimate) - samples) - 1


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
