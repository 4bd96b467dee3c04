"""What noise that a loop answers to moves an output error by.

The loop that an output error simulates has no noise. Of a linear axis that is the mean of all loops
with noise; of one with friction it is not: noise that the law makes force of shakes the axis, and
friction that is shaken is another. How much is told by the same loops with the record's noise in
another order, whose force is estimated as the record's was: the simulation step of Cook and
Stefanski's SIMEX, each draw once with either sign, so that what is odd in the noise cancels.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from axisid.estimation.records import Record, in_own_order
from axisid.estimation.regression import (
    STEP_SHARES,
    Equations,
    Form,
    SensorSteps,
    Solution,
    hidden_scatter,
    sensor_steps,
    simulated_loops,
    stepped_loops,
)
from axisid.estimation.signals import FilteredRecord
from axisid.estimation.simulation import Simulation
from axisid.estimation.thresholds.estimates import SETTLED_FILTER_BIAS
from axisid.support.arrays import Array

from .filter_bias import NoiseFree, loop_record
from .following_bias import followed_as_measured, white_noise
from .problem import Problem
from .solver import Solver

_DRAWS, _OF_A_DRAW = 4, 2


def with_loop_noise(
    quiet: NoiseFree,
    form: Form,
    problem: Problem,
    physical: Array,
    solver: Solver,
    deviations: Array | None = None,
    loops: tuple[Simulation, ...] = (),
) -> NoiseFree:
    """What filter and noise in the loop together move an output error by, for what the filter does.

    The same where no position has more noise than the steps of its encoder, which are told of by
    themselves, or where the first draw shows that it is no matter.

    Parameters
    ----------
    quiet : NoiseFree
        Of the loops without noise, at the same parameters.
    form : Form
        At its point, if it is linearised.
    problem : Problem
    physical : (p,) array
    solver : callable
        Of the estimate.
    deviations : (p,) array, optional
        Of the estimate, by which the first draw is judged; none is by default.
    loops : tuple of Simulation, optional
        Simulated with the parameters, without noise.

    Raises
    ------
    ModelError, DataError, EstimationError
        A loop cannot be simulated with noise.
    """
    found: list[Solution] = []
    moved: list[Array] = []
    for rows in _noisy(form, problem, physical, loops):
        found.append(replace(solver(form, rows), neighbours=problem.neighbours))
        moved.append(form.physical(found[-1].theta)[0] - physical)
        if len(moved) == _OF_A_DRAW and deviations is not None:
            apart = np.abs(np.mean(moved, axis=0) - quiet.bias)
            if np.all(apart <= SETTLED_FILTER_BIAS.value * deviations):
                return quiet
    if not found:
        return quiet
    weights = 1.0 if problem.row_weights is None else problem.row_weights
    left = np.array([solution.residuals for solution in found]) / weights
    return replace(
        quiet,
        bias=np.mean(moved, axis=0),
        has_noise=True,
        hidden=hidden_scatter(found),
        halves=left.reshape(2, -1, left.shape[1]).mean(axis=1),
    )


def rows_as_measured(form: Form, problem: Problem, physical: Array) -> Iterator[Equations]:
    """Rows of the records' loops as they would be measured: with their noise, or their steps.

    Raises
    ------
    ModelError, DataError, EstimationError
        A loop cannot be simulated so.
    """
    first = problem.data[0]
    if len(problem.data) == 1 and first.record.reference is None:
        for record in followed_as_measured(first, form.own(physical, 0)):
            yield problem.reduced(form, [record.signals])
        return
    yield from _noisy(form, problem, physical)
    steps = [sensor_steps(data.axis, data.record) for data in problem.data]
    for share in STEP_SHARES if any(steps) else ():
        signals = [
            _with_steps(data, form.own(physical, i), step, share).signals
            for i, (data, step) in enumerate(zip(problem.data, steps, strict=True))
        ]
        yield problem.reduced(form, signals)


def record_as_measured(data: FilteredRecord, physical: Array) -> Iterator[FilteredRecord]:
    """A record as its loops would be measured: with its noise in another order, or its steps.

    Raises
    ------
    ModelError, DataError, EstimationError
        A loop cannot be simulated so.
    """
    if data.record.reference is None:
        yield from followed_as_measured(data, physical)
        return
    noise = _noise(data, simulated_loops(data.axis, data.record, physical))
    for (drawn,) in _drawn([noise], [data.record]) if noise.any() else ():
        yield _with_noise(data, physical, drawn)
    steps = sensor_steps(data.axis, data.record)
    for share in STEP_SHARES if steps else ():
        yield _with_steps(data, physical, steps, share)


def _noisy(
    form: Form, problem: Problem, physical: Array, loops: tuple[Simulation, ...] = ()
) -> Iterator[Equations]:
    """Rows of loops with the records' noise, draw by draw; none where they have no noise."""
    quiet = problem.by_record(loops or problem.loops(form, physical))
    white = [_noise(data, of_one) for data, of_one in zip(problem.data, quiet, strict=True)]
    if not any(noise.any() for noise in white):
        return
    for drawn in _drawn(white, [data.record for data in problem.data]):
        signals = [
            _with_noise(data, form.own(physical, i), noise).signals
            for i, (data, noise) in enumerate(zip(problem.data, drawn, strict=True))
        ]
        yield problem.reduced(form, signals)


def _drawn(white: Sequence[Array], records: Sequence[Record]) -> Iterator[list[Array]]:
    """The noise of each record in other orders, and of either sign."""
    rng, places = np.random.default_rng(0), in_own_order(records)
    for _ in range(_DRAWS):
        drawn = {place: rng.permutation(white[place]) for place in places}
        order = [drawn[place] for place in range(len(white))]
        yield order
        yield [-noise for noise in order]


def _noise(data: FilteredRecord, loops: tuple[Simulation, ...]) -> Array:
    """White noise of a record's position, (N,); zero where it is no more than an encoder's step."""
    noise = white_noise(data.record, loops, "position")
    steps = sensor_steps(data.axis, data.record)
    return noise if np.std(noise) > steps.position else np.zeros_like(noise)


def _with_noise(data: FilteredRecord, physical: Array, noise: Array) -> FilteredRecord:
    """What the record would be had its loop that noise."""
    loops = simulated_loops(data.axis, data.record, physical, position_noise=noise)
    return loop_record(data, loops, measured=True)


def _with_steps(
    data: FilteredRecord, physical: Array, steps: SensorSteps, share: float
) -> FilteredRecord:
    """What it would be with sensors of such steps, `share` of one away from whole ones."""
    loops = stepped_loops(data.axis, data.record, physical, steps, share)
    return loop_record(data, loops, measured=False)
