"""How far the residuals of an output error follow the motion where nothing is wrong with it.

Its regressor has no noise that residuals could drown in, and what a loop makes of an encoder's
steps, or of noise that shakes friction, comes again where the motion does. So the residuals of the
same loops with such an encoder or noise, left by the same estimator, are what it is held against.
"""

from contextlib import suppress

import numpy as np

from axisid.estimation.estimates import Estimate, solver_of
from axisid.estimation.problems import Problem, rows_as_measured
from axisid.estimation.regression import residual_tests
from axisid.support.errors import AxisidError


def following_as_measured(problem: Problem, estimate: Estimate) -> float:
    """Largest correlation of such residuals with a column, in deviations; 0 where there are none.

    Parameters
    ----------
    problem : Problem
        What the estimate was made from.
    estimate : Estimate
        Of output error.
    """
    weights = np.ones(len(estimate.y)) if estimate.weights is None else estimate.weights
    columns, largest = weights[:, None] * estimate.X, 0.0
    with suppress(AxisidError):  # what cannot be simulated so is held against nothing
        solver = solver_of(estimate)
        for rows in rows_as_measured(estimate.form, problem, estimate.physical):
            left = solver(estimate.form, rows).residuals
            tests = residual_tests(left, columns, neighbours=estimate.neighbours)
            largest = max(largest, tests.cross_z)
    return largest
