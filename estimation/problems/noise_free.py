"""The loop of an estimate as a record without noise, and how an estimate depends on the drive gain.

Both keep the instruments: only what was measured is changed.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from axisid.estimation.regression import Form, InverseForm, Solution
from axisid.estimation.signals import FilteredRecord, Signals, about_samples
from axisid.estimation.simulation import Simulation, logged_control
from axisid.support.arrays import Array

from .problem import Problem
from .solver import Solver

_STEP = 1e-4  # of the gain


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
    residuals = solver(form, problem.reduced(form, signals)).residuals
    return residuals if problem.row_weights is None else residuals / problem.row_weights


def slopes_by_gain(
    form: Form, problem: Problem, solution: Solution, solver: Solver
) -> tuple[Array, Array]:
    """Slopes of the physical parameters, (p,), and of the regression's, (k,), by ln(gain).

    Without known terms every linear parameter is proportional to the gain; a known term keeps its
    size, so that the others take what it leaves. So does what the drive makes without its gain.
    """
    if isinstance(form, InverseForm):  # the force is on the left alone
        rows = problem.stacked(lambda data: data.reduce(data.force_by_gain))
        rows = rows if problem.row_weights is None else problem.row_weights * rows
        slope = solution.response.T @ rows
        return slope, slope
    ahead, behind = (
        solver(form, problem.reduced(form, signals)).theta
        for signals in (
            [_with_gain(data, scale) for data in problem.data] for scale in (1 + _STEP, 1 - _STEP)
        )
    )
    physical = form.physical(ahead)[0] - form.physical(behind)[0]
    return physical / (2 * _STEP), (ahead - behind) / (2 * _STEP)


def noise_free_record(data: FilteredRecord, loops: Sequence[Simulation]) -> FilteredRecord:
    """The record as its simulated loops have it, under the same filter.

    A column that was recorded is made of the loops as its sensor would see them.
    """
    record = data.record
    jumps = data.axis.axis.jumps
    sensed = jumps and data.prefilter.hold != "zoh"  # else it is what is held from the sample on
    made: dict[str, Callable[[Simulation], Array]] = {
        "position": lambda s: s.position,
        "velocity": lambda s: s.velocity,
        "acceleration": lambda s: about_samples(s.acceleration, [0]) if jumps else s.acceleration,
        "control": lambda s: logged_control(data.axis, s),
        "force": lambda s: about_samples(s.force, [0]) if sensed else s.force,
    }
    columns = {
        role: np.concatenate([seen(loop) for loop in loops])
        for role, seen in made.items()
        if getattr(record, role) is not None
    }
    return replace(data, record=record.with_motion(columns))


def _with_gain(data: FilteredRecord, scale: float) -> Signals:
    """The signals with another drive gain, on which a measured force does not depend."""
    signals = data.signals
    fixed = signals.force - data.force_by_gain
    return replace(signals, force=(signals.force - fixed) * scale + fixed)
