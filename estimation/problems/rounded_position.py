"""What the steps of a recorded position move least squares by, where the law did not have them."""

from dataclasses import replace

import numpy as np

from axisid.estimation.records import Record, quantum_of
from axisid.estimation.regression import Form
from axisid.estimation.signals import FilteredRecord
from axisid.estimation.thresholds import MIN_STEP_DIFFERENCES
from axisid.support.arrays import Array

from .solver import Solver

_DRAWS = 4  # each once with either sign


def position_step(record: Record) -> float:
    """What a recorded position is rounded to; 0 where nothing is known of it."""
    if record.integrated:
        return 0.0
    return quantum_of(record.position, int(MIN_STEP_DIFFERENCES.value))


def moved_by_rounding(form: Form, data: FilteredRecord, step: float, physical: Array) -> Array:
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
    rng, found = np.random.default_rng(0), []
    for _ in range(_DRAWS):
        noise = step * rng.uniform(-0.5, 0.5, len(data.record))
        for sign in (1.0, -1.0):
            position = data.record.position + sign * noise
            noisy = replace(data, record=replace(data.record, position=position))
            rows = form.equations(noisy.signals).reduced(noisy)
            found.append(form.physical(Solver()(form, rows).theta)[0] - physical)
    return np.asarray(np.mean(found, axis=0), dtype=float)
