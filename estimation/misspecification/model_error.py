"""How much of what an estimate leaves is the model's error, and how far that may move parameters.

In: an estimate and the record behind its filter. Out: `LackOfFit`, of what is left again at each
repeat, and `JackknifeInterval` of each parameter. Knows nothing of verdicts.

The products of the residuals of two repeats at one phase have the power of what repeats as their
mean, whatever the noise is, as long as that of one repeat is independent of that of another. What
they leave of the power is pure error. Repeats are those of the longest part of the reference that
comes again after a period, to a sample; the correlation of its directions has the periods.

A model that is not quite right is wrong in the same way wherever the axis moves in the same way:
its error does not average out over neighbours, as noise does, but over motions that differ. So rows
are put into groups that may share an error, and the estimate is made again without each. There are
two ways to form them, after two ways to be wrong: by level of speed, and by thirds of the travel.
What is told of a parameter is the wider band of the two. A group has both directions of its speed:
without one direction friction and an offset change together, so that such groups tell the
difference between directions and not how far a parameter may be off. That difference is a term of
its own, which the search for missing terms names.

The estimate without a group is exact, ``(Z'X - Z_g'X_g)^-1 (Z'y - Z_g'y_g)``, and with it the
leverage of groups of different sizes (the correction that is called CR3). Without it (CR1) bands
held the truth in 93 %. Noise scatters groups too: by how much, the leverages tell of its variance,
which is the larger of two. Behind a loop noise is differentiated and cancels over rows, which HAC
sees; it does not at the edges of groups, where White's variance is what it has.

References
----------
[Fisher1922]_ for the lack of fit against the pure error of repeats.
[MacKinnon2023]_ for the cluster jackknife and its t distribution with groups less one.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta, Struct
from numpy.typing import NDArray
from scipy.special import fdtrc, stdtr, stdtrit

from axisid.estimation.estimates import Estimate
from axisid.estimation.regression import Hac
from axisid.estimation.signals import FilteredRecord, RowTimes
from axisid.estimation.thresholds import INTERVAL_LEVEL, MIN_MODEL_SHARE
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


_MIN_MOVE_SPEED = 0.02  # of the largest speed, from which an axis moves
_LEVELS_APART = 0.1  # of the logarithms of the peaks of one level of speed and of the next
_MIN_GROUPS = 3  # of rows; two do not tell how far they scatter
# times the variance with all; without the group the estimate is not believed beyond
_MAX_DELETED_INFLATION = 20.0
# band of the model's error by the half of the 95 % interval, from which it is shown
_MIN_BAND_EXCESS = 1.5
# that noise alone scatters groups as far, where no repeats tell it; each parameter is looked at
# under two ways to form groups
_MAX_BAND_CHANCE = 3e-3
_PARTS = 3  # of the travel


class JackknifeInterval(Struct, frozen=True, kw_only=True, rename={"interval": "interval_95"}):
    """How far the model's error may move a parameter.

    Attributes
    ----------
    deviation : float
        Delete-one-group jackknife.
    interval : (float, float)
        95 %, about the value less its bias.
    groups : int
    by : str
        What the groups of rows are of, in words.
    exceeds : bool
        Whether it is noticeably wider than the interval for noise, and by more than chance.
    """

    deviation: float
    interval: Annotated[
        tuple[float, float], Meta(description="Student's, of as many groups less one.")
    ]
    groups: int
    by: str
    exceeds: bool


def jackknife_intervals(
    estimate: Estimate, ways: Mapping[str, NDArray[np.intp]], *, noisy: bool = True
) -> dict[str, JackknifeInterval]:
    """The wider band of each physical parameter, by name.

    Parameters
    ----------
    estimate : Estimate
    ways : mapping of str to (n,) array of int
        To form groups, in words, with the label of every row's, as by `groupings`.
    noisy : bool
        Whether noise may be what groups scatter by; not where repeats show that it is not.

    Returns
    -------
    dict of str to JackknifeInterval
        Empty where no groups of rows tell all parameters.
    """
    by_grouping = (_bands(estimate, labels, by, noisy=noisy) for by, labels in ways.items())
    return {
        q.name: max(bands, key=lambda band: band.interval[1] - band.interval[0])
        for q, bands in zip(
            estimate.quantities, zip(*filter(None, by_grouping), strict=True), strict=False
        )
    }


def groupings(data: FilteredRecord, rows: NDArray[np.intp]) -> dict[str, NDArray[np.intp]]:
    """Ways to form groups, in words, with the label of every row's, (n,)."""
    from scipy.ndimage import maximum

    position, velocity, _ = data.motion
    place, speed = position[rows], np.abs(velocity) / np.abs(velocity).max()
    # Moves begin where the axis does, or turns; those of one level are about as fast.
    direction = np.where(speed > _MIN_MOVE_SPEED, np.sign(velocity), 0.0)
    moves = np.cumsum((direction != 0) & (np.diff(direction, prepend=0.0) != 0))
    peaks, of = np.unique(maximum(speed, moves, moves[rows]), return_inverse=True)
    apart = np.diff(np.log(peaks + _MIN_MOVE_SPEED), prepend=0.0) > _LEVELS_APART
    levels = np.cumsum(apart, dtype=np.intp)[of]
    edges = place.min() + np.ptp(place) * np.arange(1, _PARTS) / _PARTS
    return {
        "speed": levels,
        "thirds of the travel": np.searchsorted(edges, place, side="right"),
    }


