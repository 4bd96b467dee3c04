"""A band for the model's error: how far parameters scatter where a part of the record is left out.

A model that is not quite right is wrong in the same way wherever the axis moves in the same way:
its error does not average out over neighbours, as noise does, but over moves that differ. So rows
are put into groups that may share an error, and the estimate is made again without each. There are
three ways to form them, after three ways to be wrong: by speed and direction, by speed alone, as
what depends on the position is alike in both directions, and by thirds of the travel. What is told
of a parameter is the widest band of the three.

The estimate without a group is exact, ``(Z'X - Z_g'X_g)^-1 (Z'y - Z_g'y_g)``, and with it the
leverage of groups of different sizes (the correction that is called CR3).

References
----------
[MacKinnon2023]_ for the cluster jackknife and its t distribution with groups less one.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from scipy.special import fdtrc, stdtrit

from axisid.estimation.estimates import Estimate
from axisid.estimation.regression import Hac, Solution
from axisid.estimation.signals import FilteredRecord
from axisid.estimation.thresholds import INTERVAL_LEVEL
from axisid.support.arrays import Array

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


@dataclass(frozen=True, slots=True)
class _Scatter:
    """Deviations of all parameters under one way to form groups.

    Attributes
    ----------
    deviations : (p,) array
    by_noise : (p,) array
        What independent noise makes of their squares, in its own variance: more than 1 where groups
        tell unequally much.
    by_colour : callable
        What noise makes of their squares that follows itself as the residuals do, (p,): behind a
        loop it cancels over many rows, and less at the edges of groups. It is dear, and seldom
        asked for.
    freedom : (p,) array
        Degrees of freedom of what noise makes.
    groups : int
    by : str
    """

    deviations: Array
    by_noise: Array
    by_colour: Callable[[], Array]
    freedom: Array
    groups: int
    by: str

    @property
    def reach(self) -> Array:
        """Half of the 95 % intervals."""
        quantile = float(stdtrit(self.groups - 1, (1 + INTERVAL_LEVEL.value) / 2))
        return np.asarray(quantile * self.deviations, dtype=float)


def model_bands(
    estimates: Mapping[str, Estimate],
    data: FilteredRecord,
    *,
    noisy: bool = True,
    ways: Sequence[tuple[str, Index]] | None = None,
) -> dict[str, dict[str, Band]]:
    """The band of each physical parameter by method and name.

    Parameters
    ----------
    estimates : mapping of str to Estimate
        Of the same rows, by method.
    data : FilteredRecord
    noisy : bool
        Whether noise may be what groups scatter by; not where repeats show that it is not.
    ways : sequence of (str, (n,) array), optional
        To form groups, as `groupings` gives them, which are the default.

    Returns
    -------
    dict of str to dict of str to Band
        Empty of a method without which no groups of rows tell all parameters.
    """
    first = next(iter(estimates.values()))
    formed = [*groupings(data, first.rows.astype(np.intp))] if ways is None else ways
    return {method: _bands(estimate, formed, noisy=noisy) for method, estimate in estimates.items()}


def _bands(
    estimate: Estimate, ways: Sequence[tuple[str, Index]], *, noisy: bool
) -> dict[str, Band]:
    found = [_scatter(estimate, labels, by) for by, labels in ways]
    scatters = [scatter for scatter in found if scatter is not None]
    if not scatters:
        return {}
    widest = np.argmax([scatter.reach for scatter in scatters], axis=0)
    return {
        q.name: _band(estimate, i, scatters[widest[i]], noisy=noisy)
        for i, q in enumerate(estimate.quantities)
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


def _scatter(estimate: Estimate, labels: Index, by: str) -> _Scatter | None:
    """The jackknife over groups; None where they are too few, or one of them tells too much."""
    names, groups = np.unique(labels, return_inverse=True)
    if len(names) < _MIN_GROUPS:
        return None
    X, left = estimate.X, estimate.net_residuals
    scale = np.linalg.norm(X, axis=0)
    Z, scores = estimate.slope_columns, estimate.score_columns * left[:, None]
    size = np.linalg.norm(Z, axis=0)
    products, sums = _by_group(X / scale, Z / size, scores / size, groups, len(names))
    try:
        without = np.linalg.inv(products.sum(axis=0) - products)
        every = np.linalg.inv(products.sum(axis=0))
    except np.linalg.LinAlgError:
        return None
    variances = _variances(without, estimate.jacobian / scale)
    inflation = variances / _variances(every[None], estimate.jacobian / scale)
    if not np.all((inflation > 0) & (inflation < _MAX_DELETED_INFLATION)):
        return None
    moved = np.einsum("gij,gj->gi", without, sums.sum(axis=0) - sums) - every @ sums.sum(axis=0)
    physical = (moved / scale) @ estimate.jacobian.T
    shrunk = (len(names) - 1) / len(names)
    excess = np.maximum(inflation - 1, 0.0)  # of a parameter by each group
    return _Scatter(
        deviations=np.sqrt(shrunk * np.sum(physical**2, axis=0)),
        by_noise=np.maximum(shrunk * np.sum(excess, axis=0), 1.0),
        by_colour=cache(
            lambda: shrunk * _coloured(estimate, groups, without, every, (scale, size))
        ),
        freedom=np.maximum(np.sum(excess, axis=0) ** 2 / np.sum(excess**2, axis=0) - 1, 1.0),
        groups=len(names),
        by=by,
    )


def _coloured(
    estimate: Estimate, groups: Index, without: Array, every: Array, sizes: tuple[Array, Array]
) -> Array:
    """Sum over groups of the HAC variance of what leaving one out moves parameters by, (p,)."""
    scale, size = sizes
    columns = estimate.score_columns / size
    model = estimate.covariance_model
    model = replace(model if isinstance(model, Hac) else Hac(), widened=False)
    mapping = (estimate.jacobian / scale).T
    whole, found = columns @ every.T, np.zeros(mapping.shape[1])
    for g, inverse in enumerate(without):
        moved = (groups != g)[:, None] * (columns @ inverse.T) - whole
        solution = Solution(
            theta=np.zeros(len(found)),
            residuals=estimate.net_residuals,
            inverse_factor=np.eye(len(found)),  # of no covariance that is asked for here
            influence=moved @ mapping,
            neighbours=estimate.neighbours,
        )
        found += np.diag(model.matrix(solution))
    return found


def _variances(inverses: Array, mapping: Array) -> Array:
    """Of the physical parameters for independent noise of one variance, (g, p)."""
    return np.asarray(np.einsum("pi,gij,pj->gp", mapping, inverses, mapping), dtype=float)


def _by_group(X: Array, Z: Array, scores: Array, groups: Index, count: int) -> tuple[Array, Array]:
    """``Z'X`` and the sums of scores of each group, (g, k, k) and (g, k)."""
    order = np.argsort(groups, kind="stable")
    starts = np.searchsorted(groups[order], np.arange(count))
    products = Z[order][:, :, None] * X[order][:, None, :]
    return (
        np.add.reduceat(products, starts, axis=0),
        np.add.reduceat(scores[order], starts, axis=0),
    )


