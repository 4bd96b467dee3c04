"""What values that are known of the records with a deviation add to an estimate's covariance."""

from dataclasses import replace

import numpy as np

from axisid.estimation.joint import Known, Layout, layout_of
from axisid.estimation.problems import Problem
from axisid.support.arrays import Array

from .method import Fit

_STEP = 1e-3  # of the value, over which the model is differenced


def known_spread(problem: Problem, fit: Fit) -> Array | None:
    """What wrong known values add to the regression's covariance, (k, k); None for exact ones.

    A value that is wrong by a deviation changes the force that the model needs, row by row, and the
    estimate by the influence of the rows.
    """
    layout = problem.layout
    if layout is None:
        return None
    total: Array | None = None
    for known in layout.known:
        for told in known.doubtful:
            moved = told[1] * fit.solution.response.T @ _changed(problem, layout, fit, known, told)
            spread = np.outer(moved, moved)
            total = spread if total is None else total + spread
    return total


def _changed(
    problem: Problem, layout: Layout, fit: Fit, known: Known, told: tuple[float, float]
) -> Array:
    """Slope of what the model leaves of each row, (n,), by a value that is known."""
    step = _STEP * (abs(told[0]) or 1.0)
    of_it = [pair == told for pair in zip(known.values, known.deviations, strict=True)]
    values = tuple(v + step * own for v, own in zip(known.values, of_it, strict=True))
    other = replace(known, values=values)
    moved = layout_of(
        problem.axis,
        len(problem.data),
        [other if each is known else each for each in layout.known],
        layout.local,
        commanded=layout.gain is not None,
    )
    theta = fit.solution.theta
    # What appears only beside it, as at a value of 0, has no estimate to be moved.
    there = dict(zip((q.name for q in layout.quantities), theta, strict=True))
    other_theta = np.array([there.get(q.name, 0.0) for q in moved.quantities])
    slopes = []
    for i, data in enumerate(problem.data):
        if not of_it[i]:
            slopes.append(np.zeros(len(data.row_numbers)))
            continue
        change = layout.force_of(data, theta, i) - moved.force_of(data, other_theta, i)
        slopes.append(change / step)
    found = np.concatenate(slopes)
    return found if problem.row_weights is None else problem.row_weights * found
