"""How the prefilter biases an estimate, and how it depends on the drive gain.

Both keep the instruments: only what was measured is changed.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from axisid.estimation.regression import (
    Equations,
    FollowingLoops,
    Form,
    InverseForm,
    QrFactors,
    Solution,
    checked_columns,
    factor,
    instrumental_variables,
    least_squares,
    simulated_right,
)
from axisid.estimation.signals import FilteredRecord, Signals, about_samples
from axisid.estimation.simulation import Simulation
from axisid.estimation.thresholds.estimates import MAX_SIMULATION_ERROR
from axisid.support.arrays import Array, relative_error_percent

from .problem import Problem

_STEP = 1e-4  # of the gain
_DRAWS = 4  # of noise, each once with either sign: what is odd in the noise cancels


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
    has_noise : bool
        Whether the bias is that of the position's noise too.
    """

    regressor: Array
    residuals: Array
    bias: Array
    has_noise: bool = False


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
    # Rows are those of the estimate, whose instruments they are held against.
    signals = [
        noise_free_record(data, of_one).signals
        for data, of_one in zip(problem.data, problem.by_record(loops), strict=True)
    ]
    rows = _rows(form, signals, problem)
    solution = _solved(form, rows, instruments)
    return NoiseFree(
        regressor=rows.regressor,
        residuals=solution.residuals,
        bias=np.asarray(form.physical(solution.theta)[0] - physical, dtype=float),
    )


def noise_free_following(
    form: Form, problem: Problem, left: Array, physical: Array
) -> NoiseFree | None:
    """The same of least squares of records without a reference, by loops that follow them.

    What the records' position is beside that of the loops is its noise. Noise in the regressor, and
    in a control that answers to it, biases least squares. How much is told by least squares of the
    same loops with that noise in another order: the simulation step of Cook and Stefanski's SIMEX.

    Parameters
    ----------
    form : Form
        At its point, if it is linearised.
    problem : Problem
        Of records without a reference.
    left : (n,) array
        Left side of the measured rows.
    physical : (p,) array

    Returns
    -------
    NoiseFree or None
        None if the loops do not follow the records.

    Raises
    ------
    ModelError, DataError, EstimationError
        The loops are not known, or cannot be simulated.
    """
    following = [FollowingLoops.of(data) for data in problem.data]
    every = [each.simulated(physical) for each in following]
    if not _follow(form, problem, every, left, physical):
        return None
    quiet = noise_free(form, problem, tuple(s for of_one in every for s in of_one), physical, None)
    rng = np.random.default_rng(0)
    white = [_noise(each, loops) for each, loops in zip(following, every, strict=True)]
    biases = []
    for _ in range(_DRAWS):
        drawn = [rng.permutation(noise) for noise in white]
        biases += [_bias_with_noise(form, following, drawn, s, physical) for s in (1.0, -1.0)]
    return replace(quiet, bias=np.mean(biases, axis=0), has_noise=True)


def _noise(following: FollowingLoops, loops: tuple[Simulation, ...]) -> Array:
    """Noise of a record's position, (N,), as large as its second differences.

    Its slow part is the loops': they follow it, or do not quite move as the axis did.
    """
    apart = following.data.record.position - np.concatenate([s.position for s in loops])
    apart = apart - apart.mean()
    size, white = np.std(apart), np.std(np.diff(apart, 2)) / 6**0.5
    return np.asarray(apart * min(1.0, white / size) if size else apart)


def _follow(
    form: Form,
    problem: Problem,
    every: Sequence[tuple[Simulation, ...]],
    left: Array,
    physical: Array,
) -> bool:
    rights = [
        simulated_right(form, loops, physical, data)
        for loops, data in zip(every, problem.data, strict=True)
    ]
    theta = form.regressed(physical)
    made = np.concatenate([known + right @ theta for known, right in rights])
    return relative_error_percent(left - made, left) < MAX_SIMULATION_ERROR.value


def _bias_with_noise(
    form: Form,
    following: Sequence[FollowingLoops],
    noise: Sequence[Array],
    sign: float,
    physical: Array,
) -> Array:
    """What least squares makes of the loops with noise of the position."""
    pieces = []
    for each, of_one in zip(following, noise, strict=True):
        loops = each.simulated(physical, sign * of_one)
        noisy = loop_record(each.data, loops, measured=True)
        if noisy.prefilter.reversals == "leave-out":  # they are those of what is measured
            noisy = noisy.turning_as(noisy.record.position)
        pieces.append(form.equations(noisy.signals).reduced(noisy))
    solution = _solved(form, Equations.stacked(pieces), None)
    return np.asarray(form.physical(solution.theta)[0] - physical, dtype=float)


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
    return loop_record(data, loops, measured=False)


def loop_record(
    data: FilteredRecord, loops: Sequence[Simulation], *, measured: bool
) -> FilteredRecord:
    """The same, with the position as the loops' law measured it or as it is."""
    record = data.record
    position = [s.measured_position if measured else s.position for s in loops]
    simulated = replace(
        record,
        position=np.concatenate(position),
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