def _band(estimate: Estimate, i: int, widest: _Scatter, *, noisy: bool) -> Band:
    """The band of one parameter, beside its interval for noise."""
    deviation, reach = float(widest.deviations[i]), float(widest.reach[i])
    centre = float(estimate.corrected[i])
    noise = float(estimate.covariances[estimate.chosen][i, i])
    freedom = float(estimate.freedom[estimate.chosen][i])
    own = float(stdtrit(freedom, (1 + INTERVAL_LEVEL.value) / 2)) * np.sqrt(max(noise, 0.0))
    expected = noise * float(widest.by_noise[i])
    exceeds = reach > _MIN_BAND_EXCESS * own
    if exceeds and noisy and noise > 0:
        ratios = widest.freedom[i], freedom, deviation**2
        exceeds = not _is_chance(*ratios, expected) and not _is_chance(
            *ratios, max(expected, float(widest.by_colour()[i]))
        )
    return Band(
        deviation=deviation,
        interval=(centre - reach, centre + reach),
        groups=widest.groups,
        by=widest.by,
        exceeds=bool(exceeds),
    )


def _is_chance(scatter: float, freedom: float, square: float, expected: float) -> bool:
    """Whether noise alone may make groups scatter as far, of so many degrees of freedom each."""
    return float(fdtrc(scatter, freedom, square / expected)) >= _MAX_BAND_CHANCE
