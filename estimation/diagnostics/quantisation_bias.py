"""Bias of an estimate by the steps of an encoder, by simulation and extrapolation."""

import numpy as np

from axisid.estimation.estimation_problem import Solver
from axisid.estimation.regression import Form
from axisid.estimation.signals import FilteredRecord
from axisid.support.arrays import Array

_DRAWS = 4  # of the added noise, each used with both signs


def quantisation_bias(form: Form, data: FilteredRecord, step: float, physical: Array) -> Array:
    """Return the bias of each parameter by the steps of a logged position, (p,).

    The log has these steps, but the control loop does not read them.

    Rounding acts as noise that is uniform within a step. Further noise of the same size changes the
    estimate by about the same bias once more, to first order in the variance of the noise. This is
    the simulation step of Cook and Stefanski's SIMEX.

    Parameters
    ----------
    form : Form
        Form at its operating point, if it is linearised.
    data : FilteredRecord
        The record.
    step : float
        Step of the position, SI.
    physical : (p,) array
        Least-squares estimate from the record without added noise.
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
