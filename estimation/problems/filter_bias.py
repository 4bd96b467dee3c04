"""How the prefilter biases an estimate, and how it depends on the drive gain.

Both keep the instruments: only what was measured is changed.
"""

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from scipy.special import stdtrit

from axisid.estimation.regression import (
    Covariance,
    Equations,
    Form,
    InverseForm,
    Solution,
    StepsError,
    factor,
    instrumental_variables,
    least_squares,
    sensor_steps,
    stepped_loops,
    steps_error,
)
from axisid.estimation.signals import FilteredRecord, Signals, about_samples
from axisid.estimation.simulation import Simulation, logged_control
from axisid.estimation.thresholds.estimates import (
    MAX_FILTER_HOP,
    MAX_SIMULATION_ERROR,
    MIN_FILTER_SHARE,
    MIN_PRINTED_FILTER_BIAS,
    SETTLED_FILTER_BIAS,
)
from axisid.estimation.thresholds.regression import SIGNIFICANCE_LEVEL
from axisid.support.arrays import Array, relative_error_percent
from axisid.support.errors import AxisidError, DataError, EstimationError

from .problem import Problem
from .solver import Solver

_STEP = 1e-4  # of the gain
_MOST = 6  # corrections, each from where the last one led


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseFree:
    """Rows of the loops that were simulated with an estimate, behind the same filter.

    Attributes
    ----------
    regressor : (n, k) array
    theta : (k,) array
        What the same estimator makes of these rows.
    residuals : (n,) array
        What the same estimator leaves of these rows: the filter's own error, but for what moves the
        estimate.
    bias : (p,) array
        What that moves the physical parameters by.
    doubt : str
        Why the record does not owe this to the filter, so that nothing is corrected by it; empty
        where it does.
    settled : bool
        Whether it was found again at the corrected parameters, where it stands still.
    has_noise : bool
        Whether the bias is that of the position's noise too.
    hidden : (k, k) array or None
        Covariance of what that noise makes the regression's own parameters scatter by beside what
        neighbouring rows show; None without noise.
    halves : (2, n) array or None
        What the estimator leaves of the loops with noise, the mean over half of the draws and over
        the others; None without noise.
    """

    regressor: Array
    theta: Array
    residuals: Array
    bias: Array
    doubt: str = ""
    settled: bool = False
    has_noise: bool = False
    hidden: Array | None = None
    halves: Array | None = None

    @property
    def is_in_record(self) -> bool:
        """Whether what the filter leaves of the noise-free loop is in the record too."""
        return not self.doubt and bool(np.any(self.residuals))


#: What is found at parameters: nothing where the loop does not follow, or why there is none.
Answer: TypeAlias = NoiseFree | DataError | EstimationError | None
#: Asks for rows at parameters (p,), is answered, and returns where that leads.
Settling: TypeAlias = Generator[Array, Answer, NoiseFree]


