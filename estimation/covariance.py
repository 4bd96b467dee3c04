"""Covariance of an estimate, and its way through a nonlinear map."""

from typing import Literal

import numpy as np

from .arrays import Array
from .linear import Solution


def iid_covariance(solution: Solution, dof: Literal["n-1", "n-k"] = "n-1") -> Array:
    """``sigma^2 (W'W)^-1`` for independent residuals of equal variance, (k, k).

    W is the regressor of least squares; with instruments it is Z, as [Young2011]_ has it for
    noise-free instruments at convergence.

    Parameters
    ----------
    solution : Solution
        With n residuals and k parameters.
    dof : {"n-1", "n-k"}
        What the residuals' sum of squares is divided by. The published tables of [Janot2019]_ have
        ``n-1`` (the sample variance); ``n-k`` is unbiased. They differ by k/2n.
    """
    n, k = len(solution.residuals), len(solution.theta)
    variance = float(solution.residuals @ solution.residuals) / (n - (1 if dof == "n-1" else k))
    return variance * (solution.inverse_factor @ solution.inverse_factor.T)


def delta_method(covariance: Array, jacobian: Array) -> Array:
    """``J Sigma J'``: first-order covariance of a mapped estimate, symmetric to the last bit."""
    mapped = jacobian @ covariance @ jacobian.T
    return np.asarray((mapped + mapped.T) / 2, dtype=float)
