"""Model error of an estimate: its share of the residual, and the uncertainty of parameters by it.

In: an estimate and its filtered record. Out: `LackOfFit`, the split of the residual into a
repeating and a noise part, and `JackknifeInterval` of each parameter. Knows nothing of verdicts.

Lack of fit. The products of the residuals of two repeats at one phase of the reference have the
power of the repeating part as their mean, for any noise that is independent between repeats. The
rest of the power is pure error. Repeats are those of the longest part of the reference that recurs
after a period, to a sample; the periods are peaks of the autocorrelation of its direction.

Model error. A wrong model has the same error wherever the axis moves in the same way: the error
does not average out over neighbouring rows, as noise does, but over different motions. So rows form
groups that may share an error, and the estimate is repeated without each group. There are two
groupings, for two kinds of error: by level of speed, and by thirds of the travel. The wider
interval of the two is reported for each parameter. A group has both directions of its speed:
without one direction, friction and an offset change together, so that such groups would measure the
difference between directions instead of the error of a parameter. That difference is a term of its
own, found by the search for missing terms.

The estimate without a group is exact, ``(Z'X - Z_g'X_g)^-1 (Z'y - Z_g'y_g)``, and so is the
leverage of groups of different sizes (the correction CR3). Without this correction (CR1) the
intervals covered the true value in 93 % of the cases. Noise scatters groups too; the leverages give
the expected scatter for a noise variance, for which the larger of two estimates is taken. In a
closed loop, noise is differentiated and cancels over rows, which the HAC variance accounts for; the
noise does not cancel at the edges of groups, where White's variance is correct.

References
----------
[Fisher1922]_ for the lack of fit against the pure error of repeats.
[MacKinnon2023]_ for the cluster jackknife and its t distribution, whose degrees of freedom are the
number of groups minus 1.
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
from axisid.support.arrays import Array, BoolArray, Exact, runs

_MIN_REPEATED_TRAVEL = 0.5  # travel of the repeating part, relative to that of the reference
_MIN_CORRELATION = 0.1  # autocorrelation of the direction from which a period is examined
_MIN_REPEATED_ROWS = 50  # rows at repeating phases; with fewer, the residual is not split
# p-value of the repeating part, below which it is significant
_MAX_REPEAT_CHANCE = 1e-3
# correlation of the repeating part with that of the next row, from which it is model error:
# measured, 0.5 to 0.99 for missing terms, -0.5 for the steps of an encoder
_MIN_SMOOTHNESS = 0.25


def repeated_part(reference: Array) -> tuple[int, int, float] | None:
    """Return the longest repeating part of a reference, (N,).

    Periods are tried in the order of the peaks of the autocorrelation of its direction. For each
    period, the longest stretch is found in which the reference recurs to within a sample.

    Returns
    -------
    (int, int, float) or None
        First sample, the sample after the last repeat, and the period in samples, accurate to one
        sample over all repeats and not necessarily an integer. None if no part with half of the
        travel repeats.
    """
    from scipy.signal import correlate, find_peaks

    travel = float(np.ptp(reference))
    if not (np.isfinite(travel) and travel > 0):
        return None
    steps = np.diff(reference)
    directions = np.sign(steps)  # their autocorrelation peaks at a period; that of steps may not
    correlation = correlate(directions, directions, method="fft")[len(steps) :]
    least = _MIN_CORRELATION * float(directions @ directions)
    most_apart = 2 * float(np.sqrt(np.mean(steps**2)))  # a period may be a fraction of samples
    start, stop, period, longest = 0, 0, 0.0, 0
    # For each period, `late`, the longest stretch in which the reference recurs.
    for late in map(int, find_peaks(correlation, prominence=least)[0] + 1):
        if len(reference) - late <= longest:  # neither this nor a later peak has a longer stretch
            break
        for first, last in runs(np.abs(reference[late:] - reference[:-late]) <= most_apart):
            if (
                last - first > longest
                and np.ptp(reference[first:last]) > _MIN_REPEATED_TRAVEL * travel
            ):
                start, stop, period, longest = first, last + late, float(late), last - first
    times = 2
    while times * period < longest:  # several periods together give a more accurate period
        near = round(times * period) - 1 + np.arange(-2, 3)
        period = float(near[np.argmax(correlation[near])] + 1) / times
        times *= 2
    return (start, stop, period) if longest else None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LackOfFit(Exact):
    """Split of the residual at repeating phases of the reference into model error and noise.

    Attributes
    ----------
    period : float or None
        Period of the reference, s; null in files of moves separated by rests of different lengths.
    times : int
        Largest number of rows at one phase of the reference.
    rows : int
        Number of rows at phases with more than one row.
    share : float
        Share of the power of the residual that repeats: ``sum_g ((sum_i e_gi)^2 - sum_i e_gi^2) /
        (n_g - 1) / sum e^2`` over the phases g with n_g repeats.
    deviation : float
        Standard error of the share, HAC over the phases.
    chance : float
        One-sided p-value of the share for noise alone, by Student's t distribution.
    repeated : float
        Root mean square of the repeating part, in the unit of the left side.
    noise : float
        Root mean square of the noise, in the same unit.
    left : float
        Root mean square of the left side, in the same unit.
    smoothness : float
        Correlation of the mean residual with that of the next phase: near 1 for missing terms of a
        model, below 0 for the steps of an encoder, which repeat where the motion repeats to less
        than one step.
    time : (g,) array
        Time of each phase in the first period, from the record's first sample, s.
    mean : (g,) array
        Mean residual at each phase, in the unit of the left side.
    count : (g,) array
        Number of rows at each phase.
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
        """True if the repeating part is significant."""
        return self.chance < _MAX_REPEAT_CHANCE

    @property
    def is_smooth(self) -> bool:
        """True if the repeating part is correlated from row to row, as model error is."""
        return self.smoothness > _MIN_SMOOTHNESS

    @property
    def is_mostly_repeated(self) -> bool:
        """True if the repeating part is significant and most of the residual's power."""
        return self.is_there and self.share >= MIN_MODEL_SHARE.value

    @property
    def is_mostly_model(self) -> bool:
        """True if most of the residual's power is model error."""
        return self.is_mostly_repeated and self.is_smooth


