"""Robust statistics: outliers among points, random effects, steps and drifts of a series.

A series is constant over time, steps, or drifts. Centre and covariance of points are estimated by
the minimum covariance determinant: from the half of the points whose covariance has the smallest
determinant [1]_. This half is found by concentration steps from random starts, for many points
first within a random subset [2]_.

.. [1] P. J. Rousseeuw, "Multivariate estimation with high breakdown point", in Mathematical
   Statistics and Applications B, Reidel, 1985.
.. [2] P. J. Rousseeuw, K. Van Driessen, "A fast algorithm for the minimum covariance determinant
   estimator", Technometrics 41 (3), 1999.
"""

from dataclasses import dataclass, replace
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc, fdtri, gammaincinv

from axisid.support.arrays import Array, Exact

_ORDERS = 999  # random orders of the values, for permutation tests
_SHORTEST = 3  # values of a level, at least
_SHORTER = np.sqrt(2.0)  # ratio of the lengths of stretches in which a step is searched


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """A step of the level of a series.

    Attributes
    ----------
    place : int
        Index of the first value on the new level.
    difference, deviation : float
        New level minus the level before, and its standard error.
    p_value : float
        Probability of an equally large step anywhere in the series, if the order of the values were
        random.
    """

    place: int
    difference: float
    deviation: float
    p_value: float


def _largest_step(values: Array, variances: Array) -> tuple[int, float] | None:
    """Return the index and the p-value of the largest step; None for fewer than six values.

    A permutation test: the step is compared with the largest steps of the same values in random
    orders.

    Parameters
    ----------
    values, variances : (n,) array
    """
    if len(values) < 2 * _SHORTEST:
        return None
    weights = 1 / _total_variances(values, variances)
    orders = _orders(len(values))
    sizes, places = _largest(values[orders], weights[orders])
    return int(places[0]), float(np.mean(sizes >= sizes[0]))


def _places(
    values: Array, variances: Array, level: float, first: int, largest: tuple[int, float]
) -> list[tuple[int, float]]:
    """Return index and p-value of each significant step, in no order.

    The search is repeated before and after the largest step (binary segmentation).

    Parameters
    ----------
    values, variances : (n,) array
    level : float
        Significance level.
    first : int
        Index in the whole series of the first value.
    largest : (int, float)
        Index in `values`, and p-value, of the largest step.
    """
    place, p_value = largest
    changes = [(first + place, p_value)]
    for begin, side in ((first, slice(None, place)), (first + place, slice(place, None))):
        inner = _largest_step(values[side], variances[side])
        if inner is not None and inner[1] <= level:
            changes += _places(values[side], variances[side], level, begin, inner)
    return changes


def _orders(count: int) -> NDArray[np.intp]:
    """Return orders of `count` values as indices, (1000, n): the given order, then random ones."""
    given = np.arange(count)
    rng = np.random.default_rng(_SEED)
    return np.vstack([given, rng.permuted(np.tile(given, (_ORDERS, 1)), axis=1)])


def _total_variances(values: Array, variances: Array) -> Array:
    """Return the variance of each value about a common level, (n,).

    It is the variance of the estimate plus the variance between true values by the method of
    moments.
    """
    return variances + max(float(np.var(values, ddof=1) - np.mean(variances)), 0.0)


def _largest(values: Array, weights: Array) -> tuple[Array, NDArray[np.intp]]:
    """Return the largest squared step of each series, relative to its variance, and its index.

    The series are the rows of `values`, (s, n); `weights`, (s, n), are reciprocal variances. The
    step is searched in stretches of many lengths, so that a later step back does not hide it [1]_.

    .. [1] S. Kovacs, P. Buehlmann, H. Li, A. Munk, "Seeded binary segmentation: a general
       methodology for fast and optimal changepoint detection", Biometrika 110 (1), 2023.
    """
    # Cumulative sums, with which the mean of any stretch is a difference of two entries.
    sums = np.cumsum(np.pad(weights * values, ((0, 0), (1, 0))), axis=1)
    weight = np.cumsum(np.pad(weights, ((0, 0), (1, 0))), axis=1)
    best = np.full(len(values), -np.inf)
    places = np.zeros(len(values), dtype=np.intp)
    count = values.shape[1]
    # The whole series, then ever shorter stretches that overlap by at least half.
    stretches, length = [(0, count)], count / _SHORTER
    while length >= 2 * _SHORTEST:
        starts = np.linspace(0, count - length, 2 * int(np.ceil(count / length)) - 1)
        stretches += [(int(start), int(np.ceil(start + length))) for start in starts]
        length /= _SHORTER
    for start, stop in stretches:
        inner = slice(start + _SHORTEST, stop - _SHORTEST + 1)
        before, of_before = (x[:, inner] - x[:, [start]] for x in (sums, weight))
        after, of_after = (x[:, [stop]] - x[:, inner] for x in (sums, weight))
        sizes = (after / of_after - before / of_before) ** 2 / (1 / of_before + 1 / of_after)
        largest = sizes.max(axis=1)
        places = np.where(largest > best, sizes.argmax(axis=1) + inner.start, places)
        best = np.maximum(best, largest)
    return best, places


