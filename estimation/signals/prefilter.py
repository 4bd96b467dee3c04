"""Prefilter settings, and the filter that makes the rows of a regression from a record.

The position is low-passed (Butterworth, forward and backward, so without phase) and differentiated
by central differences; a measured velocity or acceleration passes the same low-pass. Then
``y`` and every column of ``X`` pass the same decimation filter, which keeps the linear relation
between them.

References
----------
[Brunot2015]_, section on data filtering; [Janot2019]_ for the recipe of the EMPS record.
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.runtime import column_filter
from axisid.estimation.records import check_sample_period
from axisid.support.arrays import Array, frozen
from axisid.support.checks import check_among, is_real, is_whole, refuse
from axisid.support.errors import DataError, UsageError
from axisid.support.settings import setting
from axisid.support.wording import quoted

# Largest ratio of two cut-off frequencies that count as equal, and of two sampling periods for
# which a setting has the same number of samples.
SAME_FILTER_FREQUENCY = 1.01
# Default cut-off relative to the sampling frequency, if that is below 300 Hz; otherwise 60 Hz.
_MAX_DEFAULT_CUTOFF = 0.2

#: Edge of the decimation filter, relative to the row frequency.
DECIMATION_EDGE = 0.4


class _OpenCutoff(float):
    """Default cut-off, which depends on the record's sampling frequency."""


