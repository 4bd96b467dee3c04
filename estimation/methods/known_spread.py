"""What values that are known of the records with a deviation add to an estimate's covariance."""

from dataclasses import replace

import numpy as np

from axisid.estimation.joint import Known, Layout, layout_of
from axisid.estimation.problems import Problem
from axisid.support.arrays import Array

from .method import Fit

_STEP = 1e-3  # of a deviation's size at which the model is differenced, at least of the value


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
        for value, deviation in known.doubtful:
            moved = fit.solution.influence.T @ _changed(problem, layout, fit, known, value)
            moved = deviation * moved
            spread = np.outer(moved, moved)
            total = spread if total is None else total + spread
    return total


def _changed(problem: Problem, layout: Layout, fit: Fit, known: Known, value: float) -> Array:
    """Slope of what the model leaves of each row, (n,), by a value that is known."""
    step = _STEP * (abs(value) or 1.0)
    values = tuple(v + step if v == value else v for v in known.values)
    other = replace(known, values=values)
    moved = layout_of(
        problem.axis,
        len(problem.data),
        [other if each is known else each for each in layout.known],
        layout.local,
        commanded=layout.gain is not None,
    )
    theta, slopes = fit.solution.theta, []
    for i, data in enumerate(problem.data):
        if known.values[i] != value:
            slopes.append(np.zeros(len(data.row_numbers)))
            continue
        force = [each.force_of(data, theta, i) for each in (layout, moved)]
        slopes.append((force[0] - force[1]) / step)
    found = np.concatenate(slopes)
    return found if problem.row_weights is None else problem.row_weights * found
