"""Which of several points are like one another, and what is usual among those."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import fdtrc, fdtri, gammaincinv

from axisid.support.arrays import Array, Exact

from .robust_scatter import robust_scatter, squared_distances

#: Beyond it nothing is compared: products of a few such numbers are no number any more.
LARGEST = 1e100
#: Quantile of the distances within which no point is looked at, and how many are beyond it of many.
_NEAR, _LOOKED_AT = 0.9, 20
_FIRST = 0.8  # part of the level for the furthest point; the others share the rest as 1, 1/4, 1/9
_FLAT = 1e-9  # of the estimates' variances: what keeps equal values solvable


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Usual(Exact):
    """What is usual among points.

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
class Alike(Exact):
    """Points that are like one another, and the others.

    Attributes
    ----------
    usual : Usual
        Among the points that are alike.
    far : tuple of int
        Places of the others, the furthest first.
    distances : array, (n,)
        Squared, of all points.
    p_values : array, (n,)
        Of a distance as large, of one point that is like those that are alike.
    """

    usual: Usual
    far: tuple[int, ...]
    distances: Array
    p_values: Array


def alike_points(values: Array, covariances: Array, level: float) -> Alike:
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
    robust = _usual(centre, scatter, covariances).distances(values, covariances)
    order = np.argsort(-robust, kind="stable")
    near = max(1 - _LOOKED_AT / len(values), _NEAR)
    far = int(np.count_nonzero(robust > 2 * gammaincinv(size / 2, near)))
    most = min(far, (len(values) - size) // 2)
    count = _outlying(values[order], covariances[order], most, level)
    alike = order[count:]
    usual = _usual_of(values[alike], covariances[alike])
    distances = usual.distances(values, covariances)
    return Alike(
        usual=usual,
        far=tuple(sorted(map(int, order[:count]), key=lambda i: -distances[i])),
        distances=distances,
        p_values=np.asarray(of_a_new_point(distances, len(alike), size)),
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
    found = 0
    for i in range(most):
        usual = _usual_of(values[i + 1 :], covariances[i + 1 :])
        (distance,) = usual.distances(values[i : i + 1], covariances[i : i + 1])
        left = len(values) - i
        own = (1 - _FIRST) * 6 / (np.pi * i) ** 2 if i else _FIRST
        if of_a_new_point(distance, left - 1, size) * left < level * own:
            found = i + 1
    return found


def _usual_of(values: Array, covariances: Array) -> Usual:
    """What is usual among points that are alike."""
    return _usual(values.mean(axis=0), np.atleast_2d(np.cov(values.T)), covariances)


def _usual(centre: Array, scatter: Array, covariances: Array) -> Usual:
    """Scatter of the points without that of their estimates; none where that explains it."""
    within = np.median(covariances, axis=0)  # one that knows little says nothing of the others
    # Both in units of the scatter, so that no parameter's unit decides what is too small.
    root = np.linalg.cholesky(scatter + _FLAT * np.diag(np.diag(within)))
    excess = np.linalg.solve(root, np.linalg.solve(root, scatter - within).T)
    sizes, axes = np.linalg.eigh((excess + excess.T) / 2)
    turned = root @ axes
    between = turned * np.maximum(sizes, 0.0) @ turned.T
    return Usual(centre=centre, between=between, count=len(covariances))


def of_a_new_point(distance: Any, count: int, size: int) -> Any:
    """Probability of a squared distance as large, from the mean and covariance of other points.

    Parameters
    ----------
    distance : float or array
    count, size : int
        How many other points there are, and in how many dimensions.
    """
    scaled = distance * count * (count - size) / ((count + 1) * (count - 1) * size)
    return fdtrc(size, count - size, scaled)


def limit_of_a_new_point(probability: float, count: int, size: int) -> float:
    """The squared distance that has a probability by `of_a_new_point`."""
    scaled = float(fdtri(size, count - size, 1 - probability))
    return scaled * (count + 1) * (count - 1) * size / (count * (count - size))