def _bands(
    estimate: Estimate, labels: NDArray[np.intp], by: str, *, noisy: bool
) -> list[JackknifeInterval]:
    """Of each parameter; none where groups are too few, or one of them tells too much."""
    names, groups = np.unique(labels, return_inverse=True)
    if (count := len(names)) < _MIN_GROUPS:
        return []
    scale = np.linalg.norm(estimate.X, axis=0)
    size = np.linalg.norm(estimate.slope_columns, axis=0)
    X, Z, mapping = estimate.X / scale, estimate.slope_columns / size, estimate.jacobian / scale
    scores = estimate.score_columns * estimate.net_residuals[:, None] / size
    members = [groups == g for g in range(count)]
    products = np.array([Z[rows].T @ X[rows] for rows in members])
    sums = np.array([scores[rows].sum(axis=0) for rows in members])
    try:
        without = mapping @ np.linalg.inv(products.sum(axis=0) - products)
        every = mapping @ np.linalg.inv(products.sum(axis=0))
    except np.linalg.LinAlgError:
        return []
    inflation = (without * mapping).sum(axis=2) / (every * mapping).sum(axis=1)
    if not np.all((inflation > 0) & (inflation < _MAX_DELETED_INFLATION)):
        return []
    changes = np.einsum("gpk,gk->gp", without, sums.sum(axis=0) - sums) - every @ sums.sum(axis=0)
    shrunk = (count - 1) / count
    deviations = np.sqrt(shrunk * np.sum(changes**2, axis=0))
    reach = stdtrit(count - 1, (1 + INTERVAL_LEVEL.value) / 2) * deviations
    variances, dof = np.diag(estimate.covariance), estimate.freedom[estimate.chosen]
    half = stdtrit(dof, (1 + INTERVAL_LEVEL.value) / 2) * np.sqrt(np.maximum(variances, 0.0))
    exceeds = reach > _MIN_BAND_EXCESS * half
    if noisy:
        excess = np.maximum(inflation - 1, 0.0)  # of a parameter by each group
        white = np.sum((scores @ every.T) ** 2, axis=0)
        expected = np.maximum(variances, white) * np.maximum(shrunk * excess.sum(axis=0), 1.0)
        groups_dof = np.maximum(excess.sum(axis=0) ** 2 / np.sum(excess**2, axis=0) - 1, 1.0)
        noise_dof = np.where(white > variances, len(scores) - scores.shape[1], dof)
        F = np.divide(deviations**2, expected, out=np.zeros_like(expected), where=expected > 0)
        exceeds &= (fdtrc(groups_dof, noise_dof, F) < _MAX_BAND_CHANCE) | ~(variances > 0)
    return [
        JackknifeInterval(
            deviation=float(d), interval=(c - r, c + r), groups=count, by=by, exceeds=bool(e)
        )
        for d, r, c, e in zip(
            deviations, reach.tolist(), estimate.corrected.tolist(), exceeds, strict=True
        )
    ]
