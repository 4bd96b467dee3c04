"""Which cut-off of a sweep to take, and why; or why none can be named.

With instruments that agree with least squares noise does no harm, and the most precise cut-off is
taken. Without them nothing tells where noise begins to bias, but what a cut-off does shows in its
neighbours: what rounding or noise moves at one, it moves otherwise at the next. An estimate's error
is then taken to be its deviation, the bias that is known of it (of the filter, and of noise where
loops follow the record) and the step to its neighbours together; cut-offs at which half of the
record predicts the motion of the other half worse than elsewhere are left out.

An equation's error on rows that are held out says nothing between cut-offs, each of which filters
what it is held against: noise that biases the parameters makes the rows no harder to explain. The
position is the same for all. So the parameters of each half move the axis under the recorded
control, in windows that each start where the record is, through the other half. What is known of
the bias of filter and noise is taken off them.
"""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.checks import Check
from axisid.estimation.diagnostics import tests_of_instruments
from axisid.estimation.estimates import Estimate, Value, hausman, significant_differences
from axisid.estimation.identification import Identification
from axisid.estimation.predictions import WindowPredictions
from axisid.estimation.problems import Problem
from axisid.estimation.thresholds import (
    MAX_RELATIVE_DEVIATION,
    MIN_FIRST_STAGE_F,
    MIN_ROWS_PER_PARAMETER,
    MIN_SWEPT_CUTOFFS,
)
from axisid.support.arrays import Array
from axisid.support.errors import DataError, EstimationError, ModelError
from axisid.support.missing import Missing

from .held_out import contiguous_blocks, regression_rows

_MAX_FILTER_BIAS = 1.0  # deviations, by filter and noise
# of a known parameter's value, to the neighbouring cut-off; beyond, none is recommended without
# instruments
_MAX_SWEEP_STEP = 0.1
# of a sweep's least error of the position in the half that was held out: measured, right twins
# lose no better cut-off by it; beside white noise of the position one is left out that is biased
# eight times as much (`benchmarks/sweeps.py`)
_MAX_HELD_OUT_MOTION = 2.0

_HORIZON = 0.5  # s, of a window
_HALVES = 2
_LEAST = 1e-8  # relative error: one parameter that is about exact must not decide for all
_STEADY = (
    "where deviations, the bias that is known and the steps to the neighbouring cut-offs are "
    "smallest together"
)


def recommend(results: Sequence[Identification]) -> tuple[float | None, str]:
    """A cut-off, Hz, and why that one; None where none can be named.

    Parameters
    ----------
    results : sequence of Identification
        By cut-off, ascending.
    """
    agreeing = [result for result in results if _agrees(result)]
    steps = (
        (
            [result for result in agreeing if _is_unbiased(result["idm-iv"])],
            "where the deviations are smallest among the cut-offs at which least squares and "
            "instruments agree and the bias of filter and noise is below a deviation",
        ),
        (
            agreeing,
            "where the deviations are smallest among the cut-offs at which least squares and "
            "instruments agree; the bias of filter and noise exceeds a deviation at all of them",
        ),
        (
            [result for result in results if _is_strong(result.estimates.get("idm-iv"))],
            "where the deviations of the instruments and its bias are smallest; "
            "noise biases least squares at every cut-off, so believe the instruments",
        ),
    )
    for able, why in steps:
        if able:
            best = min(able, key=lambda result: _vagueness(_errors(result["idm-iv"])))
            return best.prefilter.cutoff, why
    return _steadiest(results)


def checks_of(recommended: Identification | None, reason: str) -> tuple[Check, ...]:
    """The checks of what is recommended; without any, why there is none."""
    none = Check.unless("recommendation", reason)
    return (none,) if recommended is None else recommended.checks


def _steadiest(results: Sequence[Identification]) -> tuple[float | None, str]:
    """Without instruments: the cut-off beside which least squares hardly moves."""
    why = "there are no instruments to compare with"
    if any("idm-iv" in result.estimates for result in results):
        why = "the instruments are weak"
    told = [(result, _of_least_squares(result)) for result in results]
    judged = [(result, estimate) for result, estimate in told if estimate is not None]
    if len(judged) < MIN_SWEPT_CUTOFFS.value:
        return None, (
            f"none: {why}, and {len(judged)} cut-off{'s' * (len(judged) != 1)} cannot show where "
            f"noise or rounding begins; give {MIN_SWEPT_CUTOFFS.value:g} or more"
        )
    steps = _steps([estimate for _, estimate in judged])
    worst = [
        _vagueness(np.hypot(_errors(estimate), step / np.abs(_centre(estimate))))
        for (_, estimate), step in zip(judged, steps, strict=True)
    ]
    motion = np.array(held_out_motion(judged))
    strays = motion > _MAX_HELD_OUT_MOTION * np.min(motion)
    chosen = int(np.argmin(np.where(strays, np.inf, worst)))
    result, estimate = judged[chosen]
    cutoff = result.prefilter.cutoff
    if moving := _moving(estimate, steps[chosen]):
        said = ", ".join(f"{name} by {100 * share:.2g} %" for name, share in moving.items())
        return None, (
            f"none: {why}, and least squares stands still nowhere; even at {cutoff:g} Hz, where it "
            f"moves least, a neighbouring cut-off moves {said}. Record the reference, or take a "
            "finer encoder"
        )
    at_end = chosen in (0, len(judged) - 1)
    held_out = _predicted(motion[chosen], strays, result)
    return cutoff, f"{_STEADY}{held_out}, since {why}" + _ENDS * at_end


