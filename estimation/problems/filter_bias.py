"""How the prefilter biases an estimate, and how it depends on the drive gain.

Both keep the instruments: only what was measured is changed.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from axisid.estimation.regression import (
    Equations,
    Form,
    InverseForm,
    QrFactors,
    Solution,
    StepsError,
    checked_columns,
    encoder_step,
    factor,
    instrumental_variables,
    least_squares,
    simulated_position,
    stepped_loops,
    steps_error,
)
from axisid.estimation.signals import FilteredRecord, Signals, about_samples
from axisid.estimation.simulation import Simulation
from axisid.support.arrays import Array

from .problem import Problem

_STEP = 1e-4  # of the gain


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseFree:
    """Rows of the loops that were simulated with an estimate, behind the same filter.

    Attributes
    ----------
    regressor : (n, k) array
    residuals : (n,) array
        What the same estimator leaves of these rows: the filter's own error, but for what moves the
        estimate.
    bias : (p,) array
        What that moves the physical parameters by.
    again : (p,) array or None
        The same of the loops simulated with the estimate less that bias, whose rows the others then
        are; None where that was not tried, as the bias is small, or came to nothing.
    """

    regressor: Array
    residuals: Array
    bias: Array
    again: Array | None = None


def noise_free(
    form: Form,
    problem: Problem,
    loops: tuple[Simulation, ...],
    physical: Array,
    instruments: QrFactors | None,
) -> NoiseFree:
    """What filtering, differencing and decimation alone do to the rows and to the estimate.

    The loops simulated with the estimate are records without noise, delay or unknown friction;
    what the same filter and estimator make of them should be the estimate. Mostly it is rounding
    where friction reverses that moves it.

    Parameters
    ----------
    form : Form
        At its point, if it is linearised.
    problem : Problem
        What the estimate was made from.
    loops : tuple of Simulation
        Of the records' references, with `physical`; one for each segment.
    physical : (p,) array
    instruments : QrFactors or None
        Of the estimate; None for least squares.
    """
    rows, solution = _of_loops(form, problem, loops, instruments)
    return NoiseFree(
        regressor=rows.regressor,
        residuals=solution.residuals,
        bias=np.asarray(form.physical(solution.theta)[0] - physical, dtype=float),
    )


def encoder_error(
    form: Form,
    problem: Problem,
    loops: tuple[Simulation, ...],
    physical: Array,
    instruments: QrFactors | None,
    deviations: Array,
) -> StepsError | None:
    """What the steps of the records' encoders do to an estimate, deviations (k,) of its own.

    None where no record has any, or they are no matter. Parameters are as of `noise_free`.
    """
    records = [data.record for data in problem.data]
    steps = [encoder_step(problem.axis, record) for record in records]
    if not any(steps):
        return None

    def solved(share: float) -> Solution:
        stepped = tuple(
            loop
            for record, step in zip(records, steps, strict=True)
            for loop in stepped_loops(problem.axis, record, physical, step, share)
        )
        _, solution = _of_loops(form, problem, stepped, instruments)
        return replace(solution, neighbours=problem.neighbours)

    _, quiet = _of_loops(form, problem, loops, instruments)
    return steps_error(solved, quiet.theta, deviations)


def _of_loops(
    form: Form, problem: Problem, loops: tuple[Simulation, ...], instruments: QrFactors | None
) -> tuple[Equations, Solution]:
    """Rows of loops, one for each segment, behind the records' filter, and what solves them."""
    # Rows are those of the estimate, whose instruments they are held against.
    signals = [
        noise_free_record(data, of_one).signals
        for data, of_one in zip(problem.data, problem.by_record(loops), strict=True)
    ]
    rows = _rows(form, signals, problem)
    return rows, _solved(form, rows, instruments)


def slopes_by_gain(
    form: Form, problem: Problem, solution: Solution, instruments: QrFactors | None
) -> tuple[Array, Array]:
    """Slopes of the physical parameters, (p,), and of the regression's, (k,), by ln(gain).

    Without known terms every linear parameter is proportional to the gain; a known term keeps its
    size, so that the others take what it leaves. So does what the drive makes without its gain.
    """
    if isinstance(form, InverseForm):  # the force is on the left alone
        rows = problem.stacked(lambda data: data.reduce(data.force_by_gain))
        slope = solution.influence.T @ rows
        return slope, slope
    ahead, behind = (
        _solved(form, _rows(form, signals, problem), instruments).theta
        for signals in (
            [_with_gain(data, scale) for data in problem.data] for scale in (1 + _STEP, 1 - _STEP)
        )
    )
    physical = form.physical(ahead)[0] - form.physical(behind)[0]
    return physical / (2 * _STEP), (ahead - behind) / (2 * _STEP)


def noise_free_record(data: FilteredRecord, loops: Sequence[Simulation]) -> FilteredRecord:
    """The record as its simulated loops have it, under the same filter."""
    record = data.record
    simulated = replace(
        record,
        position=simulated_position(loops),
        control=None if record.control is None else np.concatenate([s.control for s in loops]),
        force=None
        if record.force is None
        else np.concatenate([_sensed(data, loop) for loop in loops]),
    )
    return replace(data, record=simulated)


def _sensed(data: FilteredRecord, loop: Simulation) -> Array:
    """What a force sensor sees at a sample, (N,): the mean of what is held before and after.

    With `zoh` the column is said to be what is held from the sample on.
    """
    law = data.axis.axis.control
    if law is None or law.continuous or data.prefilter.hold == "zoh":
        return loop.force
    return about_samples(loop.force, [0])


def _with_gain(data: FilteredRecord, scale: float) -> Signals:
    """The signals with another drive gain, on which a measured force does not depend."""
    signals = data.signals
    fixed = signals.force - data.force_by_gain
    return replace(signals, force=(signals.force - fixed) * scale + fixed)


def _rows(form: Form, signals: Sequence[Signals], problem: Problem) -> Equations:
    pieces = [
        form.equations(of_one).reduced(data)
        for of_one, data in zip(signals, problem.data, strict=True)
    ]
    return Equations.stacked(pieces)


def _solved(form: Form, rows: Equations, instruments: QrFactors | None) -> Solution:
    names = [q.label for q in form.quantities]
    left = rows.left - rows.known
    if instruments is None:
        return least_squares(left, factor(rows.regressor, names))
    return instrumental_variables(left, checked_columns(rows.regressor, names), instruments)
