"""How a method solves rows, and what it makes of others: of a loop, of another gain, of steps.

The loop of an estimate is a record without noise. It, and how an estimate depends on the drive
gain, keep the instruments: only what was measured is changed.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from axisid.estimation.regression import (
    Equations,
    Form,
    InverseForm,
    LossWeights,
    QrFactors,
    Solution,
    checked_columns,
    factor,
    instrumental_variables,
)
from axisid.estimation.signals import FilteredRecord, hold_mean
from axisid.estimation.simulation import Simulation, logged_control
from axisid.support.arrays import Array

from .problem import Problem


@dataclass(frozen=True, slots=True, kw_only=True)
class Solver:
    """What solves rows of a form: least squares, unless loops were simulated with an estimate.

    Attributes
    ----------
    loop : QrFactors or None
        The simulated loop's columns, the same whatever the rows: the instruments. None for least
        squares.
    slopes : Equations or None
        The simulated left side about the estimate, by which the measured one alone is explained:
        output error. None where the rows have their own regressor.
    counts : LossWeights or None
        What each row counted under a loss; None where all rows count alike.
    """

    loop: QrFactors | None = None
    slopes: Equations | None = None
    counts: LossWeights | None = None

    def __call__(self, form: Form, rows: Equations) -> Solution:
        """Solve rows of a form."""
        names = [q.label for q in form.quantities]
        right = self.slopes or rows
        left = rows.left - right.intercept
        Z = factor(right.regressor, names) if self.loop is None else self.loop
        X = Z if self.loop is None else checked_columns(right.regressor, names)
        return instrumental_variables(left, X, Z, self.counts)


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
    return solver(form, problem.reduced(form, signals)).residuals / problem.row_weights


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
