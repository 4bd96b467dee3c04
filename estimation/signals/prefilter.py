"""How a record becomes the rows of a regression: a user's settings and nothing else.

What they do to a record of some sampling period is `SampledFilter`'s.

References
----------
[Brunot2015]_ section on data filtering; [Janot2019]_ for the record's own recipe.
"""

import math
from dataclasses import dataclass, replace
from typing import Any, Literal

from axisid.estimation.choices import check_among
from axisid.estimation.records import check_sample_period
from axisid.support.errors import UsageError
from axisid.support.real_numbers import is_real, is_whole
from axisid.support.user_values import quoted

# ratio of two cut-offs that are one, or of two periods for which counts of samples stay
SAME_FILTER_FREQUENCY = 1.01
# of the sampling frequency: 60 Hz from 300 Hz on, two in five of the Nyquist frequency below
_MAX_DEFAULT_CUTOFF = 0.2

#: Edge of the decimation filter, of the rate that it leaves.
DECIMATION_EDGE = 0.4


class _OpenCutoff(float):
    """A cut-off that nobody gave: it follows the record's rate."""


class _OpenDecimation(int):
    """A decimation that nobody gave: it follows the cut-off and the record's rate."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Prefilter:
    """How a record becomes the rows of a regression.

    Attributes
    ----------
    cutoff : float
        Of the Butterworth low-pass on the position, Hz. Where it is not given, 60 Hz, or a fifth
        of the record's sampling frequency where that is below 300 Hz.
    order : int
        Of the Butterworth filter (once; it is applied forward and backward).
    decimate : int
        One row in so many is kept; 1 keeps all and applies no decimation filter. Where it is not
        given, 10, or more where the force would else be filtered less than the motion.
    decimation : {"matlab", "scipy"}
        Which rows: aligned to the record's end as MATLAB's ``decimate``, or to its start as
        SciPy's. The filter is the same: Chebyshev type I, order 8, 0.05 dB, forward and backward.
    drop : (int, int) or None
        Samples cut off at start and end, before decimation. None gives the low-pass transient
        (decay to 1e-3) at both ends no weight, where the filters continue the record from its first
        and its last sample.
    hold : {"raw", "zoh"} or None
        ``zoh`` pairs the acceleration at a sample with the mean of the forces held before and
        after it, since a drive holds its force over the period; ``raw`` with the force after it,
        as the published recipe does. None takes ``zoh`` for a control that a drive holds, and
        ``raw`` where nothing is held: a measured force, or a continuous law.
    reversals : {"keep", "leave-out"} or None
        ``leave-out`` gives the samples near a reversal or a rest no weight, before the decimation:
        there the low-pass rounds what friction does at once, and at rest noise decides its sign.
        None leaves them out for an axis whose force depends on the direction of motion, unless a
        parameter would then lose more than a third of what all records together tell of it, rests
        apart, as an inertia does where the axis accelerates only as it turns, or Coulomb friction
        at a low cut-off; ``keep`` is what the published recipe does.

    Raises
    ------
    UsageError
        A setting makes no sense for any record.
    """

    cutoff: float = _OpenCutoff(60.0)
    order: int = 4
    decimate: int = _OpenDecimation(10)
    decimation: Literal["matlab", "scipy"] = "matlab"
    drop: tuple[int, int] | None = None
    hold: Literal["raw", "zoh"] | None = None
    reversals: Literal["keep", "leave-out"] | None = None

    def __post_init__(self) -> None:
        ends = (0, 0) if self.drop is None else self.drop
        pair = isinstance(ends, (tuple, list)) and len(ends) == 2
        whole = (self.order, self.decimate, *(ends if pair else ()))
        if not pair or not all(is_whole(n) and is_real(n) for n in whole):
            raise UsageError(
                f"order {quoted(self.order)}, decimation {quoted(self.decimate)} and drop "
                f"{quoted(self.drop)}: give whole numbers, and two of them to drop."
            )
        if not is_real(self.cutoff):
            raise UsageError(
                f"the cutoff is {quoted(self.cutoff)}; give a number of hertz.", code="cutoff-type"
            )
        if not (math.isfinite(self.cutoff) and self.cutoff > 0):
            raise UsageError(
                f"the cutoff is {self.cutoff!r} Hz; give a positive number.",
                code="cutoff-not-positive",
            )
        if not 1 <= self.order <= 10:
            raise UsageError(
                f"the filter order is {self.order!r}; give 1 to 10.", code="filter-order"
            )
        if self.decimate < 1:
            raise UsageError(
                f"the decimation is {self.decimate!r}; give 1 (keep every row) or more.",
                code="bad-decimation",
            )
        choices = (
            ("row alignment", self.decimation or "none", ("matlab", "scipy")),
            ("hold", self.hold, ("raw", "zoh")),
            ("way with reversals", self.reversals, ("keep", "leave-out")),
        )
        check_among(*(row for row in choices if row[1] is not None))
        if self.drop is not None and min(self.drop) < 0:
            raise UsageError(
                f"the rows to drop are {self.drop!r}; give 0 or more at each end.", code="bad-drop"
            )

    @classmethod
    def given(cls, prefilter: object) -> "Prefilter":
        """What was given as a prefilter; the settings by default where nothing was.

        Raises
        ------
        UsageError
            It is none.
        """
        if prefilter is None:
            return cls()
        if not isinstance(prefilter, Prefilter):
            raise UsageError(
                f"the prefilter is {quoted(prefilter)}; give a Prefilter, or leave it out.",
                code="prefilter-type",
            )
        return prefilter

    @classmethod
    def suited(cls, period: float, **settings: Any) -> "Prefilter":
        """Settings for a sampling period in s, cut-off and decimation chosen where not among them.

        Raises
        ------
        UsageError
            The period is no positive number, or a setting makes no sense.
        """
        check_sample_period(period)
        return cls(**settings).at_rate_of(period)

    def at_rate_of(self, period: float) -> "Prefilter":
        """The settings with what was left open of cut-off and decimation chosen for a period, s."""
        cutoff, decimate = self.cutoff, self.decimate
        if isinstance(cutoff, _OpenCutoff):
            cutoff = min(float(cutoff), _MAX_DEFAULT_CUTOFF / period)
        if isinstance(decimate, _OpenDecimation):
            decimate = max(int(decimate), matching_decimation(cutoff, period))
        return replace(self, cutoff=float(cutoff), decimate=int(decimate))

    def at_period(self, designed: float, period: float) -> "Prefilter":
        """The same filter for a record of another period: edges in Hz stay, counts follow.

        Parameters
        ----------
        designed, period : float
            Sampling periods that the settings are for, and of the record, s.
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


def matching_decimation(cutoff: float, period: float) -> int:
    """Rows to keep one of, so that the decimation filter's edge is at the cut-off or below."""
    return max(2, math.ceil(DECIMATION_EDGE / (cutoff * period) - 1e-9))
