"""Several parameters held against zero at once, with a covariance that was estimated itself."""

from scipy.special import fdtrc


def joint_p(
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
    left = max(freedom - restrictions + 1, 1.0)
    return float(
        fdtrc(restrictions, left, square * left / ((left + restrictions - 1) * restrictions))
    )
