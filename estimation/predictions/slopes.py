"""Slopes of predictions by differences, all lanes in one batch, within the parameters' bounds."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.support.arrays import Array
from axisid.support.errors import EstimationError

from .lanes import LANE_LOST, Lanes, Predictions

#: Of a parameter's scale. The cost is smooth there: slopes agree to 0.06 % from 1e-3 to 1e-6.
STEP = 1e-4
_ROOM = 2.001  # steps in the range between the bounds
_SHORTER, _TRIES = 1 / 8, 3  # of the step, where a lane fails


@dataclass(frozen=True, slots=True, kw_only=True)
class Slopes:
    """Errors at parameters, and how they change.

    Attributes
    ----------
    errors : (n,) array
    jacobian : (n, P) array
        Columns of parameters that are held are 0.
    """

    errors: Array
    jacobian: Array


def slopes_of(
    predictions: Predictions,
    physical: Array,
    scale: Array,
    lower: Array,
    upper: Array,
    free: NDArray[np.bool_] | None = None,
) -> Slopes:
    """Second-order differences about parameters (P,), central where their bounds leave room.

    Where no loop can be simulated on one side, as friction below 0 drives an axis, both steps are
    to the other.

    Parameters
    ----------
    predictions : Predictions
    physical : (P,) array
    scale : (P,) array
        Of each parameter: the step is `STEP` of it.
    lower, upper : (P,) array
    free : (P,) array of bool, optional
        Which parameters; all by default.

    Raises
    ------
    EstimationError
        A loop cannot be simulated there, or nowhere near for one of the parameters.
    """
    chosen = range(len(physical)) if free is None else map(int, np.flatnonzero(free))
    steps = np.minimum(STEP * scale, (upper - lower) / _ROOM)
    jacobian: Array | None = None
    errors, sides = np.empty(0), np.zeros(len(physical), dtype=int)
    pending, failed = list(chosen), Lanes(errors=np.empty((0, 0)), failures={})
    for _ in range(_TRIES):
        offsets = np.array([_offsets(j, physical, steps, lower, upper, sides) for j in pending])
        lanes = _lanes(physical, pending, offsets)
        found = predictions(lanes)
        if 0 in found.failures:
            raise EstimationError(found.failures[0], code=LANE_LOST)
        if jacobian is None:
            errors = found.errors[:, 0]
            jacobian = np.zeros((len(errors), len(physical)))
        lost = []
        for k, j in enumerate(pending):
            pair = 1 + 2 * k, 2 + 2 * k
            below, above = (lane in found.failures for lane in pair)
            if below or above:
                lost.append(j)
                if below != above and offsets[k].sum() == 0:
                    sides[j] = 1 if below else -1
                else:
                    steps[j] *= _SHORTER
                continue
            first, second = (found.errors[:, lane] for lane in pair)
            jacobian[:, j] = _slope(errors, first, second, *offsets[k])
        pending, failed = lost, found
        if not pending:
            return Slopes(errors=errors, jacobian=jacobian)
    raise EstimationError(next(iter(failed.failures.values())), code=LANE_LOST)


def _offsets(
    j: int,
    physical: Array,
    steps: Array,
    lower: Array,
    upper: Array,
    sides: NDArray[np.int_],
) -> tuple[float, float]:
    """Where a parameter's two lanes are, from where it is: about it, or both on one side."""
    h, below, above = steps[j], physical[j] - lower[j], upper[j] - physical[j]
    if below < h or (sides[j] > 0 and above >= 2 * h):
        return h, 2 * h
    if above < h or (sides[j] < 0 and below >= 2 * h):
        return -h, -2 * h
    return -h, h


def _lanes(physical: Array, chosen: list[int], offsets: Array) -> Array:
    lanes = np.tile(physical, (1 + 2 * len(chosen), 1))
    for k, j in enumerate(chosen):
        lanes[1 + 2 * k : 3 + 2 * k, j] += offsets[k]
    return lanes


def _slope(here: Array, first: Array, second: Array, a: float, b: float) -> Array:
    """Slope at 0 of the parabola through values at 0, a and b."""
    slope = (first * b * b - second * a * a) / (a * b * (b - a))
    return slope if a == -b else slope - here * (a + b) / (a * b)
