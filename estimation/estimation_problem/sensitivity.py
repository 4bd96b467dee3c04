"""How an estimate depends on the drive gain, and on the steps of an encoder.

Its instruments are kept: only what was measured is changed.
"""

from dataclasses import replace

import numpy as np

from axisid.estimation.regression import Form, InverseForm, Solution
from axisid.estimation.signals import FilteredRecord
from axisid.support.arrays import Array

from .problem import Problem
from .solver import Solver

_STEP = 1e-4  # of the gain


def jacobian_by_gain(
    form: Form, problem: Problem, solution: Solution, solver: Solver
) -> tuple[Array, Array]:
    """Slopes of the physical parameters, (p,), and of the regression's, (k,), by ln(gain).

    Without known terms every linear parameter is proportional to the gain; a known term keeps its
    size, so that the others take what it leaves. So does what the drive makes without its gain.
    """
    if isinstance(form, InverseForm):  # the force is on the left alone
        rows = problem.stacked(lambda data: data.reduce(data.force_by_gain))
        slope = solution.response.T @ (problem.row_weights * rows)
        return slope, slope
    # A measured force does not depend on the gain.
    shifted = [
        [replace(d.signals, force=d.signals.force + step * d.force_by_gain) for d in problem.data]
        for step in (_STEP, -_STEP)
    ]
    ahead, behind = (solver(form, problem.reduced(form, each)).theta for each in shifted)
    physical = form.physical(ahead)[0] - form.physical(behind)[0]
    return physical / (2 * _STEP), (ahead - behind) / (2 * _STEP)


_DRAWS = 4  # each once with either sign


def quantisation_bias(form: Form, data: FilteredRecord, step: float, physical: Array) -> Array:
    """About what the steps of a position, that no control answers to, move an estimate by, (p,).

    Rounding adds noise that is uniform within a step. As much again moves the estimate about as
    far again, to first order in its variance: the simulation step of Cook and Stefanski's SIMEX.

    Parameters
    ----------
    form : Form
        At its point, if it is linearised.
    data : FilteredRecord
    step : float
        Of the position, SI.
    physical : (p,) array
        Least squares of the record as it is.
    """
    rng, changes = np.random.default_rng(0), []
    for _ in range(_DRAWS):
        noise = step * rng.uniform(-0.5, 0.5, len(data.record))
        for sign in (1.0, -1.0):
            position = data.record.position + sign * noise
            noisy = data.with_columns(position=position)
            rows = form.equations(noisy.signals).reduced(noisy)
            changes.append(form.physical(Solver()(form, rows).theta)[0] - physical)
    return np.asarray(np.mean(changes, axis=0), dtype=float)
