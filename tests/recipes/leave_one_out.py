"""What leaving out one row at a time says of a least-squares estimate."""

from dataclasses import dataclass

import numpy as np

from .covariance import Covariance, applied_covariance
from .linear import CovarianceEstimate, Solution


@dataclass(frozen=True, slots=True)
class LeaveOneOut(Covariance):
    """HC3: each residual over one less its leverage, close to the jackknife."""

    def applied(self, solution: Solution) -> CovarianceEstimate:
        """See `Covariance.applied`."""
        orthonormal = np.linalg.solve(solution.inverse_factor, solution.influence.T)
        residuals = solution.residuals / (1 - np.sum(orthonormal**2, axis=0))
        scores = solution.influence * residuals[:, None]
        description = "heteroscedasticity-robust, each row judged by the others (HC3)"
        return applied_covariance(scores.T @ scores, scores.shape, description)