def _predicted(error: float, strays: NDArray[np.bool_], result: Identification) -> str:
    """What was found of motion that was held out; nothing where it could not be told."""
    if not math.isfinite(error):
        return ""
    out = f"; {strays.sum()} of {len(strays)} cut-offs are left out, where it is twice the least"
    return (
        f" (each half of the record predicts the other's position to {error:.2g} "
        f"{result.axis.axis.coordinate.unit}{out * bool(strays.any())})"
    )


_ENDS = "; it is at the end of the range, so sweep further"


def _of_least_squares(result: Identification) -> Estimate | None:
    """The estimate that is judged without instruments, if its rows are enough."""
    estimate = result.estimates.get("idm-ls") or result.preferred
    enough = len(estimate.y) >= MIN_ROWS_PER_PARAMETER.value * len(estimate.theta)
    return estimate if enough else None


def _steps(estimates: Sequence[Estimate]) -> list[Array]:
    """Of each estimate, how far its neighbours are from it, (p,), the farther one."""
    apart = [np.abs(_centre(second) - _centre(first)) for first, second in pairwise(estimates)]
    return [
        np.maximum(before, after)
        for before, after in zip([apart[0], *apart], [*apart, apart[-1]], strict=True)
    ]


def _centre(estimate: Estimate) -> Array:
    """Parameters as their intervals are centred, (p,)."""
    return np.array([value.corrected for value in estimate.parameters.values()])


def _moving(estimate: Estimate, step: Array) -> dict[str, float]:
    """Parameters that are known and that a neighbouring cut-off makes others, by what share."""
    return {
        name: float(moved / abs(value.corrected))
        for (name, value), moved in zip(estimate.parameters.items(), step, strict=True)
        if value.relative_deviation_percent < MAX_RELATIVE_DEVIATION.value
        and moved > _MAX_SWEEP_STEP * abs(value.corrected)
    }


def _agrees(result: Identification) -> bool:
    ls, iv = result.estimates.get("idm-ls"), result.estimates.get("idm-iv")
    if ls is None or iv is None or not _is_strong(iv):
        return False
    found = hausman(ls, iv)
    return not (isinstance(found, Missing) or significant_differences(found, result.levels.level))


def _is_strong(iv: Estimate | None) -> bool:
    """Whether there are instruments that tell something, and rows enough."""
    tests = tests_of_instruments(iv)
    return (
        iv is not None
        and not isinstance(tests, Missing)
        and len(iv.y) >= MIN_ROWS_PER_PARAMETER.value * len(iv.theta)
        and tests.weakest >= MIN_FIRST_STAGE_F.value
    )


def _is_unbiased(iv: Estimate) -> bool:
    """Whether the prefilter moves no parameter by more than its deviation."""
    shifts = [value.shift for value in iv.parameters.values()]
    return iv.filter_bias is not None and max(shifts) <= _MAX_FILTER_BIAS


def _errors(estimate: Estimate) -> Array:
    """Deviation and known bias of each parameter, by its size, (p,)."""
    return np.array([_relative(value) for value in estimate.parameters.values()])


def _relative(value: Value) -> float:
    error = math.hypot(value.deviation, value.filter_bias or 0.0)
    return error / abs(value.value) if value.value else math.inf


def _vagueness(errors: Array) -> float:
    """Geometric mean of relative errors (p,): one parameter about zero must not decide for all."""
    return float(np.mean(np.log(np.maximum(errors, _LEAST))))


def held_out_motion(results: Sequence[tuple[Identification, Estimate]]) -> list[float]:
    """Errors of the position of each half, in the coordinate's unit, root mean square.

    Parameters
    ----------
    results : sequence of (Identification, Estimate)
        Of the same records.

    Returns
    -------
    list of float
        Infinite where an axis does not get through a window, NaN where it cannot be told: there is
        no control or no position, or too few rows.
    """
    (first, estimate), *_ = results
    data = first.problem.data
    try:
        predictions = WindowPredictions(
            estimate.form, [d.axis for d in data], [d.record for d in data], _HORIZON
        )
    except (DataError, EstimationError, ModelError):
        return [math.nan] * len(results)
    return [_error(predictions, result.problem, each) for result, each in results]


def _error(predictions: WindowPredictions, problem: Problem, estimate: Estimate) -> float:
    gap = max(data.sampling.filter.memory for data in problem.data)
    rows, squares = regression_rows(estimate), []
    known = np.array([value.value - value.corrected for value in estimate.parameters.values()])
    try:
        halves = contiguous_blocks(len(rows.left), gap, len(estimate.theta), count=_HALVES)
        for half in halves:
            theta = rows.at(half.training).by_least_squares().theta
            physical = estimate.form.physical(theta)[0] - known
            predictions.settle(physical)
            errors = predictions(physical[None]).errors[:, 0]
            squares.append(errors[_within(predictions, problem, half.held_out)] ** 2)
    except DataError:
        return math.nan
    except (EstimationError, ModelError):
        return math.inf
    found = float(np.sqrt(np.mean(np.concatenate(squares))))
    return found if math.isfinite(found) else math.inf


def _within(
    predictions: WindowPredictions, problem: Problem, rows: NDArray[np.intp]
) -> NDArray[np.bool_]:
    """Which predicted samples are measurements and lie where the rows do."""
    found, counted = [], predictions.counted > 0
    for data, span, samples in zip(problem.data, problem.spans, predictions.samples, strict=True):
        own = rows[(rows >= span.start) & (rows < span.stop)] - span.start
        ends = data.row_numbers[own[[0, -1]]] if own.size else (0, -1)
        found.append((samples >= ends[0]) & (samples <= ends[1]))
    return np.concatenate(found) & counted
