"""How well parameters that one half of a record gives predict the motion in the other half.

An equation's error on rows that are held out says nothing between cut-offs, each of which filters
what it is held against: noise that biases the parameters makes the rows no harder to explain. The
position is the same for all. So the parameters of each half move the axis under the recorded
control, in windows that each start where the record is, through the other half. What is known of
the bias of filter and noise is taken off them.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.estimates import Estimate
from axisid.estimation.identification import Identification
from axisid.estimation.predictions import WindowPredictions
from axisid.estimation.problems import Problem
from axisid.support.errors import DataError, EstimationError, ModelError

from .held_out import contiguous_blocks, regression_rows

_HORIZON = 0.5  # s, of a window
_HALVES = 2


def held_out_motion(results: Sequence[tuple[Identification, Estimate]]) -> list[float]:
    """Errors of the position of each half, in the coordinate's unit, root mean square.

    Parameters
    ----------
    results : sequence of (Identification, Estimate)
        Of the same records.

    Returns
    -------
    list of float
        Infinite where an axis does not get through a window, NaN where it cannot be told: there is
        no control or no position, or too few rows.
    """
    (first, estimate), *_ = results
    data = first.problem.data
    try:
        predictions = WindowPredictions(
            estimate.form, [d.axis for d in data], [d.record for d in data], _HORIZON
        )
    except (DataError, EstimationError, ModelError):
        return [math.nan] * len(results)
    return [_error(predictions, result.problem, each) for result, each in results]


def _error(predictions: WindowPredictions, problem: Problem, estimate: Estimate) -> float:
    gap = max(data.sampling.filter.memory for data in problem.data)
    rows, squares = regression_rows(estimate), []
    known = np.array([value.value - value.corrected for value in estimate.parameters.values()])
    try:
        halves = contiguous_blocks(len(rows.left), gap, len(estimate.theta), count=_HALVES)
        for half in halves:
            theta = rows.at(half.training).by_least_squares().theta
            physical = estimate.form.physical(theta)[0] - known
            predictions.settle(physical)
            errors = predictions(physical[None]).errors[:, 0]
            squares.append(errors[_within(predictions, problem, half.held_out)] ** 2)
    except DataError:
        return math.nan
    except (EstimationError, ModelError):
        return math.inf
    found = float(np.sqrt(np.mean(np.concatenate(squares))))
    return found if math.isfinite(found) else math.inf


def _within(
    predictions: WindowPredictions, problem: Problem, rows: NDArray[np.intp]
) -> NDArray[np.bool_]:
    """Which predicted samples are measurements and lie where the rows do."""
    found, counted = [], predictions.counted > 0
    for data, span, samples in zip(problem.data, problem.spans, predictions.samples, strict=True):
        own = rows[(rows >= span.start) & (rows < span.stop)] - span.start
        ends = data.row_numbers[own[[0, -1]]] if own.size else (0, -1)
        found.append((samples >= ends[0]) & (samples <= ends[1]))
    return np.concatenate(found) & counted
