"""What values that are known of the records with a deviation add to an estimate's covariance."""

import numpy as np

from axisid.estimation.joint import Layout, moved_layouts
from axisid.estimation.problems import Problem
from axisid.support.arrays import Array

from .method import Fit


def known_spread(problem: Problem, fit: Fit) -> Array | None:
    """What wrong known values add to the regression's covariance, (k, k); None for exact ones.

    A value that is wrong by a deviation changes the force that the model needs, row by row, and the
    estimate by the influence of the rows.
    """
    layout = problem.layout
    if layout is None:
        return None
    moved = [
        fit.solution.response.T @ _changed(problem, layout, other, fit)
        for other in moved_layouts(problem.axis, layout)
    ]
    return np.transpose(moved) @ moved if moved else None


def _changed(problem: Problem, layout: Layout, other: Layout, fit: Fit) -> Array:
    """By how much less the model leaves of each row under another layout, (n,)."""
    theta = fit.solution.theta
    # What appears only beside a value, as at one of 0, has no estimate to be moved.
    there = dict(zip((q.name for q in layout.quantities), theta, strict=True))
    other_theta = np.array([there.get(q.name, 0.0) for q in other.quantities])
    found = np.concatenate(
        [
            layout.force_of(data, theta, i) - other.force_of(data, other_theta, i)
            for i, data in enumerate(problem.data)
        ]
    )
    return found if problem.row_weights is None else problem.row_weights * found
