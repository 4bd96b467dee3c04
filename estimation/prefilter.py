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
from typing import Literal

import numpy as np

from axisid.modeling import UsageError

from .arrays import Array
from .errors import DataError

_RIPPLE_DB = 0.05
_DECIMATION_ORDER = 8
_SETTLED = 1e-3


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
        filter's transient (decay to 1e-3) at both ends.
    hold : {"raw", "zoh"}
        ``zoh`` pairs the acceleration at a sample with the mean of the forces held before and
        after it, since a drive holds its force over the period; ``raw`` with the force after it.

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
    hold: Literal["raw", "zoh"] = "raw"

    def __post_init__(self) -> None:
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
        if self.hold not in ("raw", "zoh"):
            raise UsageError(f"the hold is {self.hold!r}; give raw or zoh.")
        if self.drop is not None and min(self.drop) < 0:
            raise UsageError(f"the rows to drop are {self.drop!r}; give 0 or more at each end.")

    def dropped(self, period: float) -> tuple[int, int]:
        """Samples left out at start and end, for a sampling period in s."""
        if self.drop is not None:
            return self.drop
        # The slowest pole of a Butterworth filter is the one nearest the imaginary axis.
        slowest = 2 * math.pi * self.cutoff * math.sin(math.pi / (2 * self.order))
        transient = math.ceil(-math.log(_SETTLED) / slowest / period)
        return (transient, transient)

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
        if self.cutoff >= nyquist:
            raise UsageError(
                f"the cutoff {self.cutoff:g} Hz is not below {nyquist:g} Hz, half the sampling "
                f"frequency of the record; choose a lower one (about 3 to 10 times the bandwidth "
                "of the position loop)."
            )
        padding = 3 * _DECIMATION_ORDER if self.decimate > 1 else 0
        needed = max(3 * self.order, padding, 2 * self.decimate) + sum(self.dropped(period)) + 1
        if samples < needed:
            raise DataError(
                f"the record has {samples} samples; the filters' transients take {needed - 1}. "
                "Record longer, or raise the cutoff, or lower the order or the decimation."
            )

    def motion(self, position: Array, period: float) -> tuple[Array, Array, Array]:
        """Filtered position, velocity and acceleration, each (N,), SI."""
        from scipy.signal import butter, sosfiltfilt

        sections = butter(self.order, 2 * self.cutoff * period, output="sos")
        q = np.asarray(sosfiltfilt(sections, position, padlen=3 * self.order), dtype=float)
        dq = np.gradient(q, period)
        return q, dq, np.gradient(dq, period)

    def reduce(self, signals: Array, period: float) -> Array:
        """Drop the ends and decimate: (N,) or (N, k) to (n,) or (n, k)."""
        start, end = self.dropped(period)
        kept = signals[start : len(signals) - end]
        if self.decimate == 1:
            return kept
        from scipy.signal import cheby1, sosfiltfilt

        sections = cheby1(_DECIMATION_ORDER, _RIPPLE_DB, 0.8 / self.decimate, output="sos")
        smooth = sosfiltfilt(sections, kept, axis=0, padlen=3 * _DECIMATION_ORDER)
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
