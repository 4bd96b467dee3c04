"""Predictions side by side, one column for each parameter set, and their slopes by differences."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.records import Record
from axisid.estimation.regression import Form
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError


@dataclass(frozen=True, slots=True, kw_only=True)
class Lanes:
    """Predicted less recorded outputs.

    Attributes
    ----------
    errors : (n, B) array
        One column a lane; NaN where its simulation ended early.
    failures : mapping of int to str
        Why, by lane.
    """

    errors: Array
    failures: Mapping[int, str]


class Predictions(ABC):
    """An output as parameters predict it, at the samples of all records.

    Attributes
    ----------
    spans : tuple of tuple of slice
        Rows of each stretch without a gap, by record.
    samples : tuple of array of int
        Which sample of its record each row is, or each of several outputs' rows, by record.
    units : tuple of str
        Of each output; the rows of a sample are neighbours, one of each.
    step : float
        Of the coarsest encoder; 0 where nothing is known of any.
    measured : (n,) array
        What was recorded.
    counted : (n,) array
        1 for rows that count, 0 for those that are no measurements.
    horizon : float or None
        Length of windows that each start anew, s; None of loops.
    """

    spans: tuple[tuple[slice, ...], ...]
    samples: tuple[NDArray[np.intp], ...]
    units: tuple[str, ...]
    step: float = 0.0
    measured: Array
    counted: Array
    horizon: float | None = None
    _pieces: int  # that are simulated one after the other

    def __init__(self, form: Form, records: Sequence[Record]) -> None:
        self._form, self._records = form, tuple(records)
        self._slope_by_time: Array | None = None
        self._time = 0.0

    @abstractmethod
    def _piece(self, place: int, physical: Array) -> tuple[Array, Mapping[int, str]]:
        """Errors of the rows of a piece with parameters (B, P), and why lanes failed."""

    @abstractmethod
    def settle(self, physical: Array) -> None:
        """Settle at parameters (P,) what is to be the same for all lanes about them.

        Raises
        ------
        EstimationError
            They cannot be simulated.
        """

    @abstractmethod
    def outputs_of(self, records: Sequence[Record], physical: Array) -> Array:
        """Rows that the errors of other records of the same samples would have less of, (n,).

        Of each the output, or how far it is from a prediction by parameters (P,) that follows it.
        """

    def __call__(self, physical: Array) -> Lanes:
        """Errors of parameters (B, P)."""
        pieces, failures = [], dict[int, str]()
        for place in range(self._pieces):
            values, failed = self._piece(place, physical)
            pieces.append(values)
            failures = {**failed, **failures}
        errors = pieces[0] if len(pieces) == 1 else np.concatenate(pieces)
        errors[:, [*failures]] = np.nan
        if self._slope_by_time is not None:
            errors += np.outer(self._slope_by_time, physical[:, -1] - self._time)
        return Lanes(errors=errors, failures=failures)

    def slopes_by_start(
        self,
        physical: Array,  # noqa: ARG002
    ) -> tuple[tuple[slice, Array], ...]:
        """Rows of each stretch that begins in motion, and slopes of its errors there, (n, 2).

        By its first position and velocity, which are those of the record; none where they are
        parameters, or are taken out of the errors.
        """
        return ()

    def slopes_by_law(self, physical: Array) -> Mapping[str, Array]:  # noqa: ARG002
        """Slopes of the errors by a factor of each term of the law, (n,), by its gains.

        None is given without a law that has terms of its own, or where a loop cannot be simulated.
        """
        return {}

    def velocities(self, physical: Array) -> tuple[Array, ...]:  # noqa: ARG002
        """Of the loops of parameters (P,) at the samples of each record.

        None where there are no loops, or where one cannot be simulated.
        """
        return ()

    def follow_time(self, later: "Predictions", physical: Array, time: float, step: float) -> None:
        """Let the last parameter be a time of the drive, for which the loops were generated.

        A loop is generated for one lag and one delay. About these its output is a straight line of
        either; where a search ends, the loop is generated anew, until it is there.

        Parameters
        ----------
        later : Predictions
            The same, of drives whose time is longer by a step.
        physical : (P,) array
            Where the slope by the time is taken.
        time, step : float
            s

        Raises
        ------
        EstimationError
            Not both can be simulated there.
        """
        found = []
        for each in (self, later):
            each.settle(physical)
            found.append(each(physical[None, :]))
        slope = (found[1].errors[:, 0] - found[0].errors[:, 0]) / step
        if not np.all(np.isfinite(slope)):
            raise EstimationError(
                "the loop cannot be simulated about the drive's time, which is to be found.",
                code="simulation",
            )
        self._slope_by_time, self._time = slope, time


def record_rows(spans: Sequence[slice], place: int = 0, outputs: int = 1) -> slice:
    """Rows of a record by its stretches: all, or those of the output at a place of so many."""
    return slice(spans[0].start + place, spans[-1].stop, outputs)


#: Of a parameter's scale. The cost is smooth there: slopes agree to 0.06 % from 1e-3 to 1e-6.
STEP = 1e-4
_ROOM = 2.001  # steps in the range between the bounds
_SHORTER, _TRIES = 1 / 8, 3  # of the step, where a lane fails


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorsAndJacobian:
    """Errors at parameters, and how they change.

    Attributes
    ----------
    errors : (n,) array
    jacobian : (n, P) array
        Columns of parameters that are held are 0.
    """

    errors: Array
    jacobian: Array


def jacobian_at(
    predictions: Predictions,
    physical: Array,
    scale: Array,
    lower: Array,
    upper: Array,
    free: NDArray[np.bool_] | None = None,
) -> ErrorsAndJacobian:
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
        lanes = np.tile(physical, (1 + 2 * len(pending), 1))
        for k, j in enumerate(pending):
            lanes[1 + 2 * k : 3 + 2 * k, j] += offsets[k]
        found = predictions(lanes)
        if 0 in found.failures:
            raise EstimationError(found.failures[0], code="simulation")
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
            return ErrorsAndJacobian(errors=errors, jacobian=jacobian)
    raise EstimationError(next(iter(failed.failures.values())), code="simulation")


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


def _slope(here: Array, first: Array, second: Array, a: float, b: float) -> Array:
    """Slope at 0 of the parabola through values at 0, a and b."""
    slope = (first * b * b - second * a * a) / (a * b * (b - a))
    return slope if a == -b else slope - here * (a + b) / (a * b)
