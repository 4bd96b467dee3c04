"""What an estimator makes of its own loops without noise, behind the filter of the records.

The loop of an estimate is a record without noise; its instruments are kept, as only what was
measured is changed.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from axisid.estimation.regression import Form
from axisid.estimation.signals import FilteredRecord, hold_mean
from axisid.estimation.simulation import Simulation, logged_control
from axisid.support.arrays import Array

from .problem import Problem
from .solver import Solver


def noise_free_record(data: FilteredRecord, loops: Sequence[Simulation]) -> FilteredRecord:
    """The record as its simulated loops have it, under the same filter.

    A column that was recorded is made of the loops as its sensor would see them.
    """
    record = data.record
    jumps = data.axis.axis.jumps
    sensed = jumps and data.prefilter.hold != "zoh"  # else it is what is held from the sample on
    simulated: dict[str, Callable[[Simulation], Array]] = {
        "position": lambda s: s.position,
        "velocity": lambda s: s.velocity,
        "acceleration": lambda s: hold_mean(s.acceleration, [0]) if jumps else s.acceleration,
        "control": lambda s: logged_control(data.axis, s),
        "force": lambda s: hold_mean(s.force, [0]) if sensed else s.force,
    }
    columns: dict[str, Any] = {
        role: np.concatenate([seen(loop) for loop in loops])
        for role, seen in simulated.items()
        if getattr(record, role) is not None
    }
    return data.with_columns(**columns)


def noise_free_residuals(
    form: Form, problem: Problem, loops: tuple[Simulation, ...], solver: Solver
) -> Array:
    """What filtering, differencing and decimation alone leave of an estimate's own loop, (n,).

    Parameters
    ----------
    form : Form
        At its point, if it is linearised.
    problem : Problem
        What the estimate was made from.
    loops : tuple of Simulation
        Of the records, with the estimate; one for each segment.
    solver : Solver
        Of the estimate.
    """
    signals = [
        noise_free_record(data, of_one).signals
        for data, of_one in zip(problem.data, problem.by_record(loops), strict=True)
    ]
    return solver(form, problem.reduced(form, signals)).residuals / problem.row_weights