def noise_free(
    form: Form,
    problem: Problem,
    loops: tuple[Simulation, ...],
    physical: Array,
    solver: Solver,
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
    solver : callable
        Of the estimate.
    """
    rows, solution = _of_loops(form, problem, loops, solver)
    return _noise_free(form, problem, rows, solution, physical)


def _noise_free(
    form: Form, problem: Problem, rows: Equations, solution: Solution, physical: Array
) -> NoiseFree:
    weights = problem.row_weights
    by_row = 1.0 if weights is None else weights
    return NoiseFree(
        regressor=(rows.regressor.T / by_row).T,
        theta=solution.theta,
        residuals=solution.residuals / by_row,
        bias=np.asarray(form.physical(solution.theta)[0] - physical, dtype=float),
    )


def encoder_error(
    form: Form,
    problem: Problem,
    quiet: NoiseFree,
    physical: Array,
    solver: Solver,
    deviations: Array,
) -> StepsError | None:
    """What the steps of the records' encoders do to an estimate, deviations (k,) of its own.

    None where no record has any, or they are no matter. `quiet` is of the loops without steps, at
    the same parameters; the others are as of `noise_free`.
    """
    steps = [sensor_steps(data.axis, data.record) for data in problem.data]
    if not any(steps):
        return None

    def solved(share: float) -> Solution:
        stepped = tuple(
            loop
            for i, (data, step) in enumerate(zip(problem.data, steps, strict=True))
            for loop in stepped_loops(data.axis, data.record, form.own(physical, i), step, share)
        )
        _, solution = _of_loops(form, problem, stepped, solver)
        return replace(solution, neighbours=problem.neighbours)

    return steps_error(solved, quiet.theta, deviations)


def _of_loops(
    form: Form, problem: Problem, loops: tuple[Simulation, ...], solver: Solver
) -> tuple[Equations, Solution]:
    """Rows of loops, one for each segment, behind the records' filter, and what solves them."""
    # Rows are those of the estimate, whose instruments they are held against.
    signals = [
        noise_free_record(data, of_one).signals
        for data, of_one in zip(problem.data, problem.by_record(loops), strict=True)
    ]
    rows = problem.reduced(form, signals)
    return rows, solver(form, rows)


def settled_noise_free(
    first: NoiseFree,
    found_at: Callable[[Array], NoiseFree | None],
    physical: Array,
    deviations: Array,
) -> NoiseFree:
    """The rows of the loop whose estimate, behind the filter, is the one that was found.

    See `settling`.

    Parameters
    ----------
    first : NoiseFree
        Of the loops that were simulated with the estimate itself.
    found_at : callable
        The same of loops that are simulated with other parameters (p,); None where they do not
        follow.
    physical, deviations : (p,) arrays
        The estimate and its deviations.
    """

    def answer(asked: dict[int, Array]) -> dict[int, Answer]:
        try:
            return {0: found_at(asked[0])}
        except (DataError, EstimationError) as error:
            return {0: error}

    return settled_together({0: settling(first, physical, deviations)}, answer)[0]


def settling(first: NoiseFree, physical: Array, deviations: Array) -> Settling:
    """Ask for rows of loops at other parameters until their bias stands still; returns the last.

    The bias depends on where it is looked for: friction that an estimate has too low turns
    otherwise than the axis did. It is found again at the corrected parameters, until it stands
    still, or hops about one value as a reversal falls on one side of a sample or the other; a bias
    that grows instead corrects nothing.

    Parameters
    ----------
    first, physical, deviations
        As of `settled_noise_free`.
    """
    size = _in_deviations(first.bias, deviations)
    if size <= MIN_PRINTED_FILTER_BIAS.value:
        return first
    found = before = first
    for _ in range(_MOST):
        again = yield physical - found.bias
        if again is None:
            return replace(first, doubt="without it the simulated loop does not follow the record")
        if isinstance(again, AxisidError):
            return replace(first, doubt="the loop cannot be simulated without it")
        moved = _in_deviations(again.bias - found.bias, deviations)
        if not moved < size:
            hops = found is not first and moved <= MAX_FILTER_HOP.value
            return _between(found, again) if hops else _unsettled(first)
        found, before, size = again, found, moved
        if moved <= SETTLED_FILTER_BIAS.value:
            return replace(found, settled=True)
    return _between(before, found) if size <= MAX_FILTER_HOP.value else _unsettled(first)


def settled_together(
    talks: Mapping[int, Settling], found_at: Callable[[dict[int, Array]], Mapping[int, Answer]]
) -> dict[int, NoiseFree]:
    """What several come to, by number, each asking for what it needs.

    Parameters
    ----------
    talks : mapping of int to Settling
    found_at : callable
        Answers all that is asked at a time.
    """
    ended: dict[int, NoiseFree] = {}
    answers: Mapping[int, Answer] = dict.fromkeys(talks)  # as a generator begins
    while answers:
        asked: dict[int, Array] = {}
        for number, answer in answers.items():
            try:
                asked[number] = talks[number].send(answer)
            except StopIteration as end:
                ended[number] = end.value
        answers = found_at(asked) if asked else {}
    return ended


def _between(one: NoiseFree, other: NoiseFree) -> NoiseFree:
    """The second of two, whose bias hops: that in the middle."""
    return replace(other, bias=np.asarray((one.bias + other.bias) / 2, dtype=float), settled=True)


def _unsettled(first: NoiseFree) -> NoiseFree:
    return replace(first, doubt="it does not settle where it is taken off")


def share_in_residuals(
    quiet: NoiseFree, solution: Solution, covariance: Covariance
) -> tuple[float, float]:
    """How much of the filter's own residuals a record's have, and the most that they may.

    Where a record is as its noise-free loop is, but for noise that is none of the filter's, all of
    them: the share is about 1. Noise that moves the reversals within the filter leaves less. Of
    loops with noise, half of the draws are the instrument of the others, whose noise is another.

    Returns
    -------
    share, most : float
        The most that the level of the test allows.
    """
    own, *others = [quiet.residuals] if quiet.halves is None else quiet.halves
    if not np.any(own):
        return 1.0, 1.0
    columns = factor(own[:, None], ["share"], neighbours=solution.neighbours)
    found = least_squares(solution.residuals, columns)
    for other in others:
        drawn = factor(other[:, None], ["share"])
        found = instrumental_variables(solution.residuals, columns, drawn)
    share = float(found.theta[0])
    applied = covariance.applied(found)
    deviation = float(np.sqrt(applied.matrix[0, 0]))
    reach = float(stdtrit(applied.freedom[0], 1 - SIGNIFICANCE_LEVEL.value))
    return share, share + reach * deviation


def is_not_in(quiet: NoiseFree, solution: Solution, covariance: Covariance) -> bool:
    """Whether a record's residuals speak for noise that moves its reversals, if only by chance."""
    if quiet.doubt:
        return True
    share, _ = share_in_residuals(quiet, solution, covariance)
    return share < MIN_FILTER_SHARE.value


def confirmed(quiet: NoiseFree, solution: Solution, covariance: Covariance) -> NoiseFree:
    """The same, in doubt where the record's own residuals have no such error."""
    if quiet.doubt:
        return quiet
    share, most = share_in_residuals(quiet, solution, covariance)
    # Of loops with noise all of it is the record's: what moved the reversals is in them.
    if most >= (MIN_FILTER_SHARE.value if quiet.halves is None else 1.0):
        return quiet
    said = (
        f"the record's residuals have {100 * max(share, 0.0):.0f} % of the error that it comes of"
    )
    return replace(quiet, doubt=said, settled=False)


def _in_deviations(change: Array, deviations: Array) -> float:
    """Largest change of a parameter; deviations of nothing tell nothing."""
    there = deviations > 0
    return float(np.max(np.abs(change[there]) / deviations[there], initial=0.0))


def noise_free_at(
    form: Form, problem: Problem, physical: Array, *, solver: Solver
) -> NoiseFree | None:
    """`noise_free` at other parameters than the estimate; None where the loop does not follow."""
    at = form.at(physical)
    rows, solution = _of_loops(at, problem, problem.loops(at, physical), solver)
    left = problem.rows(at).left
    if relative_error_percent(left - rows.left, left) >= MAX_SIMULATION_ERROR.value:
        return None
    return _noise_free(at, problem, rows, solution, physical)


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
    """The record as its simulated loops have it, under the same filter."""
    return loop_record(data, loops, measured=False)


def loop_record(
    data: FilteredRecord, loops: Sequence[Simulation], *, measured: bool
) -> FilteredRecord:
    """The same, with the position as the loops' law measured it or as it is.

    A column that was recorded is made of the loops as its sensor would see them.
    """
    record = data.record
    jumps = data.axis.axis.jumps
    sensed = jumps and data.prefilter.hold != "zoh"  # else it is what is held from the sample on
    made: dict[str, Callable[[Simulation], Array]] = {
        "position": lambda s: s.measured_position if measured else s.position,
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
