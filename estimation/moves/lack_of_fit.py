"""What a model leaves, split by repeats: into what is left again each time, and noise.

The products of the residuals of two repeats at one phase have the power of what repeats as their
mean, whatever the noise is, as long as that of one repeat is independent of that of another. What
they leave of the power is pure error.

References
----------
[Fisher1922]_ for the lack of fit against the pure error of repeats.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.special import stdtr

from axisid.estimation.estimates import Estimate
from axisid.estimation.regression import Applied, Hac, score_products
from axisid.estimation.signals import FilteredRecord, Neighbours
from axisid.estimation.thresholds import MIN_MODEL_SHARE
from axisid.support.arrays import Array

from .moves import Index, Repeats, repeats_of

_MIN_REPEATED_ROWS = 50  # rows at phases that repeat; of fewer, residuals are not split
# that noise alone repeats as much, up to which something of the residuals repeats
_MAX_REPEAT_CHANCE = 1e-3
# correlation of what repeats with that of the next row, from which it is the model's: measured,
# 0.5 to 0.99 for missing terms, -0.5 for the steps of an encoder
_MIN_SMOOTHNESS = 0.25

_APART = 1 << 32  # between the phases of two moves


@dataclass(frozen=True, slots=True, kw_only=True)
class LackOfFit:
    """What an estimate leaves at phases of the reference that repeat.

    Attributes
    ----------
    period : float or None
        After which all of it repeats, s; None where moves repeat in another order or after rests of
        other lengths.
    span : (float, float)
        From where to where in the record, s since its first sample.
    times : int
        How often what repeats most often does.
    rows : int
        Rows at phases that repeat.
    share, deviation : float
        Of these rows' power, what repeats, with its standard deviation (HAC over the phases).
    chance : float
        That noise alone repeats as much, by Student's distribution.
    repeated, noise : float
        Root mean square of what repeats and of the noise, in the unit of the left side.
    left : float
        Root mean square of the left side in these rows.
    time, mean : (g,) array
        Mean residual by phase, over the time of its first row, s since the record's first sample.
    count : (g,) array
        Of how many repeats.
    smoothness : float
        Correlation of the mean residual with that of the next phase: near 1 for what a model
        lacks, below 0 for the steps of an encoder, which repeat where the motion does to less than
        one of them.
    hac_excess : mapping of str to float
        HAC deviation of each physical parameter in that of the noise alone, from these rows.
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
    time: Array
    mean: Array
    count: Array
    smoothness: float
    hac_excess: Mapping[str, float]

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


@dataclass(frozen=True, slots=True, kw_only=True)
class _Phases:
    """Rows at phases that repeat.

    Attributes
    ----------
    rows : (n,) array of int
        Their numbers among those of the estimate.
    of : (n,) array of int
        The phase of each, from 0.
    first : (g,) array of int
        First row of each; phases are in the order of these.
    count : (g,) array
        Rows of each.
    """

    rows: Index
    of: Index
    first: Index
    count: Array

    def sums(self, values: Array) -> Array:
        """Of values by row, (n,), over each phase, (g,)."""
        found = np.bincount(self.of, weights=values, minlength=len(self.count))
        return np.asarray(found, dtype=float)


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
    phases = _phases(repeats, estimate.rows.astype(np.intp), data.prefilter.decimate)
    if len(phases.rows) < _MIN_REPEATED_ROWS:
        return None
    left = estimate.net_residuals[phases.rows]
    total = float(left @ left)
    return _split(estimate, repeats, phases, left) if total > 0 else None


def _split(estimate: Estimate, repeats: Repeats, phases: _Phases, left: Array) -> LackOfFit:
    count, power = phases.count, phases.sums(left**2)
    sums = phases.sums(left)
    common = (sums**2 - power) / (count - 1)  # of all rows of a phase, without bias
    total, rows = float(power.sum()), len(left)
    share = float(common.sum()) / total
    beside = estimate.neighbours[phases.first]
    scatter = _long_run((common - share * power)[:, None], beside)
    deviation = float(np.sqrt(max(scatter.matrix[0, 0], 0.0))) / total
    mean = sums / count
    scaled = (left - mean[phases.of]) * np.sqrt(count / (count - 1))[phases.of]
    times = estimate.rows * estimate.period if estimate.times is None else estimate.times
    first, last = map(float, times[phases.rows][[0, -1]])
    return LackOfFit(
        period=None if repeats.period is None else repeats.period * estimate.period,
        span=(first, last),
        times=repeats.times,
        rows=rows,
        share=share,
        deviation=deviation,
        chance=_chance(share, deviation, float(scatter.freedom[0])),
        repeated=float(np.sqrt(max(share, 0.0) * total / rows)),
        noise=float(np.sqrt(min(1 - share, 1.0) * total / rows)),
        left=float(np.sqrt(np.mean(estimate.y[phases.rows] ** 2))),
        time=times[phases.first],
        mean=mean,
        count=count,
        smoothness=_smoothness(mean, beside),
        hac_excess=_hac_excess(estimate, phases.rows, left, scaled),
    )


def _chance(share: float, deviation: float, freedom: float) -> float:
    if not deviation > 0:
        return 0.0 if share > 0 else 1.0
    return float(stdtr(max(freedom, 1.0), -share / deviation))


def _smoothness(mean: Array, neighbours: Neighbours) -> float:
    late, early = neighbours.pairs(1)
    power = float(np.sqrt(np.sum(mean[late] ** 2) * np.sum(mean[early] ** 2)))
    return float(mean[late] @ mean[early]) / power if power > 0 else 0.0


def _phases(repeats: Repeats, rows: Index, step: int) -> _Phases:
    """The phases of rows, by their samples, of which one in so many is one."""
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
    return _Phases(
        rows=inside[kept],
        of=number[of[kept]],
        first=inside[first[again]],
        count=count[again].astype(float),
    )


def _hac_excess(estimate: Estimate, rows: Index, left: Array, noise: Array) -> dict[str, float]:
    """HAC deviations by residuals as they are, in those by the noise alone, by parameter."""
    Z = estimate.slope_columns.T @ estimate.X
    weights = np.linalg.solve(Z, estimate.score_columns[rows].T).T @ estimate.jacobian.T
    beside = estimate.neighbours[rows]
    of_both = (_long_run(weights * each[:, None], beside).matrix for each in (left, noise))
    whole, alone = (np.sqrt(np.maximum(np.diag(of_one), 0.0)) for of_one in of_both)
    ratios = np.divide(whole, alone, out=np.full(len(whole), np.inf), where=alone > 0)
    return {q.name: float(r) for q, r in zip(estimate.quantities, ratios, strict=True)}


def _long_run(scores: Array, neighbours: Neighbours) -> Applied:
    """Covariance of the sum of scores, (n, k), that may depend on their neighbours."""
    # Held against each other, or of residuals on no regressor: the kernel alone.
    products = partial(score_products, scores, neighbours)
    return Hac().long_run(products, len(scores))