def lack_of_fit(estimate: Estimate, data: FilteredRecord) -> LackOfFit | None:
    """Return the split of an estimate's residual into a repeating part and noise.

    Rows at the same phase of the repeating reference are compared. Products of residuals of
    different repeats give the power that repeats; the rest of the power is noise. The standard
    error is HAC over the phases.

    Parameters
    ----------
    estimate : Estimate
        Estimate whose net residuals are split, see `Estimate.net_residuals`.
    data : FilteredRecord
        Filtered record of the estimate.

    Returns
    -------
    LackOfFit or None
        None if there is no reference, or if too little of the reference repeats.
    """
    reference = data.record.reference
    repeated = None if reference is None else repeated_part(reference)
    if repeated is None:
        return None
    (start, stop, period), step = repeated, data.prefilter.decimate
    samples = estimate.rows.astype(np.int64)
    # Number of the phase of each row, as one in `step` samples is a row; then the rows whose phase
    # has more than one row.
    phases = ((samples - start) % period // step).astype(np.int64)
    inside = (start <= samples) & (samples < stop)
    again = inside & (np.bincount(phases[inside], minlength=int(period) + 1)[phases] > 1)
    places, of, count = np.unique(phases[again], return_inverse=True, return_counts=True)
    residuals = estimate.net_residuals[again]
    total = float(residuals @ residuals)
    if len(residuals) < _MIN_REPEATED_ROWS or not total > 0:
        return None
    # Share of the power that repeats, and its significance.
    power, sums = (np.bincount(of, weights=each) for each in (residuals**2, residuals))
    common = (sums**2 - power) / (count - 1)  # unbiased repeating power of all rows of a phase
    share, neighbours = float(common.sum()) / total, RowTimes(places)
    # The power is not a residual of a regression, so that the kernel alone applies.
    scatter = Hac().long_run((common - share * power)[:, None], neighbours)
    deviation = float(np.sqrt(max(scatter.matrix[0, 0], 0.0))) / total
    chance = 0.0 if share > 0 else 1.0
    if deviation > 0:
        chance = float(stdtr(max(float(scatter.freedom[0]), 1.0), -share / deviation))
    # Correlation of the mean residual of a phase with that of the next phase.
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


_MIN_MOVE_SPEED = 0.02  # of the largest speed, from which an axis counts as moving
_LEVELS_APART = 0.1  # gap between the logarithms of the peak speeds of two levels
_MIN_GROUPS = 3  # groups of rows; two do not show a scatter
# variance without a group, relative to that with all rows, beyond which the jackknife is not used
_MAX_DELETED_INFLATION = 20.0
# half width of the jackknife interval relative to that of the 95 % interval for noise, from which
# it is reported
_MIN_BAND_EXCESS = 1.5
# p-value of the groups' scatter for noise alone, where no repeats are known; each parameter is
# tested with two groupings
_MAX_BAND_CHANCE = 3e-3
_PARTS = 3  # of the travel


class JackknifeInterval(Struct, frozen=True, kw_only=True, rename={"interval": "interval_95"}):
    """Uncertainty of a parameter by the model error, from a delete-one-group jackknife.

    Attributes
    ----------
    deviation : float
        Jackknife standard error.
    interval : (float, float)
        95 % interval about the value minus its bias.
    groups : int
        Number of groups.
    by : str
        The grouping of the rows, as text.
    exceeds : bool
        True if the interval is noticeably and significantly wider than that for noise.
    """

    deviation: float
    interval: Annotated[
        tuple[float, float],
        Meta(description="By Student's distribution, with the number of groups minus 1."),
    ]
    groups: int
    by: str
    exceeds: bool


def jackknife_intervals(
    estimate: Estimate, ways: Mapping[str, NDArray[np.intp]], *, noisy: bool = True
) -> dict[str, JackknifeInterval]:
    """Return the widest jackknife interval over the groupings for each physical parameter, by name.

    Parameters
    ----------
    estimate : Estimate
    ways : mapping of str to (n,) array of int
        Group label of every row by grouping, as from `groupings`.
    noisy : bool
        True if the scatter of the groups may be noise, so that an interval must be significantly
        wider than noise explains to count as exceeding. False if repeats of the reference show that
        the residual is mostly model error.

    Returns
    -------
    dict of str to JackknifeInterval
        Empty if no grouping has a jackknife for all parameters.
    """
    by_grouping = []
    for by, labels in ways.items():
        intervals = _intervals_of_grouping(estimate, labels, by, noisy=noisy)
        if intervals:
            by_grouping.append(intervals)
    return {
        q.name: max(intervals, key=lambda each: each.interval[1] - each.interval[0])
        for q, intervals in zip(estimate.quantities, zip(*by_grouping, strict=True), strict=False)
    }


def groupings(data: FilteredRecord, rows: NDArray[np.intp]) -> dict[str, NDArray[np.intp]]:
    """Return the group label of every row, (n,), for two groupings: speed and parts of the travel.

    A level of speed has the moves with about the same peak speed. The parts of the travel are three
    equal thirds. `rows`, (n,), are the sample numbers of the rows.
    """
    from scipy.ndimage import maximum

    position, velocity, _ = data.motion
    place, speed = position[rows], np.abs(velocity) / np.abs(velocity).max()
    # A move begins where the axis starts or reverses. Moves of one level have about the same peak
    # speed: the next level begins at a gap between the logarithms of the peak speeds.
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


@dataclass(frozen=True, slots=True, kw_only=True)
class _GroupJackknife:
    """Delete-one-group jackknife of an estimate.

    Attributes
    ----------
    groups : int
    deviations : (p,) array
        Standard error of each physical parameter.
    inflation : (g, p) array
        Variance of each parameter without a group, relative to that with all rows.
    mapping : (p, k) array
        Change of the physical parameters by the sums of the scores.
    scores : (n, k) array
        Scores of the rows: instruments times residual.
    """

    groups: int
    deviations: Array
    inflation: Array
    mapping: Array
    scores: Array


def _delete_group_jackknife(estimate: Estimate, labels: NDArray[np.intp]) -> _GroupJackknife | None:
    """Return the delete-one-group jackknife of the physical parameters (CR3).

    `labels`, (n,), are the groups of the rows. The estimate without group g is
    ``theta_(g) = (Z'X - Z_g'X_g)^-1 (Z'y - Z_g'y_g)``. The variance by G groups is

        ``V = (G - 1)/G sum_g (theta_(g) - theta)^2``  [MacKinnon2023]_.

    Returns
    -------
    _GroupJackknife or None
        None if there are fewer than 3 groups, or if the variance of a parameter without a group is
        more than 20 times that with all rows.
    """
    names, groups = np.unique(labels, return_inverse=True)
    count = len(names)
    if count < _MIN_GROUPS:
        return None
    # Products of instruments and columns, and sums of the scores, of each group; scaled columns.
    scale = np.linalg.norm(estimate.X, axis=0)
    size = np.linalg.norm(estimate.slope_columns, axis=0)
    X, Z, mapping = estimate.X / scale, estimate.slope_columns / size, estimate.jacobian / scale
    scores = estimate.score_columns * estimate.net_residuals[:, None] / size
    members = [groups == g for g in range(count)]
    products = np.array([Z[rows].T @ X[rows] for rows in members])
    sums = np.array([scores[rows].sum(axis=0) for rows in members])
    # Map of the sums of scores to the parameters: without each group, and with all rows.
    try:
        without = mapping @ np.linalg.inv(products.sum(axis=0) - products)
        every = mapping @ np.linalg.inv(products.sum(axis=0))
    except np.linalg.LinAlgError:
        return None
    inflation = (without * mapping).sum(axis=2) / (every * mapping).sum(axis=1)
    if not np.all((inflation > 0) & (inflation < _MAX_DELETED_INFLATION)):
        return None
    changes = np.einsum("gpk,gk->gp", without, sums.sum(axis=0) - sums) - every @ sums.sum(axis=0)
    return _GroupJackknife(
        groups=count,
        deviations=np.sqrt((count - 1) / count * np.sum(changes**2, axis=0)),
        inflation=inflation,
        mapping=every,
        scores=scores,
    )


def _exceeds_noise(estimate: Estimate, jackknife: _GroupJackknife, dof: Array) -> BoolArray:
    """Return True for each parameter whose groups scatter significantly more than by noise, (p,).

    The jackknife variance is compared with that expected from noise by an F test. The leverage
    ``h_g`` of a group is its inflation minus 1. Noise of the variance ``v = max(v_HAC, v_White)``
    gives the jackknife the expected variance ``v max((G - 1)/G sum_g h_g, 1)``. The ratio of the
    jackknife variance to it is F distributed with ``(sum_g h_g)^2 / sum_g h_g^2 - 1`` degrees of
    freedom, by the effective number of groups of equal leverage, and those of v [MacKinnon2023]_.

    Parameters
    ----------
    estimate : Estimate
    jackknife : _GroupJackknife
    dof : (p,) array
        Degrees of freedom of the chosen covariance.
    """
    # Variance that noise gives the jackknife, and the degrees of freedom of both variances.
    variances, scores = np.diag(estimate.covariance), jackknife.scores
    shrunk = (jackknife.groups - 1) / jackknife.groups
    excess = np.maximum(jackknife.inflation - 1, 0.0)
    white = np.sum((scores @ jackknife.mapping.T) ** 2, axis=0)
    expected = np.maximum(variances, white) * np.maximum(shrunk * excess.sum(axis=0), 1.0)
    groups_dof = np.maximum(excess.sum(axis=0) ** 2 / np.sum(excess**2, axis=0) - 1, 1.0)
    noise_dof = np.where(white > variances, len(scores) - scores.shape[1], dof)
    F = np.divide(
        jackknife.deviations**2, expected, out=np.zeros_like(expected), where=expected > 0
    )
    is_beyond_chance = fdtrc(groups_dof, noise_dof, F) < _MAX_BAND_CHANCE
    return np.asarray(is_beyond_chance | ~(variances > 0))


def _intervals_of_grouping(
    estimate: Estimate, labels: NDArray[np.intp], by: str, *, noisy: bool
) -> list[JackknifeInterval]:
    """Return the jackknife interval of each of p parameters for one grouping of the rows.

    Empty if the grouping has no jackknife, see `_delete_group_jackknife`.

    Parameters
    ----------
    estimate : Estimate
    labels : (n,) array of int
        Group of every row.
    by : str
        Name of the grouping.
    noisy : bool
        True if the scatter of the groups may be noise. An interval then exceeds the interval for
        noise only if it is also significant by `_exceeds_noise`.
    """
    jackknife = _delete_group_jackknife(estimate, labels)
    if jackknife is None:
        return []
    # Half widths of the jackknife intervals, and of the intervals for noise.
    quantile = (1 + INTERVAL_LEVEL.value) / 2
    reach = stdtrit(jackknife.groups - 1, quantile) * jackknife.deviations
    variances, dof = np.diag(estimate.covariance), estimate.freedom[estimate.chosen]
    half = stdtrit(dof, quantile) * np.sqrt(np.maximum(variances, 0.0))
    exceeds = reach > _MIN_BAND_EXCESS * half
    if noisy:
        exceeds &= _exceeds_noise(estimate, jackknife, dof)
    return [
        JackknifeInterval(
            deviation=float(d),
            interval=(c - r, c + r),
            groups=jackknife.groups,
            by=by,
            exceeds=bool(e),
        )
        for d, r, c, e in zip(
            jackknife.deviations, reach.tolist(), estimate.corrected.tolist(), exceeds, strict=True
        )
    ]
