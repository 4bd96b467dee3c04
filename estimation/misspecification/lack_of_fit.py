"""What a model leaves, split by repeats: into what is left again each time, and noise.

In: an estimate and the record behind its filter. Out: `LackOfFit`. Knows nothing of verdicts.

The products of the residuals of two repeats at one phase have the power of what repeats as their
mean, whatever the noise is, as long as that of one repeat is independent of that of another. What
they leave of the power is pure error. Repeats are those of the longest part of the reference that
comes again after a period, to a sample; the correlation of its directions has the periods.

References
----------
[Fisher1922]_ for the lack of fit against the pure error of repeats.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtr

from axisid.estimation.estimates import Estimate
from axisid.estimation.regression import Hac
from axisid.estimation.signals import FilteredRecord, RowTimes
from axisid.estimation.thresholds import MIN_MODEL_SHARE
from axisid.support.arrays import Array, Exact, runs

_MIN_REPEATED_TRAVEL = 0.5  # of the reference's, that a part which repeats has
_MIN_CORRELATION = 0.1  # of directions with those a period later, from which it is looked at
_MIN_REPEATED_ROWS = 50  # rows at phases that repeat; of fewer, residuals are not split
# that noise alone repeats as much, up to which something of the residuals repeats
_MAX_REPEAT_CHANCE = 1e-3
# correlation of what repeats with that of the next row, from which it is the model's: measured,
# 0.5 to 0.99 for missing terms, -0.5 for the steps of an encoder
_MIN_SMOOTHNESS = 0.25


def repeated_part(reference: Array) -> tuple[int, int, float] | None:
    """The longest part of a reference, (N,), that comes again.

    Its first sample, the one after its last repeat, and the period in samples, which need be no
    whole number: to a sample over all repeats. None where no part comes again that moves far.
    """
    from scipy.signal import correlate, find_peaks

    travel = float(np.ptp(reference))
    if not (np.isfinite(travel) and travel > 0):
        return None
    steps = np.diff(reference)
    directions = np.sign(steps)  # whose correlation has an edge at a period, as steps need not
    correlation = correlate(directions, directions, method="fft")[len(steps) :]
    least = _MIN_CORRELATION * float(directions @ directions)
    most_apart = 2 * float(np.sqrt(np.mean(steps**2)))  # periods need be no whole samples
    start, stop, period, longest = 0, 0, 0.0, 0
    for late in map(int, find_peaks(correlation, prominence=least)[0] + 1):
        if len(reference) - late <= longest:  # as of multiples of a period
            break
        for first, last in runs(np.abs(reference[late:] - reference[:-late]) <= most_apart):
            if (
                last - first > longest
                and np.ptp(reference[first:last]) > _MIN_REPEATED_TRAVEL * travel
            ):
                start, stop, period, longest = first, last + late, float(late), last - first
    times = 2
    while times * period < longest:  # The more periods are between, the better they tell one.
        near = round(times * period) - 1 + np.arange(-2, 3)
        period = float(near[np.argmax(correlation[near])] + 1) / times
        times *= 2
    return (start, stop, period) if longest else None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LackOfFit(Exact):
    """What an estimate leaves at phases of the reference that repeat.

    Attributes
    ----------
    period : float or None
        After which it repeats, s; null in files of moves that rests of other lengths part.
    times : int
        How often what repeats most often does.
    rows : int
        At phases that repeat.
    share : float
        Of these rows' power, what repeats.
    deviation : float
        Of the share, HAC over the phases.
    chance : float
        That noise alone repeats as much, by Student's distribution.
    repeated : float
        Root mean square of what repeats, in the unit of the left side.
    noise : float
        The same of the noise.
    left : float
        The same of the left side.
    smoothness : float
        Correlation of the mean residual with that of the next phase: near 1 for what a model
        lacks, below 0 for the steps of an encoder, which repeat where the motion does to less than
        one of them.
    time : (g,) array
        Of the phases in the first period, since the record's first sample, s.
    mean : (g,) array
        Mean residual by phase.
    count : (g,) array
        Repeats by phase.
    """

    period: float | None
    times: int
    rows: int
    share: float
    deviation: float
    chance: float
    repeated: float
    noise: float
    left: float
    smoothness: float
    time: Array
    mean: Array
    count: Array

    @property
    def is_there(self) -> bool:
        """Whether more repeats than by chance."""
        return self.chance < _MAX_REPEAT_CHANCE

    @property
    def is_smooth(self) -> bool:
        """Whether it goes on from row to row."""
        return self.smoothness > _MIN_SMOOTHNESS

    @property
    def is_mostly_repeated(self) -> bool:
        """Whether most of what is left repeats: noise is not what it is."""
        return self.is_there and self.share >= MIN_MODEL_SHARE.value

    @property
    def is_mostly_model(self) -> bool:
        """Whether most of what is left is the model's."""
        return self.is_mostly_repeated and self.is_smooth


def lack_of_fit(estimate: Estimate, data: FilteredRecord) -> LackOfFit | None:
    """Split the net residuals of an estimate by the repeats of its record's reference.

    Returns
    -------
    LackOfFit or None
        None where there is no reference, or too little of it repeats.
    """
    reference = data.record.reference
    repeated = None if reference is None else repeated_part(reference)
    if repeated is None:
        return None
    (start, stop, period), step = repeated, data.prefilter.decimate
    samples = estimate.rows.astype(np.int64)
    # Of the samples one in so many is a row.
    phases = ((samples - start) % period // step).astype(np.int64)
    inside = (start <= samples) & (samples < stop)
    again = inside & (np.bincount(phases[inside], minlength=int(period) + 1)[phases] > 1)
    places, of, count = np.unique(phases[again], return_inverse=True, return_counts=True)
    residuals = estimate.net_residuals[again]
    total = float(residuals @ residuals)
    if len(residuals) < _MIN_REPEATED_ROWS or not total > 0:
        return None
    power, sums = (np.bincount(of, weights=each) for each in (residuals**2, residuals))
    common = (sums**2 - power) / (count - 1)  # of all rows of a phase, without bias
    share, neighbours = float(common.sum()) / total, RowTimes(places)
    # Of residuals on no regressor: the kernel alone.
    scatter = Hac().long_run((common - share * power)[:, None], neighbours)
    deviation = float(np.sqrt(max(scatter.matrix[0, 0], 0.0))) / total
    chance = 0.0 if share > 0 else 1.0
    if deviation > 0:
        chance = float(stdtr(max(float(scatter.freedom[0]), 1.0), -share / deviation))
    mean = sums / count
    late, early = neighbours.pairs(1)
    size = float(np.sqrt(np.sum(mean[late] ** 2) * np.sum(mean[early] ** 2)))
    return LackOfFit(
        period=period * estimate.period,
        times=int(count.max()),
        rows=len(residuals),
        share=share,
        deviation=deviation,
        chance=chance,
        repeated=float(np.sqrt(max(share, 0.0) * total / len(residuals))),
        noise=float(np.sqrt(np.clip(1 - share, 0.0, 1.0) * total / len(residuals))),
        left=float(np.sqrt(np.mean(estimate.y[again] ** 2))),
        time=data.record.time[start + places * step] - data.record.time[0],
        mean=mean,
        count=count.astype(float),
        smoothness=float(mean[late] @ mean[early]) / size if size > 0 else 0.0,
    )
