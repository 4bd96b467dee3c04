"""A band for the model's error: how far parameters scatter where a part of the record is left out.

A model that is not quite right is wrong in the same way wherever the axis moves in the same way:
its error does not average out over neighbours, as noise does, but over moves that differ. So rows
are put into groups that may share an error, and the estimate is made again without each. There are
three ways to form them, after three ways to be wrong: by speed and direction, by speed alone, as
what depends on the position is alike in both directions, and by thirds of the travel. What is told
of a parameter is the widest band of the three.

The estimate without a group is exact, ``(Z'X - Z_g'X_g)^-1 (Z'y - Z_g'y_g)``, and with it the
leverage of groups of different sizes (the correction that is called CR3). Without it (CR1) bands
held the truth in 93 % in place of 98 % of `benchmarks/model_error.py`.

Noise scatters groups too: by how much, the leverages tell of its variance, which is the larger of
two. Behind a loop noise is differentiated and cancels over rows, which HAC sees; it does not at the
edges of groups, where White's variance is what it has.

References
----------
[MacKinnon2023]_ for the cluster jackknife and its t distribution with groups less one.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import fdtrc, stdtrit

from axisid.estimation.estimates import Estimate
from axisid.estimation.signals import FilteredRecord
from axisid.estimation.thresholds import INTERVAL_LEVEL

from .moves import Index, moves_of

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
class Band:
    """How far the model's error may move a parameter.

    Attributes
    ----------
    deviation : float
        Standard deviation by the delete-one-group jackknife.
    interval : (float, float)
        95 %, about the value less its bias, by Student's distribution with as many
        degrees of freedom as there are groups, less one.
    groups : int
    by : str
        What the groups are of, in words.
    exceeds : bool
        Whether it is noticeably wider than the interval for noise, and by more than chance.
    """

    deviation: float
    interval: tuple[float, float]
    groups: int
    by: str
    exceeds: bool


def model_bands(
    estimates: Mapping[str, Estimate], data: FilteredRecord, *, noisy: bool = True
) -> dict[str, dict[str, Band]]:
    """The band of each physical parameter by method and name.

    Parameters
    ----------
    estimates : mapping of str to Estimate
        Of the same rows, by method.
    data : FilteredRecord
    noisy : bool
        Whether noise may be what groups scatter by; not where repeats show that it is not.

    Returns
    -------
    dict of str to dict of str to Band
        Empty of a method without which no groups of rows tell all parameters.
    """
    first = next(iter(estimates.values()))
    ways = [*groupings(data, first.rows.astype(np.intp))]
    return {method: bands_of(estimate, ways, noisy=noisy) for method, estimate in estimates.items()}


def bands_of(
    estimate: Estimate, ways: Sequence[tuple[str, Index]], *, noisy: bool = True
) -> dict[str, Band]:
    """The widest band of each parameter under ways to form groups, as `groupings` gives them."""
    found = [_bands(estimate, labels, by, noisy=noisy) for by, labels in ways]
    each = zip(*filter(None, found), strict=True)  # by parameter
    return {
        q.name: max(bands, key=lambda band: band.interval[1] - band.interval[0])
        for q, bands in zip(estimate.quantities, each, strict=False)
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


def _bands(estimate: Estimate, labels: Index, by: str, *, noisy: bool) -> list[Band]:
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
    moved = np.einsum("gpk,gk->gp", without, sums.sum(axis=0) - sums) - every @ sums.sum(axis=0)
    shrunk = (count - 1) / count
    deviations = np.sqrt(shrunk * np.sum(moved**2, axis=0))
    reach = stdtrit(count - 1, (1 + INTERVAL_LEVEL.value) / 2) * deviations
    variances, freedom = np.diag(estimate.covariance), estimate.freedom[estimate.chosen]
    own = stdtrit(freedom, (1 + INTERVAL_LEVEL.value) / 2) * np.sqrt(np.maximum(variances, 0.0))
    exceeds = reach > _MIN_BAND_EXCESS * own
    if noisy:
        excess = np.maximum(inflation - 1, 0.0)  # of a parameter by each group
        white = np.sum((scores @ every.T) ** 2, axis=0)
        expected = np.maximum(variances, white) * np.maximum(shrunk * excess.sum(axis=0), 1.0)
        told = np.maximum(excess.sum(axis=0) ** 2 / np.sum(excess**2, axis=0) - 1, 1.0)
        left = np.where(white > variances, len(scores) - scores.shape[1], freedom)
        square = deviations**2
        ratio = np.divide(square, expected, out=np.zeros_like(square), where=expected > 0)
        chance = fdtrc(told, left, ratio)
        exceeds &= (chance < _MAX_BAND_CHANCE) | ~(variances > 0)
    return [
        Band(deviation=float(d), interval=(c - r, c + r), groups=count, by=by, exceeds=bool(e))
        for d, r, c, e in zip(
            deviations, reach.tolist(), estimate.corrected.tolist(), exceeds, strict=True
        )
    ]
