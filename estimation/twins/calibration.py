"""Bias and deviations of an estimate, by the twins of its loop."""

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from axisid.estimation.problems import Solver
from axisid.estimation.regression import Covariance, Form, Solution, delta_method
from axisid.support.arrays import Array

from .twins import Twins

_LEVEL = 0.975  # of the interval whose width twins and record are to have alike


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """What twins tell of an estimate.

    Attributes
    ----------
    bias : (p,) array
        Mean of the twins' physical parameters, less those of their loops.
    scale : (p,) array
        What deviations are to be multiplied by.
    own_scale : (k,) array
        The same of the regression's own parameters.
    count : int
        How many twins tell it.
    """

    bias: Array
    scale: Array
    own_scale: Array
    count: int


def calibrated(
    twins: Twins,
    form: Form,
    solver: Solver,
    solution: Solution,
    covariance: Covariance,
    freedom: Array,
) -> Calibration | None:
    """Bias of an estimate, and what its deviations lack; None where too few twins can be solved.

    A covariance is the pivot, whose law the twins have: what they are off by in their own
    deviations, the bootstrap-t of [EfronTibshirani1993]_.

    Parameters
    ----------
    twins : Twins
    form : Form
        At the estimate.
    solver : callable
        Of the estimate.
    solution : Solution
        Of the records.
    covariance : Covariance
    freedom : (k,) array
        Degrees of freedom by which intervals are made of the deviations.

    Returns
    -------
    Calibration or None
    """
    solved = twins.solutions(form, solver)
    count = len(solved)
    if 2 * count < twins.count:
        return None
    jacobian = form.physical(solution.theta)[1]
    # As many are a sample: its spread is Student's, and its mean is not known exactly.
    wider = stdtrit(count - 1.0, _LEVEL) / stdtrit(freedom, _LEVEL) * np.sqrt(1 + 1 / count)
    spreads = [covariance.matrix(each) for each in solved]
    own = np.array([each.theta for each in solved]) - form.regressed(twins.at)
    off = np.array([form.physical(each.theta)[0] for each in solved]) - twins.at
    mapped = [delta_method(each, jacobian) for each in spreads]
    of_fewest = np.where(jacobian != 0, wider, np.inf).min(axis=1)
    return Calibration(
        bias=off.mean(axis=0),
        scale=of_fewest * _pivot(off, mapped),
        own_scale=wider * _pivot(own, spreads),
        count=count,
    )


def _pivot(off: Array, covariances: list[Array]) -> Array:
    """Deviation of what twins are off by, in their own deviations."""
    own = np.sqrt(np.maximum([np.diag(each) for each in covariances], 0.0))
    apart = np.divide(off, own, out=np.zeros_like(off), where=own > 0)
    return np.asarray(np.std(apart, axis=0, ddof=1))
