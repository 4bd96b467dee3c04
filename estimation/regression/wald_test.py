"""Wald's statistic of restrictions, and its p-value with few degrees of freedom."""

import numpy as np
from scipy.special import fdtrc

from axisid.support.arrays import Array

from .covariance import correlation

_CERTAIN = 1e9  # degrees of freedom, from which F is chi-squared to rounding
_SAME = 1e-9  # of the eigenvalues of a correlation matrix


def wald(difference: Array, covariance: Array) -> tuple[float, int]:
    """``d' V^-1 d`` of a difference (k,), and in how many directions it is told.

    What has no deviation, or an infinite one, is left out, and so are directions in which rounding
    alone differs.
    """
    variances = np.diag(covariance)
    there = (variances > 0) & np.isfinite(variances)
    if not there.any():
        return 0.0, 0
    sizes, directions = np.linalg.eigh(correlation(covariance[np.ix_(there, there)]))
    kept = sizes > _SAME * sizes[-1]
    along = directions[:, kept].T @ (difference[there] / np.sqrt(variances[there]))
    return float(np.sum(along**2 / sizes[kept])), int(kept.sum())


def hotelling_p_value(
    square: float, restrictions: int, freedom: float, *, one_variance: bool = False
) -> float:
    """P-value of ``d' V^-1 d``, Hotelling's T squared.

    A covariance matrix of ``nu`` degrees of freedom makes ``(nu - q + 1)/(nu q)`` times it F
    distributed with q and ``nu - q + 1``. Where the shape of the matrix is known, and one variance
    alone is estimated, ``1/q`` times it is F with q and ``nu``.

    Parameters
    ----------
    square : float
    restrictions : int
        q.
    freedom : float
        Of the covariance, the effective degrees where scores are alike.
    one_variance : bool
        Whether the covariance is one variance times a matrix without chance in it.

    References
    ----------
    [Hotelling1931]_; for covariances that allow for autocorrelation, [Sun2013]_.
    """
    if one_variance:
        return float(fdtrc(restrictions, freedom, square / restrictions))
    dof = min(max(freedom - restrictions + 1, 1.0), _CERTAIN)
    return float(
        fdtrc(
            restrictions,
            dof,
            square * dof / ((dof + restrictions - 1) * restrictions),
        )
    )
