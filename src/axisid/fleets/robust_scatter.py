"""Centre and scatter of points of which some are not like the others.

Minimum covariance determinant: the half of the points that lies closest together [1]_, found by
concentration steps from random starts [2]_, its covariance made consistent, and reweighted [3]_.

.. [1] P. J. Rousseeuw, "Multivariate estimation with high breakdown point", in Mathematical
   Statistics and Applications B, Reidel, 1985.
.. [2] P. J. Rousseeuw, K. Van Driessen, "A fast algorithm for the minimum covariance determinant
   estimator", Technometrics 41 (3), 1999.
.. [3] A. Cerioli, "Multivariate outlier detection with high-breakdown estimators", Journal of the
   American Statistical Association 105 (489), 2010.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from axisid.support.arrays import Array

Places = NDArray[np.intp]
_STARTS, _KEPT, _STEPS = 200, 10, 30
_SEED = 0  # the same points give the same numbers
_WEIGHED = 0.975  # quantile within which points are weighed again


@dataclass(frozen=True, slots=True, kw_only=True)
class Scatter:
    """Centre and scatter of the points that are like one another.

    Attributes
    ----------
    centre : array, (p,)
    covariance : array, (p, p)
    used : array of bool, (n,)
        The points that they are of.
    """

    centre: Array
    covariance: Array
    used: NDArray[np.bool_]


def squared_distances(points: Array, centre: Array, covariance: Array) -> Array:
    """Mahalanobis's squared distances, (n,), of points (n, p)."""
    apart = points - centre
    return np.asarray(np.sum(apart * np.linalg.solve(covariance, apart.T).T, axis=1))


def robust_scatter(points: Array) -> Scatter:
    """Centre and scatter of the points that are like one another.

    Parameters
    ----------
    points : array, (n, p)
        More than twice as many as dimensions, of full rank.
    """
    count, size = points.shape
    half = (count + size + 1) // 2
    scale = _spread(points)
    scaled = (points - np.median(points, axis=0)) / scale
    chosen = _closest(scaled, half)
    centre, covariance = scaled[chosen].mean(axis=0), np.cov(scaled[chosen].T, ddof=0)
    covariance = np.atleast_2d(covariance) * _consistent(half / count, size)
    distances = squared_distances(scaled, centre, covariance)
    # Small samples: the median of the distances is what it should be.
    distances /= np.median(distances) / chi2.median(size)
    used = distances <= chi2.ppf(_WEIGHED, size)
    centre = scaled[used].mean(axis=0)
    covariance = np.atleast_2d(np.cov(scaled[used].T)) * _consistent(_WEIGHED, size)
    return Scatter(
        centre=np.median(points, axis=0) + scale * centre,
        covariance=covariance * np.outer(scale, scale),
        used=used,
    )


def _spread(points: Array) -> Array:
    """Of each dimension: its median deviation, so that units do not matter."""
    apart = np.median(np.abs(points - np.median(points, axis=0)), axis=0)
    return np.asarray(np.where(apart > 0, apart, np.std(points, axis=0)))


def _consistent(share: float, size: int) -> float:
    """What the covariance of the innermost share of normal points is short of."""
    edge = chi2.ppf(share, size)
    return float(share / chi2.cdf(edge, size + 2))


def _closest(points: Array, half: int) -> Places:
    """Which of the points are the half of least determinant."""
    count, size = points.shape
    rng = np.random.default_rng(_SEED)
    begun = []
    for _ in range(_STARTS):
        chosen = rng.choice(count, size + 1, replace=False)
        for _ in range(2):
            chosen, determinant = _concentrated(points, chosen, half)
        begun.append((determinant, chosen))
    begun.sort(key=lambda each: each[0])
    return min((_settled(points, *each, half) for each in begun[:_KEPT]), key=lambda e: e[0])[1]


def _settled(points: Array, determinant: float, chosen: Places, half: int) -> tuple[float, Places]:
    """A choice after as many steps as it changes in."""
    for _ in range(_STEPS):
        further, lower = _concentrated(points, chosen, half)
        if not lower < determinant:
            break
        determinant, chosen = lower, further
    return determinant, chosen


def _concentrated(points: Array, chosen: Places, half: int) -> tuple[Places, float]:
    """The half that is closest to the chosen points, and the determinant of its covariance."""
    covariance = np.atleast_2d(np.cov(points[chosen].T, ddof=0))
    least = 1e-12 * max(np.trace(covariance), 1e-300)  # of points in a plane
    covariance = covariance + least * np.eye(len(covariance))
    distances = squared_distances(points, points[chosen].mean(axis=0), covariance)
    nearest = np.argpartition(distances, half - 1)[:half]
    return nearest, float(np.linalg.det(np.atleast_2d(np.cov(points[nearest].T, ddof=0))))
