"""How the steps of an encoder bias an estimate, by simulation and extrapolation."""

import numpy as np

from axisid.estimation.estimation_problem import Solver
from axisid.estimation.regression import Form
from axisid.estimation.signals import FilteredRecord
from axisid.support.arrays import Array

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