class _OpenDecimation(int):
    """Default decimation, which depends on the cut-off and the record's sampling frequency."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Prefilter:
    """Settings of the filter that makes the rows of a regression from a record.

    Attributes
    ----------
    cutoff : float
        Cut-off frequency of the Butterworth low-pass on the position, Hz. Default: 60 Hz, or a
        fifth of the record's sampling frequency if that is below 300 Hz.
    order : int
        Order of the Butterworth filter (of one pass; it is applied forward and backward).
    decimate : int
        Decimation factor; 1 keeps every row and applies no decimation filter. Default: 10, or more
        if the force would otherwise be filtered less than the motion.
    decimation : {"matlab", "scipy"}
        Alignment of the rows: to the record's end as in MATLAB's ``decimate``, or to its start as
        in SciPy's. The filter is the same: Chebyshev type I, order 8, 0.05 dB, forward and
        backward.
    drop : (int, int) or None
        Samples cut off at start and end, before decimation. None gives no weight to the transient
        of the low-pass (decay to 1e-3) at both ends, where the filters extrapolate the record.
    hold : {"raw", "zoh"} or None
        ``zoh`` pairs the acceleration at a sample with the mean of the forces held before and
        after the sample, since a drive holds its force over the period. ``raw`` pairs it with the
        force after the sample, as in the published recipe. None selects ``zoh`` for a control that
        a drive holds, and ``raw`` for a measured force or a continuous law.
    reversals : {"keep", "leave-out"} or None
        ``leave-out`` gives no weight, before the decimation, to samples near a reversal or a rest:
        there the low-pass rounds the jump of friction, and at rest noise decides its sign. None
        leaves these samples out for an axis whose force depends on the direction of motion, unless
        a parameter would then lose more than a third of the information that all records together
        have on it outside rests. Examples are an inertia if the axis accelerates only at reversals,
        and Coulomb friction at a low cut-off. ``keep`` is the published recipe.

    Raises
    ------
    UsageError
        A setting is not valid for any record.
    """

    cutoff: float = _OpenCutoff(60.0)
    order: int = 4
    decimate: int = _OpenDecimation(10)
    decimation: Literal["matlab", "scipy"] = "matlab"
    drop: tuple[int, int] | None = None
    hold: Literal["raw", "zoh"] | None = None
    reversals: Literal["keep", "leave-out"] | None = None

    def __post_init__(self) -> None:
        drop = (0, 0) if self.drop is None else self.drop
        is_pair = isinstance(drop, (tuple, list)) and len(drop) == 2
        refuse(
            UsageError,
            (
                not (is_real(self.cutoff) and 0 < self.cutoff < math.inf),
                f"the cutoff is {quoted(self.cutoff)}. Give a positive number of hertz",
            ),
            (
                not _is_whole_within(self.order, 1, 10),
                f"the order is {quoted(self.order)}. Give a whole number from 1 to 10",
            ),
            (
                not _is_whole_within(self.decimate, 1),
                f"the decimation is {quoted(self.decimate)}. Give a whole number, 1 (keep every "
                "row) or more",
            ),
            (
                not (is_pair and all(_is_whole_within(end, 0) for end in drop)),
                f"the number of samples to drop is {quoted(self.drop)}. Give two whole numbers, 0 "
                "or more, for the start and the end",
            ),
            code="filter",
        )
        choices = (
            ("row alignment", self.decimation or "none", ("matlab", "scipy")),
            ("hold", self.hold, ("raw", "zoh")),
            ("treatment of reversals", self.reversals, ("keep", "leave-out")),
        )
        check_among(*(row for row in choices if row[1] is not None))

    @classmethod
    def given(cls, prefilter: object) -> "Prefilter":
        """Return a given prefilter, or the default settings for None.

        Raises
        ------
        UsageError
            The argument is neither a Prefilter nor None.
        """
        if not isinstance(prefilter, Prefilter | None):
            raise UsageError(
                f"the prefilter is {quoted(prefilter)}. Give a Prefilter, or omit the argument.",
                code="filter",
            )
        return prefilter or cls()

    @classmethod
    def suited(cls, period: float, **settings: Any) -> "Prefilter":
        """Return settings for a sampling period in s; default cut-off and decimation are chosen.

        `settings` are values of attributes.

        Raises
        ------
        UsageError
            The period is not a positive number, or a setting is not valid.
        """
        check_sample_period(period)
        return cls(**settings).at_rate_of(period)

    def at_rate_of(self, period: float) -> "Prefilter":
        """Return the settings with default cut-off and decimation chosen for a period in s."""
        cutoff, decimate = self.cutoff, self.decimate
        if isinstance(cutoff, _OpenCutoff):
            cutoff = min(float(cutoff), _MAX_DEFAULT_CUTOFF / period)
        if isinstance(decimate, _OpenDecimation):
            decimate = max(int(decimate), matching_decimation(cutoff, period))
        return replace(self, cutoff=float(cutoff), decimate=int(decimate))

    def at_period(self, designed: float, period: float) -> "Prefilter":
        """Return the settings of the same filter for another period.

        Frequencies in Hz do not change; decimation and dropped samples are scaled. Periods that
        differ by less than 1 % count as equal.

        Parameters
        ----------
        designed, period : float
            Sampling period of the settings, and of the record, s.
        """
        ratio = designed / period
        if abs(ratio - 1) < SAME_FILTER_FREQUENCY - 1:
            return self
        start, end = self.drop or (0, 0)
        return replace(
            self,
            decimate=max(math.ceil(self.decimate * ratio - 1e-9), 1),
            drop=None if self.drop is None else (round(start * ratio), round(end * ratio)),
        )


def _is_whole_within(number: object, least: int, most: float = math.inf) -> bool:
    """Return True for a whole number from `least` to `most`."""
    return is_real(number) and is_whole(number) and least <= number <= most


def matching_decimation(cutoff: float, period: float) -> int:
    """Return the smallest decimation, at least 2, that filters the force like the motion or more.

    The edge of its decimation filter is at the cut-off of the low-pass or below it.

    Parameters
    ----------
    cutoff : float
        Cut-off frequency of the low-pass, Hz.
    period : float
        Sampling period, s.
    """
    return max(2, math.ceil(DECIMATION_EDGE / (cutoff * period) - 1e-9))


_MIN_CUTOFF = 1e-4  # smallest cut-off relative to the Nyquist frequency
_SETTLED_TRANSIENT = 1e-3  # remainder of a filter's transient that counts as settled
# Remainder of a step response, above which the low-pass rounds a reversal.
_MAX_STEP_REMAINDER = 0.05

#: First sample and the one after the last.
Span = tuple[int, int]

_RIPPLE_DB = 0.05  # ripple of the decimation filter in its pass band, dB
_DECIMATION_ORDER = 8
_PADDING = 3  # samples per order of a filter by which a stretch is extended at both ends


@dataclass(frozen=True, slots=True)
class SampledFilter:
    """Prefilter at a sampling period, for one stretch of samples.

    A stretch is a series of samples without gaps, such as a segment of a record.

    Attributes
    ----------
    settings : Prefilter
        Settings with cut-off and decimation for the sampling period.
    period : float
        Sampling period, s.
    native : bool
        True if compiled code is used where it is available; its results are bit-identical.
    """

    settings: Prefilter
    period: float
    native: bool = False

    @property
    def dropped(self) -> tuple[int, int]:
        """Number of samples that have no weight at start and end of a stretch."""
        return self.settings.drop or (self._transient(_SETTLED_TRANSIENT),) * 2

    @property
    def cut(self) -> tuple[int, int]:
        """Number of samples at start and end that are cut off before the decimation filter.

        These are the samples that the user gave (`drop`); by default none.
        """
        return self.settings.drop or (0, 0)

    @property
    def memory(self) -> int:
        """Number of rows over which the responses of both filters decay to 1e-3.

        Rows further apart depend on different samples.
        """
        motion, decimate = self._transient(_SETTLED_TRANSIENT), self.settings.decimate
        if decimate == 1:
            return motion
        sections = self.decimation.sections
        slowest = max(float(np.abs(np.roots(section[3:])).max()) for section in sections)
        rows = math.ceil(math.log(_SETTLED_TRANSIENT) / math.log(slowest))
        return math.ceil((motion + rows) / decimate)

    @property
    def turn_reach(self) -> int:
        """Number of samples on each side of a reversal in which the low-pass rounds the motion."""
        return self._transient(_MAX_STEP_REMAINDER)

    @property
    def row_gain(self) -> float:
        """Gain at zero frequency of the decimation filter; below 1 for an even Chebyshev filter."""
        return 1.0 if self.settings.decimate == 1 else 10.0 ** (-2 * _RIPPLE_DB / 20)

    @property
    def needed(self) -> int:
        """Smallest number of samples of a stretch that gives a row after both filters."""
        decimate = self.settings.decimate
        order = max(self.settings.order, _DECIMATION_ORDER if decimate > 1 else 0)
        return max(_PADDING * order, 2 * decimate) + sum(self.dropped) + 1

    def check(self, samples: int, what: str = "the record") -> None:
        """Refuse settings that do not suit a record or its longest segment.

        Parameters
        ----------
        samples : int
            Number of samples of the record or segment.
        what : str
            Name of the record or segment, for messages.

        Raises
        ------
        UsageError
            The cutoff is too low, or is not below the Nyquist frequency.
        DataError
            The record is shorter than the filters' transients.
        """
        nyquist, cutoff = 0.5 / self.period, self.settings.cutoff
        lowest = _MIN_CUTOFF * nyquist
        refuse(
            UsageError,
            (
                cutoff < lowest,
                f"the cutoff {cutoff:g} Hz is too low for a record sampled at {2 * nyquist:g} "
                f"Hz. Give {lowest:g} Hz or more, and check that the time is in seconds",
            ),
            (
                cutoff >= nyquist,
                f"the cutoff {cutoff:g} Hz is not below {nyquist:g} Hz, half the sampling "
                "frequency of the record. Give a lower cutoff (about 3 to 10 times the bandwidth "
                "of the position loop), and check that the time is in seconds",
                "filter",
            ),
        )
        if samples < self.needed:
            start, end = self.dropped
            raise DataError(
                f"{what} has {samples} samples, but {self.needed} or more are needed: {start} at "
                f"the start and {end} at the end are dropped, and the filters' transients take "
                f"{self.needed - 1 - start - end}. Check that the time is in seconds "
                f"({setting('columns', {'time': 'NAME:UNIT'})}). If it is, record longer, drop "
                "fewer samples, raise the cutoff, or lower the order or the decimation.",
                code="too-short",
            )

    def remarks(self) -> tuple[str, ...]:
        """Return warnings on settings that bias the estimates; empty for none."""
        cutoff, decimate = self.settings.cutoff, self.settings.decimate
        edge = (DECIMATION_EDGE / decimate if decimate > 1 else 0.5) / self.period
        if edge <= cutoff * SAME_FILTER_FREQUENCY:
            return ()
        wanted = matching_decimation(cutoff, self.period)
        return (
            f"the motion is low-passed at {cutoff:g} Hz, but the force only at {edge:.4g} Hz, by "
            "the decimation. Motion and force are then filtered differently, which biases the "
            f"estimates of every method. Decimate by {wanted} or more, or raise the cutoff",
        )

    def motion(
        self, position: Array, velocity: Array | None = None, acceleration: Array | None = None
    ) -> tuple[Array, Array, Array]:
        """Return filtered position, velocity and acceleration of one stretch, each (N,), SI.

        Velocity and acceleration are central differences; if measured, they pass the same low-pass
        instead.
        """
        q = self.low_passed(position)
        dq = np.gradient(q, self.period) if velocity is None else self.low_passed(velocity)
        ddq = (
            np.gradient(dq, self.period) if acceleration is None else self.low_passed(acceleration)
        )
        return q, dq, ddq

    def low_passed(self, signal: Array) -> Array:
        """Return a signal of one stretch after the low-pass of the motion, (N,)."""
        return self._without_phase(self.low_pass, signal)

    @property
    def low_pass(self) -> "Sections":
        """Low-pass of the motion."""
        return _designed(self.settings.order, 2 * self.settings.cutoff * self.period)

    @property
    def decimation(self) -> "Sections":
        """Low-pass before decimation."""
        return _designed(_DECIMATION_ORDER, 0.8 / self.settings.decimate, _RIPPLE_DB)

    def reduce(self, signals: Array) -> Array:
        """Return the rows of signals of one stretch, (n,) or (n, k), from samples (N,) or (N, k).

        The signals are decimated after the decimation filter. The samples that the user drops
        (`drop`) are cut off first, as in the published recipe. By default the ends are set to 0
        instead: otherwise the decimation filter would spread the errors there, or extrapolate from
        the last kept sample and give it much weight.
        """
        weighted, (first, last) = np.array(signals, dtype=float), self.dropped
        weighted[:first] = weighted[len(weighted) - last :] = 0.0
        start, end = self.cut
        kept = weighted[start : len(weighted) - end]
        if self.settings.decimate > 1:
            kept = self._without_phase(self.decimation, kept)
        return kept[self.rows(len(signals)) - start]

    def _without_phase(self, low_pass: "Sections", signals: Array) -> Array:
        """Return signals, (N,) or (N, k), filtered forward and backward along the first axis.

        The signals are extended at both ends, by a rotation about the first and the last sample.
        """
        compiled = column_filter() if self.native else None
        if compiled is None:
            from scipy.signal import sosfiltfilt

            sections = low_pass.sections.copy()
            return np.asarray(sosfiltfilt(sections, signals, 0, padlen=low_pass.padding))
        columns = np.asarray(signals, dtype=float).reshape(len(signals), -1)
        return compiled.without_phase(
            columns, low_pass.sections, low_pass.settled, low_pass.padding
        ).reshape(signals.shape)

    def rows(self, samples: int) -> NDArray[np.int64]:
        """Return the sample numbers of the rows of one stretch of `samples` samples, (n,)."""
        low, high = self.dropped
        decimate, first = self.settings.decimate, self.cut[0]
        if self.settings.decimation == "matlab":  # aligned to the end
            first += (samples - sum(self.cut) - 1) % decimate
        # Begin at the first of these samples that is not dropped.
        first += max(-(-(low - first) // decimate), 0) * decimate
        return np.arange(first, samples - high, decimate)

    def _transient(self, level: float) -> int:
        """Return the number of samples in which a transient of the low-pass decays to a level."""
        # The slowest pole of a Butterworth filter is the one nearest the imaginary axis.
        order, cutoff = self.settings.order, self.settings.cutoff
        slowest = 2 * math.pi * cutoff * math.sin(math.pi / (2 * order))
        return math.ceil(-math.log(level) / slowest / self.period)


@dataclass(frozen=True, slots=True)
class Sections:
    """A low-pass filter in second-order sections.

    Attributes
    ----------
    sections : (s, 6) array
        Coefficients of each second-order section.
    settled : (s, 2) array
        State of the sections after a unit step has settled.
    padding : int
        Samples by which a stretch is extended at both ends.
    """

    sections: Array
    settled: Array
    padding: int


# Designing a filter takes as long as applying it to a record; the designs are pure functions.
@lru_cache(maxsize=64)
def _designed(order: int, edge: float, ripple: float = 0.0) -> Sections:
    """Return a Butterworth low-pass, or a Chebyshev low-pass of type I if a ripple is given.

    Parameters
    ----------
    order : int
        Order of the filter.
    edge : float
        Cut-off frequency relative to the Nyquist frequency.
    ripple : float
        Ripple of the pass band, dB; 0 for a Butterworth filter.
    """
    from scipy.signal import butter, cheby1, sosfilt_zi

    if ripple:
        design = cheby1(order, ripple, edge, output="sos")
    else:
        design = butter(order, edge, output="sos")
    return Sections(frozen(design), frozen(sosfilt_zi(design)), _PADDING * order)
