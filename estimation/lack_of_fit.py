"""What a model leaves, split by repeats: into what is left again each time, and noise.

In: an estimate and the record behind its filter. Out: `LackOfFit`, and by how far parameters
scatter where moves are left out. Knows nothing of verdicts.

The products of the residuals of two repeats at one phase have the power of what repeats as their
mean, whatever the noise is, as long as that of one repeat is independent of that of another. What
they leave of the power is pure error.

Moves are stretches of motion about one largest speed, as long as it is not slow between. Where a
reference repeats, the same move comes after the same one, or after a rest. Moves are compared with
one another, sample by sample, not the whole with itself: so repeats are found that rests of any
length part, and in the middle of others.

A band for the model's error is how far parameters scatter where a part of the record is left out. A
model that is not quite right is wrong in the same way wherever the axis moves in the same way: its
error does not average out over neighbours, as noise does, but over moves that differ. So rows are
put into groups that may share an error, and the estimate is made again without each. There are
three ways to form them, after three ways to be wrong: by speed and direction, by speed alone, as
what depends on the position is alike in both directions, and by thirds of the travel. What is told
of a parameter is the widest band of the three.

The estimate without a group is exact, ``(Z'X - Z_g'X_g)^-1 (Z'y - Z_g'y_g)``, and with it the
leverage of groups of different sizes (the correction that is called CR3). Without it (CR1) bands
held the truth in 93 % in place of 98 % of `benchmarks/model_error.py`. Noise scatters groups too:
by how much, the leverages tell of its variance, which is the larger of two. Behind a loop noise is
differentiated and cancels over rows, which HAC sees; it does not at the edges of groups, where
White's variance is what it has.

References
----------
[Fisher1922]_ for the lack of fit against the pure error of repeats. [MacKinnon2023]_ for the
cluster jackknife and its t distribution with groups less one.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Annotated

import numpy as np
from msgspec import Meta, Struct
from numpy.typing import NDArray
from scipy.special import fdtrc, stdtr, stdtrit

from axisid.estimation.estimates import Estimate
from axisid.estimation.regression import Hac
from axisid.estimation.signals import FilteredRecord
from axisid.estimation.thresholds import INTERVAL_LEVEL, MIN_MODEL_SHARE
from axisid.support.arrays import Array, Exact, MaybeInfinite

_MIN_MOVE_SPEED = 0.02  # of the largest speed, that a move has to reach
_MAX_LEVEL_SPREAD = 0.1  # relative difference of largest speeds of one level
_MIN_SPEED_OF_A_MOVE = 1e-3  # of the largest speed; slower is between two moves

Index = NDArray[np.intp]

_TURN = 3  # samples that a reversal may be slow for; a rest is longer
# of the reference's travel, between two moves; logged digits differ by less, others by more
_MAX_REPEAT_DIFFERENCE = 1e-4
_SHIFTS = (0, -1, 1, -2, 2)  # samples by which last digits may move the ends of a move
_ENDS = 2  # samples at both ends of a move that are not compared
_REST = -1  # what is before a move that begins at rest
_NONE = -1
_MIN_REPEATED_ROWS = 50  # rows at phases that repeat; of fewer, residuals are not split
# that noise alone repeats as much, up to which something of the residuals repeats
_MAX_REPEAT_CHANCE = 1e-3
# correlation of what repeats with that of the next row, from which it is the model's: measured,
# 0.5 to 0.99 for missing terms, -0.5 for the steps of an encoder
_MIN_SMOOTHNESS = 0.25
_APART = 1 << 32  # between the phases of two moves
_MIN_GROUPS = 3  # of rows; two do not tell how far they scatter
# times the variance with all; without the group the estimate is not believed beyond
_MAX_DELETED_INFLATION = 20.0
# band of the model's error by the half of the 95 % interval, from which it is shown
_MIN_BAND_EXCESS = 1.5
# that noise alone scatters groups as far, where no repeats tell it; each parameter is looked at
# under three ways to form groups
_MAX_BAND_CHANCE = 3e-3
_PARTS = 3  # of the travel


@dataclass(frozen=True, slots=True, kw_only=True)
class Moves:
    """Moves in the order of time.

    Attributes
    ----------
    starts, stops : (m,) array of int
        First sample of each, and the one after its last. One begins where the other ends, but for
        rests.
    speeds : (m,) array
        Where each is fastest, with the sign of the direction.
    """

    starts: Index
    stops: Index
    speeds: Array

    def __len__(self) -> int:
        return len(self.starts)

    @property
    def levels(self) -> Index:
        """Number of the speed level of each move, from the slowest, (m,)."""
        sizes, level, lowest = np.abs(self.speeds), -1, -np.inf
        labels = np.zeros(len(sizes), dtype=np.intp)
        for i in np.argsort(sizes, kind="stable"):
            # Sizes of one level are alike.
            if level < 0 or sizes[i] > lowest * (1 + _MAX_LEVEL_SPREAD):
                level, lowest = level + 1, float(sizes[i])
            labels[i] = level
        return labels


def moves_of(velocity: Array) -> Moves:
    """The moves of a velocity, (N,): of a reference, or filtered."""
    from scipy.signal import find_peaks

    top = float(np.abs(velocity).max(initial=0.0))
    speed = np.where(np.abs(velocity) > _MIN_SPEED_OF_A_MOVE * top, np.abs(velocity), 0.0)
    valleys, shape = find_peaks(-speed, prominence=_MIN_MOVE_SPEED * top, plateau_size=1)
    falls = shape["prominences"] >= speed[valleys]  # by half of the lower speed beside it
    stops, starts = shape["left_edges"][falls], shape["right_edges"][falls] + 1
    turns = (starts - stops <= _TURN) | (speed[valleys[falls]] > 0)
    stops[turns] = starts[turns] = (stops[turns] + starts[turns]) // 2
    moving = np.flatnonzero(speed)
    first, last = (moving[0], moving[-1] + 1) if len(moving) else (0, 1)
    starts, stops = np.append(first, starts), np.append(stops, last)
    fastest = [a + int(np.argmax(speed[a:b])) for a, b in zip(starts, stops, strict=True)]
    fast = speed[fastest] > _MIN_MOVE_SPEED * top
    return Moves(starts=starts[fast], stops=stops[fast], speeds=velocity[fastest][fast])


@dataclass(frozen=True, slots=True, kw_only=True)
class Repeats:
    """Which samples of a record are the same phase of the same move.

    Attributes
    ----------
    move : (N,) array of int
        Number of the repeated move that a sample is in; -1 in none.
    offset : (N,) array of int
        Samples since that move began.
    period : int or None
        Samples after which all of it repeats; None where moves repeat in another order.
    times : int
        How often the move that repeats most often does.
    """

    move: Index
    offset: Index
    period: int | None
    times: int


def repeats_of(reference: Array, spans: tuple[tuple[int, int], ...]) -> Repeats | None:
    """What repeats in a reference, (N,), with gaps between its spans; None where nothing does."""
    travel = float(np.ptp(reference))
    if not (np.isfinite(travel) and travel > 0):
        return None
    tolerance = _MAX_REPEAT_DIFFERENCE * travel
    pieces = [(a, moves_of(np.diff(reference[a:b]))) for a, b in spans]
    moves = Moves(
        starts=np.concatenate([a + m.starts for a, m in pieces]),
        stops=np.concatenate([a + m.stops for a, m in pieces]),
        speeds=np.concatenate([m.speeds for _, m in pieces]),
    )
    kinds, shifts = _kinds(reference, moves, tolerance)
    before = np.where(moves.starts[1:] > moves.stops[:-1], _REST, kinds[:-1])
    # How the record came to the first move of a span is not in it.
    first = np.cumsum([0, *(len(m) for _, m in pieces)])
    places = defaultdict[tuple[int, int], list[int]](list)
    for i in np.setdiff1d(np.arange(len(moves)), first).tolist():
        places[int(kinds[i]), int(before[i - 1])].append(i)
    repeated = [same for same in places.values() if len(same) > 1]
    if not repeated:
        return None
    size, begins = len(reference), np.maximum(moves.starts + shifts, 0)
    move, offset = np.full(size, _NONE, dtype=np.intp), np.zeros(size, dtype=np.intp)
    for number, same in enumerate(repeated):
        length = int((moves.stops - moves.starts)[same].min())
        for begin in begins[same]:
            stop = min(int(begin) + length, size)
            move[begin:stop] = number
            offset[begin:stop] = np.arange(stop - begin)
    used = np.flatnonzero(move != _NONE)
    inside = reference[used[0] : used[-1] + 1]
    lags = sorted({int(lag) for same in repeated for lag in np.diff(begins[same])})
    periods = (
        lag
        for lag in lags
        if 0 < lag < len(inside) and np.abs(inside[lag:] - inside[:-lag]).max() <= tolerance
    )
    return Repeats(
        move=move,
        offset=offset,
        period=next(periods, None),
        times=max(map(len, repeated)),
    )


def _kinds(reference: Array, moves: Moves, tolerance: float) -> tuple[Index, Index]:
    """Which moves are the same, by the number of the first such, and their shifts against it."""
    kinds, shifts = np.arange(len(moves)), np.zeros(len(moves), dtype=np.intp)
    lengths = moves.stops - moves.starts
    near = tolerance + max(_SHIFTS) * np.abs(np.diff(reference)).max()
    for i, begin in enumerate(moves.starts):
        similar = (kinds[:i] == np.arange(i)) & (np.abs(lengths[:i] - lengths[i]) <= max(_SHIFTS))
        similar &= np.abs(reference[moves.starts[:i]] - reference[begin]) <= near
        similar &= np.sign(moves.speeds[:i]) == np.sign(moves.speeds[i])
        for j, shift in product(np.flatnonzero(similar), _SHIFTS):
            first = reference[moves.starts[j] + _ENDS : moves.stops[j] - _ENDS]
            other = reference[begin + _ENDS + shift :][: len(first)]
            if 0 < len(first) == len(other) and np.abs(other - first).max() <= tolerance:
                kinds[i], shifts[i] = j, shift
                break
    return kinds, shifts


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LackOfFit(Exact):
    """What an estimate leaves at phases of the reference that repeat.

    Attributes
    ----------
    period : float or None
        After which all of it repeats, s; null where moves repeat in another order or after rests of
        other lengths.
    span : (float, float)
        From where to where, since the record's first sample, s.
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
    hac_excess : mapping of str to float
        HAC deviation in that of the noise alone, by physical parameter; null without noise.
    time : (g,) array
        Of the phases' first rows, since the record's first sample, s.
    mean : (g,) array
        Mean residual by phase.
    count : (g,) array
        Repeats by phase.
    """

    period: float | None
    span: tuple[float, float]
    times: int
    rows: int
    share: float
    deviation: float
    chance: float
    repeated: float
    noise: float
    left: float
    smoothness: float
    hac_excess: Mapping[str, MaybeInfinite]
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
    repeats = None if reference is None else repeats_of(reference, data.record.spans)
    if repeats is None:
        return None
    rows, of, first, count = _phases(
        repeats, estimate.rows.astype(np.intp), data.prefilter.decimate
    )
    residuals = estimate.net_residuals[rows]
    total = float(residuals @ residuals)
    if len(rows) < _MIN_REPEATED_ROWS or not total > 0:
        return None
    power, sums = (np.bincount(of, weights=each) for each in (residuals**2, residuals))
    common = (sums**2 - power) / (count - 1)  # of all rows of a phase, without bias
    share = float(common.sum()) / total
    neighbours = estimate.neighbours[first]
    # Of residuals on no regressor: the kernel alone.
    scatter = Hac().long_run((common - share * power)[:, None], neighbours)
    deviation = float(np.sqrt(max(scatter.matrix[0, 0], 0.0))) / total
    chance = 0.0 if share > 0 else 1.0
    if deviation > 0:
        chance = float(stdtr(max(float(scatter.freedom[0]), 1.0), -share / deviation))
    mean = sums / count
    noise = (residuals - mean[of]) * np.sqrt(count / (count - 1))[of]
    times = estimate.rows * estimate.period if estimate.times is None else estimate.times
    begin, end = map(float, times[rows][[0, -1]])
    late, early = neighbours.pairs(1)
    size = float(np.sqrt(np.sum(mean[late] ** 2) * np.sum(mean[early] ** 2)))
    return LackOfFit(
        period=None if repeats.period is None else repeats.period * estimate.period,
        span=(begin, end),
        times=repeats.times,
        rows=len(rows),
        share=share,
        deviation=deviation,
        chance=chance,
        repeated=float(np.sqrt(max(share, 0.0) * total / len(rows))),
        noise=float(np.sqrt(min(1 - share, 1.0) * total / len(rows))),
        left=float(np.sqrt(np.mean(estimate.y[rows] ** 2))),
        time=times[first],
        mean=mean,
        count=count,
        smoothness=float(mean[late] @ mean[early]) / size if size > 0 else 0.0,
        hac_excess=_hac_excess(estimate, rows, residuals, noise),
    )


def _phases(repeats: Repeats, rows: Index, step: int) -> tuple[Index, Index, Index, Array]:
    """Rows at phases that repeat, by their samples, of which one in so many is a row.

    Their numbers, (n,); the phase of each, (n,); first row and number of rows of each phase, (g,),
    in the order of the former.
    """
    inside = np.flatnonzero(repeats.move[rows] >= 0)
    samples = rows[inside]
    phase = repeats.move[samples].astype(np.int64) * _APART + repeats.offset[samples] // step
    _, first, of, count = np.unique(
        phase, return_index=True, return_inverse=True, return_counts=True
    )
    again = np.flatnonzero(count > 1)
    again = again[np.argsort(first[again])]
    number = np.full(len(count), -1)
    number[again] = np.arange(len(again))
    kept = number[of] >= 0
    return inside[kept], number[of[kept]], inside[first[again]], count[again].astype(float)


def _hac_excess(
    estimate: Estimate, rows: Index, residuals: Array, noise: Array
) -> dict[str, float]:
    """HAC deviations by residuals as they are, in those by the noise alone, by parameter."""
    Z = estimate.slope_columns.T @ estimate.X
    weights = np.linalg.solve(Z, estimate.score_columns[rows].T).T @ estimate.jacobian.T
    neighbours = estimate.neighbours[rows]
    # Held against each other: the kernel alone.
    both = (Hac().long_run(weights * each[:, None], neighbours) for each in (residuals, noise))
    whole, alone = (np.sqrt(np.maximum(np.diag(each.matrix), 0.0)) for each in both)
    ratios = np.divide(whole, alone, out=np.full(len(whole), np.inf), where=alone > 0)
    return dict(zip((q.name for q in estimate.quantities), ratios.tolist(), strict=True))


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
    estimate: Estimate, ways: Sequence[tuple[str, Index]], *, noisy: bool = True
) -> dict[str, JackknifeInterval]:
    """The widest band of each physical parameter, by name.

    Parameters
    ----------
    estimate : Estimate
    ways : sequence of (str, (n,) array of int)
        To form groups, in words and with the label of every row's, as by `groupings`.
    noisy : bool
        Whether noise may be what groups scatter by; not where repeats show that it is not.

    Returns
    -------
    dict of str to JackknifeInterval
        Empty where no groups of rows tell all parameters.
    """
    by_grouping = [_bands(estimate, labels, by, noisy=noisy) for by, labels in ways]
    by_parameter = zip(*filter(None, by_grouping), strict=True)
    return {
        q.name: max(bands, key=lambda band: band.interval[1] - band.interval[0])
        for q, bands in zip(estimate.quantities, by_parameter, strict=False)
    }


def groupings(data: FilteredRecord, rows: Index) -> Iterator[tuple[str, Index]]:
    """Ways to form groups, in words, each with the label of every row's, (n,)."""
    position, velocity, _ = data.motion
    moves = moves_of(velocity)
    if len(moves):
        of_row = np.searchsorted(moves.starts[1:], rows, side="right")
        level = moves.levels[of_row]
        yield "speed and direction", 2 * level + (moves.speeds[of_row] > 0)
        yield "speed", level
    place = position[rows]
    edges = place.min() + np.ptp(place) * np.arange(1, _PARTS) / _PARTS
    yield "thirds of the travel", np.searchsorted(edges, place, side="right")


def _bands(estimate: Estimate, labels: Index, by: str, *, noisy: bool) -> list[JackknifeInterval]:
    """Of each parameter; none where groups are too few, or one of them tells too much."""
    names, groups = np.unique(labels, return_inverse=True)
    count = len(names)
    if count < _MIN_GROUPS:
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
        chance = fdtrc(groups_dof, noise_dof, F)
        exceeds &= (chance < _MAX_BAND_CHANCE) | ~(variances > 0)
    return [
        JackknifeInterval(
            deviation=float(d), interval=(c - r, c + r), groups=count, by=by, exceeds=bool(e)
        )
        for d, r, c, e in zip(
            deviations, reach.tolist(), estimate.corrected.tolist(), exceeds, strict=True
        )
    ]
