"""Centre and scatter of points of which some are not like the others.

Minimum covariance determinant: the half of the points that lies closest together [1]_, found by
concentration steps from random starts, of many points first among some of them [2]_.

.. [1] P. J. Rousseeuw, "Multivariate estimation with high breakdown point", in Mathematical
   Statistics and Applications B, Reidel, 1985.
.. [2] P. J. Rousseeuw, K. Van Driessen, "A fast algorithm for the minimum covariance determinant
   estimator", Technometrics 41 (3), 1999.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincinv

from axisid.support.arrays import Array

Places = NDArray[np.intp]

_STARTS, _KEPT, _STEPS, _FEW = 200, 10, 50, 600
_SEED = 0  # the same points give the same numbers
_FLAT = 1e-12  # of a scatter's trace: what keeps points in a plane solvable


def squared_distances(points: Array, centre: Array, covariance: Array) -> Array:
    """Mahalanobis's squared distances, (..., n), of points (..., n, p).

    Parameters
    ----------
    points : array, (..., n, p)
    centre : array, (..., p)
    covariance : array, (..., p, p)
    """
    apart = points - centre[..., None, :]
    solved = np.linalg.solve(covariance, np.swapaxes(apart, -1, -2))
    return np.asarray(np.sum(apart * np.swapaxes(solved, -1, -2), axis=-1))


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
    chosen = _closest(scaled)
    centre, covariance = _moments(scaled[chosen])
    distances = squared_distances(scaled, centre, covariance)
    usual = 2 * gammaincinv(points.shape[1] / 2, 0.5)  # the median of chi-squared
    covariance = covariance * (np.median(distances) / usual)
    return middle + scale * centre, covariance * np.outer(scale, scale)


def spread_of(points: Array) -> Array:
    """Of each dimension of points, (n, p): its median deviation, so that units do not matter."""
    apart = np.median(np.abs(points - np.median(points, axis=0)), axis=0)
    return np.asarray(np.where(apart > 0, apart, np.std(points, axis=0)))


def _half(count: int, size: int) -> int:
    return (count + size + 1) // 2


def _closest(points: Array) -> Places:
    """Which of the points are the half of least determinant."""
    count, size = points.shape
    rng = np.random.default_rng(_SEED)
    few = rng.choice(count, _FEW, replace=False) if count > _FEW else np.arange(count)
    part = points[few]
    ranks = rng.random((_STARTS, len(few)))
    chosen = np.argpartition(ranks, size + 1, axis=1)[:, : size + 1]
    for _ in range(2):
        chosen, determinants = _concentrated(part, part[chosen])
    begun = few[chosen[np.argsort(determinants, kind="stable")[:_KEPT]]]
    chosen, determinants = _concentrated(points, points[begun])
    for _ in range(_STEPS):
        before = determinants
        chosen, determinants = _concentrated(points, points[chosen])
        if np.all(determinants >= before):
            break
    return np.asarray(chosen[np.argmin(determinants)])


def _concentrated(points: Array, chosen: Array) -> tuple[Places, Array]:
    """The halves, (s, h), that are closest to chosen points, (s, m, p), and their determinants."""
    centre, covariance = _moments(chosen)
    distances = squared_distances(points, centre, covariance)
    half = _half(*points.shape)
    nearest = np.argpartition(distances, half - 1, axis=1)[:, :half]
    return nearest, np.linalg.det(_moments(points[nearest])[1])


def _moments(points: Array) -> tuple[Array, Array]:
    """Mean, (..., p), and covariance, (..., p, p), of points (..., m, p)."""
    centre = points.mean(axis=-2)
    apart = points - centre[..., None, :]
    covariance = np.swapaxes(apart, -1, -2) @ apart / points.shape[-2]
    least = _FLAT * np.trace(covariance, axis1=-2, axis2=-1) + np.finfo(float).tiny
    return centre, covariance + least[..., None, None] * np.eye(points.shape[-1])
