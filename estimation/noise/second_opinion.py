"""Instruments less DIDIM, parameter by parameter, held against chance.

Both explain the same force, the one by the motion that was measured, the other by that of the
simulated loop, which has neither the encoder's noise nor the filter's error. Less the filter's own
bias they are estimates of the same, ``sum A_t e_t`` each with residuals of its own: the difference
has the scores ``A_iv e_iv - A_didim e_didim`` on the same rows, and their covariance, consistent
with autocorrelation. What parts the two beyond that is a wrong control law, which moves DIDIM
alone, or what the filter or a coarse encoder does to the instruments.
"""

import numpy as np

from axisid.estimation.estimates import Estimate, solver_of
from axisid.estimation.problems import Solver
from axisid.estimation.regression import Equations, Solution
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError

from .bias import NoiseBias, tested


def second_opinion(iv: Estimate, didim: Estimate) -> dict[str, NoiseBias]:
    """Instruments less DIDIM by physical parameter; empty where it cannot be tested.

    Parameters
    ----------
    iv, didim : Estimate
        Of the same rows of the inverse form.
    """
    if iv.is_direct or iv.X.shape != didim.X.shape:
        return {}
    try:
        scores = _scores(iv, solver_of(iv)) - _scores(didim, solver_of(didim))
    except EstimationError:
        return {}
    apart = iv.corrected - didim.corrected
    solution = Solution(
        theta=apart,
        residuals=np.ones(len(scores)),
        inverse_factor=np.eye(len(apart)),  # of no covariance that is asked for here
        influence=scores,
        neighbours=didim.neighbours,
    )
    return tested(solution, didim, iv)  # by the deviations of DIDIM, which are the smaller


def _scores(estimate: Estimate, solver: Solver) -> Array:
    """What each row moves the physical parameters by, (n, p)."""
    weights = np.ones(len(estimate.y)) if estimate.weights is None else estimate.weights
    rows = Equations(
        left=weights * estimate.y,
        intercept=np.zeros(len(estimate.y)),
        regressor=weights[:, None] * estimate.X,
    )
    influence = solver(estimate.form, rows).influence_as_counted @ estimate.jacobian.T
    return np.asarray(influence * (weights * estimate.net_residuals)[:, None], dtype=float)
