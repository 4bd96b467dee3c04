"""Bias and deviations of an estimate, by the twins of its loop."""

from dataclasses import dataclass

import numpy as np

from axisid.estimation.problems import Solver
from axisid.estimation.regression import Covariance, Form, Solution, delta_method
from axisid.support.arrays import Array

from .twins import Twins

_ROUNDING = 1e-9  # of a parameter: what simulated loops that reverse make of the last digit


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """What twins tell of an estimate.

    Attributes
    ----------
    off : (R, p) array
        The twins' physical parameters, less those of their loops.
    scale : (p,) array
        What deviations are to be multiplied by.
    own_scale : (k,) array
        The same of the regression's own parameters.
    residuals : (n, R) array
        What the estimator leaves of the twins.
    """

    off: Array
    scale: Array
    own_scale: Array
    residuals: Array

    @property
    def count(self) -> int:
        """How many twins tell it."""
        return len(self.off)

    @property
    def bias(self) -> Array:
        """Mean of what the twins are off by, (p,)."""
        return np.asarray(self.off.mean(axis=0))

    @property
    def freedom(self) -> int:
        """Degrees of freedom of the scale: as many pairs of opposite twins are a sample."""
        return max(self.count // 2, 1)


def calibrated(
    twins: Twins,
    form: Form,
    solver: Solver,
    solution: Solution,
    covariance: Covariance,
) -> Calibration | None:
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
    Calibration or None
    """
    solved = twins.solutions(form, solver)
    count = len(solved)
    if not 0 < twins.count <= 2 * count:
        return None
    jacobian = form.physical(solution.theta)[1]
    own = np.array([each.theta for each in solved]) - form.regressed(twins.at)
    off = np.array([form.physical(each.theta)[0] for each in solved]) - twins.at
    scale, own_scale = np.ones(off.shape[1]), np.ones(own.shape[1])
    if count > 1:
        spreads = [covariance.matrix(each) for each in solved]
        mapped = [delta_method(each, jacobian) for each in spreads]
        scale = _pivot(off, mapped)
        own_scale = _pivot(own, spreads)
        shown = covariance.matrix(solution)
        scale = np.maximum(scale, _rounded(twins.at, delta_method(shown, jacobian)))
        own_scale = np.maximum(own_scale, _rounded(form.regressed(twins.at), shown))
    return Calibration(
        off=off,
        scale=scale,
        own_scale=own_scale,
        residuals=np.column_stack([each.residuals for each in solved]),
    )


def _rounded(values: Array, covariance: Array) -> Array:
    """What deviations are to be multiplied by so that they are no less than rounding of a loop."""
    own = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return np.divide(_ROUNDING * np.abs(values), own, out=np.zeros_like(own), where=own > 0)


def _pivot(off: Array, covariances: list[Array]) -> Array:
    """Deviation of what twins are off by beside their bias, in their own deviations."""
    off = off - off.mean(axis=0)
    own = np.sqrt(np.maximum([np.diag(each) for each in covariances], 0.0))
    apart = np.divide(off, own, out=np.zeros_like(off), where=own > 0)
    return np.asarray(np.std(apart, axis=0, ddof=1))
