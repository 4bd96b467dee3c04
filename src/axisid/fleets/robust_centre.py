"""Which of several points are like one another, and what is usual among those.

Their centre and scatter are robust, by the minimum covariance determinant: the half of the points
that lies closest together [1]_, found by concentration steps from random starts, of many points
first among some of them [2]_.

.. [1] P. J. Rousseeuw, "Multivariate estimation with high breakdown point", in Mathematical
   Statistics and Applications B, Reidel, 1985.
.. [2] P. J. Rousseeuw, K. Van Driessen, "A fast algorithm for the minimum covariance determinant
   estimator", Technometrics 41 (3), 1999.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc, fdtri, gammaincinv

from axisid.support.arrays import Array, Exact

_STARTS, _KEPT, _STEPS, _FEW = 200, 10, 50, 600
_SEED = 0  # the same points give the same numbers
_FLAT_TRACE = 1e-12  # of a scatter's trace: what keeps points in a plane solvable
#: Beyond it nothing is compared: products of a few such numbers are no number any more.
LARGEST = 1e100
#: Quantile of the distances within which no point is looked at, and how many are beyond it of many.
_NEAR, _LOOKED_AT = 0.9, 20
_FIRST = 0.8  # part of the level for the furthest point; the others share the rest as 1, 1/4, 1/9
_FLAT = 1e-9  # of the estimates' variances: what keeps equal values solvable


def squared_distances(points: Array, centre: Array, covariance: Array) -> Array:
    """Mahalanobis's squared distances, (..., n), of points (..., n, p).

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
    """Centre, (p,), and covariance, (p, p), of the points that are like one another.

    The covariance is such that the median of the distances is what it is of normal points.

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
    """Of each dimension of points, (n, p): its median deviation, so that units do not matter."""
    deviation = np.median(np.abs(points - np.median(points, axis=0)), axis=0)
    return np.asarray(np.where(deviation > 0, deviation, np.std(points, axis=0)))


def _concentrated(points: Array, chosen: Array) -> tuple[NDArray[np.intp], Array]:
    """The halves, (s, h), that are closest to chosen points, (s, m, p), and their determinants."""
    centre, covariance = _moments(chosen)
    distances = squared_distances(points, centre, covariance)
    half = (sum(points.shape) + 1) // 2
    nearest = np.argpartition(distances, half - 1, axis=1)[:, :half]
    return nearest, np.linalg.det(_moments(points[nearest])[1])


def _moments(points: Array) -> tuple[Array, Array]:
    """Mean, (..., p), and covariance, (..., p, p), of points (..., m, p)."""
    centre = points.mean(axis=-2)
    residuals = points - centre[..., None, :]
    covariance = np.swapaxes(residuals, -1, -2) @ residuals / points.shape[-2]
    least = _FLAT_TRACE * np.trace(covariance, axis1=-2, axis2=-1) + np.finfo(float).tiny
    return centre, covariance + least[..., None, None] * np.eye(points.shape[-1])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RandomEffects(Exact):
    """Centre and scatter of the true values of several estimates, as of random effects.

    Attributes
    ----------
    centre : array, (p,)
    between : array, (p, p)
        Scatter of the true values, less what the estimates' deviations explain.
    count : int
        Points that it is of.
    """

    centre: Array
    between: Array
    count: int

    def distances(self, values: Array, covariances: Array) -> Array:
        """Squared distances, (n,), each by the scatter and the point's own covariance."""
        centres = np.broadcast_to(self.centre, values.shape)
        return squared_distances(values[:, None, :], centres, self.between + covariances)[:, 0]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DetectedOutliers(Exact):
    """Points that are like one another, and the others.

    Attributes
    ----------
    usual : RandomEffects
        Among the points that are alike.
    far : tuple of int
        Places of the others, the furthest first.
    distances : array, (n,)
        Squared, of all points.
    p_values : array, (n,)
        Of a distance as large, of one point that is like those that are alike.
    """

    usual: RandomEffects
    far: tuple[int, ...]
    distances: Array
    p_values: Array


def detect_outliers(values: Array, covariances: Array, level: float) -> DetectedOutliers:
    """Tell points that are not like the others.

    Parameters
    ----------
    values : array, (n, p)
        More than twice as many as parameters, of full rank.
    covariances : array, (n, p, p)
        Of the values as estimates.
    level : float
        Probability that one or more are told though all are alike.
    """
    size = values.shape[1]
    centre, scatter = robust_scatter(values)
    robust = _random_effects(centre, scatter, covariances).distances(values, covariances)
    order = np.argsort(-robust, kind="stable")
    near = max(1 - _LOOKED_AT / len(values), _NEAR)
    far = int(np.count_nonzero(robust > 2 * gammaincinv(size / 2, near)))
    most = min(far, (len(values) - size) // 2)
    count = _outlying(values[order], covariances[order], most, level)
    alike = order[count:]
    usual = _effects_of(values[alike], covariances[alike])
    distances = usual.distances(values, covariances)
    return DetectedOutliers(
        usual=usual,
        far=tuple(sorted(map(int, order[:count]), key=lambda i: -distances[i])),
        distances=distances,
        p_values=np.asarray(prediction_p_value(distances, len(alike), size)),
    )


def _outlying(values: Array, covariances: Array, most: int, level: float) -> int:
    """How many of the first points, the furthest first and `most` of them, are not as the others.

    Each is held against all that follow it. The last that is too far for the furthest of as many
    is an outlier with all before it, so that several that lie together do not hide one another
    [1]_.

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
    """Random effects of points that are alike."""
    return _random_effects(values.mean(axis=0), np.atleast_2d(np.cov(values.T)), covariances)


def _random_effects(centre: Array, scatter: Array, covariances: Array) -> RandomEffects:
    """Scatter of the points without that of their estimates; none where that explains it."""
    within = np.median(covariances, axis=0)  # one that knows little says nothing of the others
    # Both in units of the scatter, so that no parameter's unit decides what is too small.
    root = np.linalg.cholesky(scatter + _FLAT * np.diag(np.diag(within)))
    excess = np.linalg.solve(root, np.linalg.solve(root, scatter - within).T)
    sizes, axes = np.linalg.eigh((excess + excess.T) / 2)
    turned = root @ axes
    between = turned * np.maximum(sizes, 0.0) @ turned.T
    return RandomEffects(centre=centre, between=between, count=len(covariances))


def prediction_p_value(distance: Any, count: int, size: int) -> Any:
    """Probability of a squared distance as large, from the mean and covariance of other points.

    Parameters
    ----------
    distance : float or array
    count, size : int
        How many other points there are, and in how many dimensions.
    """
    scaled = distance * count * (count - size) / ((count + 1) * (count - 1) * size)
    return fdtrc(size, count - size, scaled)


def prediction_limit(probability: float, count: int, size: int) -> float:
    """The squared distance that has a probability by `prediction_p_value`."""
    scaled = float(fdtri(size, count - size, 1 - probability))
    return scaled * (count + 1) * (count - 1) * size / (count * (count - size))
