"""What residuals are like where nothing is wrong: those of loops that are measured as the record.

The regressor of an output error has no noise that residuals could drown in, and what a loop makes
of an encoder's steps, or of noise that shakes friction, comes again where the motion does. So its
residuals are held against those of the same loops with such an encoder or noise, left by the same
estimator.

Of a velocity that is measured in steps almost nothing is left at a constant speed, and all of it
where the speed changes: such residuals have heavy tails without an outlier in them.
"""

from collections.abc import Iterator
from contextlib import suppress

import numpy as np

from axisid.estimation.estimates import Estimate, solver_of
from axisid.estimation.problems import Problem, rows_as_measured
from axisid.estimation.regression import excess_kurtosis, residual_tests
from axisid.support.arrays import Array
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
    columns = weights[:, None] * estimate.X
    return max(
        (
            residual_tests(left, columns, neighbours=estimate.neighbours).cross_z
            for left in _left_as_measured(problem, estimate)
        ),
        default=0.0,
    )


def tails_as_measured(problem: Problem, estimate: Estimate) -> float:
    """Largest excess kurtosis of such residuals; 0 where there are none.

    Parameters
    ----------
    problem : Problem
        What the estimate was made from.
    estimate : Estimate
    """
    return max(map(excess_kurtosis, _left_as_measured(problem, estimate)), default=0.0)


def _left_as_measured(problem: Problem, estimate: Estimate) -> Iterator[Array]:
    """Residuals of loops with the record's noise or steps, left by the same estimator, (n,) each.

    What cannot be simulated so is held against nothing.
    """
    with suppress(AxisidError):
        solver = solver_of(estimate)
        for rows in rows_as_measured(estimate.form, problem, estimate.physical):
            yield solver(estimate.form, rows).residuals
