"""Bias and deviations of an estimate, as its twins tell them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from axisid.estimation.estimation_problem import Solver
from axisid.estimation.regression import Covariance, Form, Solution, correlation, delta_method
from axisid.support.arrays import Array

from .twins import Twins

_ROUNDING = 1e-9  # of a parameter: what simulated loops that reverse make of the last digit


@dataclass(frozen=True, slots=True, kw_only=True)
class BootstrapCorrection:
    """What twins tell of an estimate.

    Attributes
    ----------
    twins : Twins
    off : (R, p) array
        The twins' physical parameters, less those of their loops.
    theta_error : (R, k) array
        The same of the regression's own parameters.
    scaled : (p,) array, (p, p) array
        What deviations are to be multiplied by, and the correlation as the twins scatter; of the
        covariance where they are too few to tell it.
    theta_scaled : (k,) array, (k, k) array
        The same of the regression's own parameters.
    residuals : (n, R) array
        What the estimator leaves of the twins.
    """

    twins: Twins
    off: Array
    theta_error: Array
    scaled: tuple[Array, Array]
    theta_scaled: tuple[Array, Array]
    residuals: Array

    @property
    def count(self) -> int:
        """How many twins tell it."""
        return len(self.off)

    @property
    def bias(self) -> Array:
        """Mean of what the twins are off by, (p,)."""
        return np.asarray(self.off.mean(axis=0))


def bootstrap_correction(
    twins: Twins,
    form: Form,
    solver: Solver,
    solution: Solution,
    covariance: Covariance,
) -> BootstrapCorrection | None:
    """Bias of an estimate, and what its deviations lack; None where too few twins can be solved.

    A covariance is the pivot, whose law the twins have: what they are off by in their own
    deviations, the bootstrap-t of [EfronTibshirani1993]_.

    Parameters
    ----------
    twins : Twins
    form : Form
        At the estimate.
    solver : Solver
        Of the estimate.
    solution : Solution
        Of the records.
    covariance : Covariance

    Returns
    -------
    BootstrapCorrection or None
    """
    solved = twins.solutions(form, solver)
    if not 0 < twins.count <= 2 * len(solved):
        return None
    jacobian = form.physical(solution.theta)[1]
    regressed = form.regressed(twins.at)
    theta_error = np.array([each.theta for each in solved]) - regressed
    off = np.array([form.physical(each.theta)[0] for each in solved]) - twins.at
    # Of the records, and then of each twin.
    own_covariances = [covariance.matrix(each) for each in (solution, *solved)]
    covariances = [delta_method(each, jacobian) for each in own_covariances]
    return BootstrapCorrection(
        twins=twins,
        off=off,
        theta_error=theta_error,
        scaled=_pivot(off, covariances, twins.at),
        theta_scaled=_pivot(theta_error, own_covariances, regressed),
        residuals=np.column_stack([each.residuals for each in solved]),
    )


def _pivot(off: Array, covariances: Sequence[Array], at: Array) -> tuple[Array, Array]:
    """Deviation of what twins are off by beside their bias, in their own; and its correlation.

    Parameters
    ----------
    off : (R, p) array
    covariances : sequence of (p, p) arrays
        Of the estimate, whose deviations are no less than rounding of a loop, and each twin's own.
    at : (p,) array
        Parameters of their loops.
    """
    if len(off) == 1:
        return np.ones(len(at)), np.nan_to_num(correlation(covariances[0]))
    deviations = np.sqrt(np.maximum([np.diag(each) for each in covariances], 0.0))
    centred = np.vstack([_ROUNDING * np.abs(at), off - off.mean(axis=0)])
    least, *t = np.divide(centred, deviations, out=np.zeros_like(centred), where=deviations > 0)
    scale = np.maximum(np.std(t, axis=0, ddof=1), least)
    # Opposite twins are one sample of a straight line.
    tells = len(off) // 2 > len(at)
    matrix = np.atleast_2d(np.cov(centred[1:].T)) if tells else covariances[0]
    correlations = np.nan_to_num(correlation(matrix))
    np.fill_diagonal(correlations, 1.0)
    return scale, correlations