def _step(
    values: Array, variances: Array, first: int, place: int, last: int, p_value: float
) -> Step:
    """Return the step between the mean of values `first` to `place` and of `place` to `last`.

    The end of each range is excluded.
    """
    parts = (slice(first, place), slice(place, last))
    weights = [1 / _total_variances(values[part], variances[part]) for part in parts]
    before, after = (
        float(np.average(values[part], weights=each))
        for part, each in zip(parts, weights, strict=True)
    )
    return Step(
        place=place,
        difference=after - before,
        deviation=float(np.sqrt(sum(1 / np.sum(each) for each in weights))),
        p_value=p_value,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Drift(Exact):
    """A linear change of the level of a series with the place of its values.

    Attributes
    ----------
    slope, deviation : float
        Slope and its standard error, in the unit of the values per unit of the places.
    p_value : float
        Probability of an equally large slope, if the order of the values were random.
    line : array, (n,)
        The level at each place.
    """

    slope: float
    deviation: float
    p_value: float
    line: Array


def change_in(
    values: Array, variances: Array, places: Array, level: float
) -> tuple[tuple[Step, ...], Drift | None]:
    """Return the change of a series: steps, a drift, or none.

    Permutation tests compare the largest step and the slope with those of the same values in random
    orders. If one of the two is significant, Schwarz's information criterion selects a constant, a
    line or steps as the model [Schwarz1978]_. The smaller p-value times the number of tests is the
    p-value of both tests together; the reported p-value of the largest step or of the slope is at
    most this.

    Parameters
    ----------
    values, variances, places : array, (n,)
        Estimates in their order, the variance of each estimate, and the place of each.
    level : float
        Probability that a change is reported although there is none.

    Returns
    -------
    steps : tuple of Step
        Steps in their order; empty if the model is a constant or a line.
    drift : Drift or None
        The line; None if the model is a constant or steps.
    """
    largest = _largest_step(values, variances)
    if largest is None:
        return (), None
    drift = _drift(values, variances, places)
    # Both tests together, by Bonferroni.
    p_values = [largest[1]]
    if drift is not None:
        p_values.append(drift.p_value)
    together = len(p_values) * min(p_values)
    if together > level:
        return (), None
    first_step = (largest[0], min(largest[1], together))
    changes = sorted(_places(values, variances, level, 0, first_step))
    bounds = [0, *(place for place, _ in changes), len(values)]
    steps = tuple(
        _step(values, variances, first, place, last, p_value)
        for first, (place, p_value), last in zip(bounds, changes, bounds[2:], strict=False)
    )
    # Regressor with a column for each level. The place of a step counts as one more parameter.
    number = np.searchsorted(bounds[1:-1], np.arange(len(values)), side="right")
    levels = np.asarray(np.eye(len(steps) + 1)[number])
    models: list[tuple[float, tuple[Step, ...], Drift | None]] = [
        (_criterion(values, variances, np.ones((len(values), 1)), 0), (), None),
        (_criterion(values, variances, levels, len(steps)), steps, None),
    ]
    if drift is not None:
        drift = replace(drift, p_value=min(drift.p_value, together))
        models.append((_criterion(values, variances, _straight(places), 0), (), drift))
    return min(models, key=itemgetter(0))[1:]


def _straight(places: Array) -> Array:
    """Return the regressor of a line over the places, (n, 2): ones, and places over their range."""
    centred = places - places.mean()
    return np.column_stack([np.ones(len(places)), centred / np.ptp(centred)])


def _drift(values: Array, variances: Array, places: Array) -> Drift | None:
    """Return the weighted least-squares line through the values; None if all places are equal.

    The p-value is that of a permutation test: the slope is compared with the slopes of the same
    values in random orders.
    """
    reach = float(np.ptp(places))
    if reach * LARGEST < 1:
        return None
    # Places are scaled to a range of 1, so that their squares do not overflow in any unit.
    places = (places - places.mean()) / reach
    orders = _orders(len(values))
    weights = (1 / _total_variances(values, variances))[orders]
    total = weights.sum(axis=1, keepdims=True)
    centred = places - (weights * places).sum(axis=1, keepdims=True) / total
    products = (weights * centred * values[orders]).sum(axis=1)
    squared = products**2 / (weights * centred**2).sum(axis=1)  # squared slopes over their variance
    columns = _straight(places)
    # The maximum-likelihood variance about a fitted line is too small by the factor dof/n.
    dof = len(values) - columns.shape[1]
    total_variances = variances + _between(values, variances, columns) * (len(values) / dof)
    coefficients, covariance = _fitted(values, total_variances, columns)
    return Drift(
        slope=float(coefficients[1] / reach),
        deviation=float(np.sqrt(covariance[1, 1]) / reach),
        p_value=float(np.mean(squared >= squared[0])),
        line=columns @ coefficients,
    )


def _fitted(values: Array, variances: Array, columns: Array) -> tuple[Array, Array]:
    """Return the coefficients, (k,), of a weighted least-squares fit and their covariance."""
    weighted = columns / variances[:, None]
    covariance = np.asarray(np.linalg.inv(columns.T @ weighted), dtype=float)
    return covariance @ (weighted.T @ values), covariance


def _criterion(values: Array, variances: Array, columns: Array, chosen: int) -> float:
    """Return Schwarz's information criterion of a model, at the maximum of its likelihood.

    Parameters
    ----------
    values, variances : (n,) array
    columns : (n, k) array
        Regressor of the model.
    chosen : int
        Number of parameters in addition to the coefficients, such as the places of steps.
    """
    between = _between(values, variances, columns)
    penalty: float = (columns.shape[1] + chosen + 1) * np.log(len(values))
    return _misfit(between, values, variances, columns) + penalty


def _between(values: Array, variances: Array, columns: Array) -> float:
    """Return the maximum-likelihood variance between the true values, about a model."""
    from scipy.optimize import minimize_scalar

    most = float(np.var(values)) or 1.0
    minimum = minimize_scalar(
        lambda share: _misfit(share * most, values, variances, columns),
        bounds=(0.0, 1.0),
        method="bounded",
    )
    return float(minimum.x) * most


def _misfit(between: float, values: Array, variances: Array, columns: Array) -> float:
    """Return minus twice the log-likelihood of a model, without its constant part.

    `between` is the variance between true values.
    """
    total = variances + between
    coefficients, _ = _fitted(values, total, columns)
    return float(np.sum(np.log(total) + (values - columns @ coefficients) ** 2 / total))


#: Search of the minimum covariance determinant: random starts, subsets that are continued on all
#: points, most concentration steps, and points of the subset in which the starts are concentrated.
_STARTS, _KEPT, _STEPS, _FEW = 200, 10, 50, 600
_SEED = 0  # fixed, so that equal points or series give equal numbers
_FLAT_TRACE = 1e-12  # of a covariance's trace; added, so that points in a plane can be solved
#: Larger values are not compared: products of a few such numbers overflow.
LARGEST = 1e100
#: Quantile of the distances within which points are not tested as outliers, and the largest number
#: of points that are tested if there are many.
_NEAR, _LOOKED_AT = 0.9, 20
_FIRST = 0.8  # share of the level for the furthest point; the rest is shared as 1, 1/4, 1/9, ...
_FLAT = 1e-9  # of the variances of the estimates; added, so that equal values can be solved


def squared_distances(points: Array, centre: Array, covariance: Array) -> Array:
    """Return squared Mahalanobis distances, (..., n), of points (..., n, p).

    Parameters
    ----------
    points : array, (..., n, p)
    centre : array, (..., p)
    covariance : array, (..., p, p)
    """
    residuals = points - centre[..., None, :]
    solved = np.linalg.solve(covariance, np.swapaxes(residuals, -1, -2))
    return np.asarray(np.sum(residuals * np.swapaxes(solved, -1, -2), axis=-1))


def robust_scatter(points: Array) -> tuple[Array, Array]:
    """Return centre, (p,), and covariance, (p, p), by the minimum covariance determinant.

    Random small subsets are concentrated by two steps within at most 600 points. The ten best
    subsets are concentrated on all points until the determinant stays the same. The covariance is
    then scaled so that the median of the squared distances is the median of chi-squared with p
    degrees of freedom.

    Parameters
    ----------
    points : array, (n, p)
        More than twice as many as dimensions, of full rank.
    """
    middle, scale = np.median(points, axis=0), spread_of(points)
    scaled = (points - middle) / scale
    count, size = scaled.shape
    rng = np.random.default_rng(_SEED)
    few = rng.choice(count, _FEW, replace=False) if count > _FEW else np.arange(count)
    part = scaled[few]
    ranks = rng.random((_STARTS, len(few)))
    chosen = np.argpartition(ranks, size + 1, axis=1)[:, : size + 1]
    for _ in range(2):
        chosen, determinants = _concentrated(part, part[chosen])
    begun = few[chosen[np.argsort(determinants, kind="stable")[:_KEPT]]]
    chosen, determinants = _concentrated(scaled, scaled[begun])
    for _ in range(_STEPS):
        before = determinants
        chosen, determinants = _concentrated(scaled, scaled[chosen])
        if np.all(determinants >= before):
            break
    centre, covariance = _moments(scaled[chosen[np.argmin(determinants)]])
    distances = squared_distances(scaled, centre, covariance)
    usual = 2 * gammaincinv(points.shape[1] / 2, 0.5)  # the median of chi-squared
    covariance = covariance * (np.median(distances) / usual)
    return middle + scale * centre, covariance * np.outer(scale, scale)


def spread_of(points: Array) -> Array:
    """Return the median absolute deviation, (p,), of each dimension of points, (n, p).

    A dimension with the deviation 0 has its standard deviation instead.
    """
    deviation = np.median(np.abs(points - np.median(points, axis=0)), axis=0)
    return np.asarray(np.where(deviation > 0, deviation, np.std(points, axis=0)))


def _concentrated(points: Array, chosen: Array) -> tuple[NDArray[np.intp], Array]:
    """Return the half of the points closest to each subset, and its covariance's determinant.

    Parameters
    ----------
    points : array, (n, p)
    chosen : array, (s, m, p)
        s subsets of m points.

    Returns
    -------
    array, (s, h)
        Indices of the h closest points.
    array, (s,)
        Determinants.
    """
    centre, covariance = _moments(chosen)
    distances = squared_distances(points, centre, covariance)
    half = (sum(points.shape) + 1) // 2
    nearest = np.argpartition(distances, half - 1, axis=1)[:, :half]
    return nearest, np.linalg.det(_moments(points[nearest])[1])


def _moments(points: Array) -> tuple[Array, Array]:
    """Return mean, (..., p), and covariance, (..., p, p), of points (..., m, p).

    A small multiple of the identity makes the covariance invertible.
    """
    centre = points.mean(axis=-2)
    residuals = points - centre[..., None, :]
    covariance = np.swapaxes(residuals, -1, -2) @ residuals / points.shape[-2]
    least = _FLAT_TRACE * np.trace(covariance, axis1=-2, axis2=-1) + np.finfo(float).tiny
    return centre, covariance + least[..., None, None] * np.eye(points.shape[-1])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RandomEffects(Exact):
    """Centre and scatter of the true values of several estimates (random effects).

    Attributes
    ----------
    centre : array, (p,)
    between : array, (p, p)
        Covariance between the true values: the scatter of the estimates that their covariances do
        not explain.
    count : int
        Number of points used.
    """

    centre: Array
    between: Array
    count: int

    def distances(self, values: Array, covariances: Array) -> Array:
        """Return the squared Mahalanobis distance of each point from the centre, (n,).

        The covariance of a point is `between` plus its covariance in `covariances`, (n, p, p).
        """
        centres = np.broadcast_to(self.centre, values.shape)
        return squared_distances(values[:, None, :], centres, self.between + covariances)[:, 0]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DetectedOutliers(Exact):
    """Outliers among points, and the random effects of the other points.

    Attributes
    ----------
    usual : RandomEffects
        Random effects of the points that are not outliers.
    far : tuple of int
        Indices of the outliers, the furthest first.
    distances : array, (n,)
        Squared distances of all points.
    p_values : array, (n,)
        Probability of an equal or larger distance for a point that is not an outlier.
    """

    usual: RandomEffects
    far: tuple[int, ...]
    distances: Array
    p_values: Array


def detect_outliers(values: Array, covariances: Array, level: float) -> DetectedOutliers:
    """Return the significant outliers among points, and the random effects of the other points.

    Robust distances order the points. The furthest points are tested one after the other. The
    remaining points give the random effects.

    Parameters
    ----------
    values : array, (n, p)
        More than twice as many as parameters, of full rank.
    covariances : array, (n, p, p)
        Covariance of each value as an estimate.
    level : float
        Probability that one or more outliers are reported although there are none.
    """
    size = values.shape[1]
    centre, scatter = robust_scatter(values)
    robust = _random_effects(centre, scatter, covariances).distances(values, covariances)
    order = np.argsort(-robust, kind="stable")
    near = max(1 - _LOOKED_AT / len(values), _NEAR)
    far = int(np.count_nonzero(robust > 2 * gammaincinv(size / 2, near)))
    most = min(far, (len(values) - size) // 2)
    count = _outlying(values[order], covariances[order], most, level)
    inliers = order[count:]
    usual = _effects_of(values[inliers], covariances[inliers])
    distances = usual.distances(values, covariances)
    return DetectedOutliers(
        usual=usual,
        far=tuple(sorted(map(int, order[:count]), key=lambda i: -distances[i])),
        distances=distances,
        p_values=np.asarray(prediction_p_value(distances, len(inliers), size)),
    )


def _outlying(values: Array, covariances: Array, most: int, level: float) -> int:
    """Return the number of outliers among the first points, at most `most`.

    The points are ordered, the furthest first. Each point is compared with all points that follow
    it. The last point with a significant distance is an outlier together with all points before it,
    so that several outliers close to one another do not hide one another [1]_.

    .. [1] C. Caroni, P. Prescott, "Sequential application of Wilks's multivariate outlier test",
       Applied Statistics 41 (2), 1992.
    """
    size = values.shape[1]
    outliers = 0
    for i in range(most):
        usual = _effects_of(values[i + 1 :], covariances[i + 1 :])
        (distance,) = usual.distances(values[i : i + 1], covariances[i : i + 1])
        remaining = len(values) - i
        share = (1 - _FIRST) * 6 / (np.pi * i) ** 2 if i else _FIRST
        if prediction_p_value(distance, remaining - 1, size) * remaining < level * share:
            outliers = i + 1
    return outliers


def _effects_of(values: Array, covariances: Array) -> RandomEffects:
    """Return the random effects of points without outliers, from their mean and covariance."""
    return _random_effects(values.mean(axis=0), np.atleast_2d(np.cov(values.T)), covariances)


def _random_effects(centre: Array, scatter: Array, covariances: Array) -> RandomEffects:
    """Return random effects: the covariance of the points minus that of the estimates.

    `scatter`, (p, p), is the covariance of the points. In directions in which the covariances of
    the estimates explain the scatter, the covariance between true values is 0.
    """
    within = np.median(covariances, axis=0)  # the median is not affected by uncertain points
    # The difference in units of the scatter, so that eigenvalues do not depend on the units.
    root = np.linalg.cholesky(scatter + _FLAT * np.diag(np.diag(within)))
    excess = np.linalg.solve(root, np.linalg.solve(root, scatter - within).T)
    sizes, axes = np.linalg.eigh((excess + excess.T) / 2)
    turned = root @ axes
    return RandomEffects(
        centre=centre,
        between=turned * np.maximum(sizes, 0.0) @ turned.T,
        count=len(covariances),
    )


def prediction_p_value(distance: Any, count: int, size: int) -> Any:
    """Return the probability that a further point has an equal or larger distance.

    Parameters
    ----------
    distance : float or array
        Squared distance of the point from the centre of other points, relative to their covariance.
    count, size : int
        Number of other points, and of dimensions.
    """
    scaled = distance * count * (count - size) / ((count + 1) * (count - 1) * size)
    return fdtrc(size, count - size, scaled)


def prediction_limit(probability: float, count: int, size: int) -> float:
    """Return the squared distance that a further point exceeds with a given probability.

    Parameters
    ----------
    probability : float
    count, size : int
        Number of other points, and of dimensions.
    """
    scaled = float(fdtri(size, count - size, 1 - probability))
    return scaled * (count + 1) * (count - 1) * size / (count * (count - size))
