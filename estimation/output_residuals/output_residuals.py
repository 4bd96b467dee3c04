"""Errors of simulated outputs, one column for each parameter set, and slopes by differences."""

from abc import ABC, abstractmethod
from collections import ChainMap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice, pairwise, starmap

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.law_replay import (
    LIMIT,
    LawInputs,
    LawReplay,
    law_memory,
    law_terms_along,
    state_at_rest,
    with_limit,
)
from axisid.estimation.records import Record
from axisid.estimation.regression import Form
from axisid.estimation.simulation import (
    BatchSimulation,
    LoopInputs,
    gains_by_lane,
    simulate_lanes,
)
from axisid.estimation.thresholds import LIMIT_TOLERANCE
from axisid.estimation.unknowns import axis_at, inputs_at, started_at
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError

#: Of a parameter's scale. The cost is smooth there: slopes agree to 0.06 % from 1e-3 to 1e-6.
STEP = 1e-4
# of a term of the law: by how much it is added and taken away for a slope
_ADDED_SHARE = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class BatchResiduals:
    """Simulated less recorded outputs.

    Attributes
    ----------
    errors : (n, B) array
        One column a lane; NaN where its simulation ended early.
    failures : mapping of int to str
        Why, by lane.
    """

    errors: Array
    failures: Mapping[int, str]


@dataclass(slots=True, kw_only=True)
class Piece:
    """Rows that are predicted together.

    Attributes
    ----------
    record : int
        Of the records, from 0; pieces of one stand behind those of the one before.
    spans : tuple of int
        Rows of each stretch without a gap.
    samples : (N,) array of int
    measured, counted : (n,) array
        As of `OutputResiduals`.
    """

    record: int
    spans: tuple[int, ...]
    samples: NDArray[np.intp]
    measured: Array
    counted: Array


@dataclass(slots=True, kw_only=True)
class Stretch(Piece):
    """A segment of a record, and what its loop is simulated from.

    Attributes
    ----------
    axis : GeneratedAxis
    segment : int
        Of the record, from 0.
    inputs : LoopInputs
    outputs : tuple of str
        What is followed, as `Simulation` names it; of several the rows of a sample are neighbours.
    substeps : int or None
        Of a sample, once they are settled.
    """

    axis: GeneratedAxis
    segment: int
    inputs: LoopInputs
    outputs: tuple[str, ...]
    substeps: int | None = None

    def simulated(
        self,
        theta: Array,
        inputs: LoopInputs,
        wanted: Sequence[str],
        gains: Mapping[str, Array] | None = None,
    ) -> BatchSimulation:
        """Its loop with parameters (B, p)."""
        return simulate_lanes(
            self.axis,
            theta,
            replace(inputs, gains=gains_by_lane(self.axis, gains, len(theta))),
            substeps=self.substeps,
            wanted=wanted,
        )

    def rows(
        self, theta: Array, inputs: LoopInputs, gains: Mapping[str, Array] | None = None
    ) -> tuple[Array, Mapping[int, str]]:
        """The outputs of its loop with parameters (B, p), (n, B), and why lanes failed."""
        batch = self.simulated(theta, inputs, self.outputs, gains)
        return interleaved([batch[name] for name in self.outputs]), batch.failures


def interleaved(columns: Sequence[Array]) -> Array:
    """Values (N, ...) of each output as rows, those of a sample neighbours, (n, ...)."""
    return np.stack(columns, axis=1).reshape(-1, *columns[0].shape[1:])


class OutputResiduals(ABC):
    """An output as parameters simulate it less the recorded one, at the samples of all records.

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
    stretches : sequence of Stretch
        Segments whose loops are simulated; none of windows.
    """

    units: tuple[str, ...]
    step: float = 0.0
    horizon: float | None = None
    stretches: Sequence[Stretch] = ()

    def __init__(self, form: Form, records: Sequence[Record], pieces: Sequence[Piece]) -> None:
        self._form, self._records = form, tuple(records)
        self._slope_by_time: Array | None = None
        self._time = self._time_step = 0.0
        self._later: OutputResiduals | None = None
        self.measured = np.concatenate([each.measured for each in pieces])
        self.counted = np.concatenate([each.counted for each in pieces])
        every = [[each for each in pieces if each.record == i] for i in range(len(records))]
        self.samples = tuple(np.concatenate([p.samples for p in each]) for each in every)
        ends = np.cumsum([0, *(size for each in pieces for size in each.spans)]).tolist()
        stretches = starmap(slice, pairwise(ends))
        counts = (sum(len(p.spans) for p in each) for each in every)
        self.spans = tuple(tuple(islice(stretches, count)) for count in counts)

    @abstractmethod
    def _errors(self, physical: Array) -> Iterator[tuple[Array, Mapping[int, str]]]:
        """Errors of the rows of each piece with parameters (B, P), and why lanes failed."""

    @abstractmethod
    def settle(self, physical: Array) -> None:
        """Settle at parameters (P,) what is to be the same for all lanes about them.

        Raises
        ------
        EstimationError
            They cannot be simulated.
        """

    def _forget_steps(self) -> None:
        """Let the steps of a sample be settled anew."""
        for each in self.stretches:
            each.substeps = None

    @abstractmethod
    def outputs_of(self, records: Sequence[Record], physical: Array) -> Array:
        """Rows that the errors of other records of the same samples would have less of, (n,).

        Of each how far its output is from what parameters (P,) predict of it, from where it starts.

        Raises
        ------
        EstimationError
            It cannot be simulated.
        """

    def __call__(self, physical: Array) -> BatchResiduals:
        """Errors of parameters (B, P)."""
        pieces, failed = zip(*self._errors(physical), strict=True)
        errors = pieces[0] if len(pieces) == 1 else np.concatenate(pieces)
        failures = dict(ChainMap(*map(dict, failed)))
        errors[:, [*failures]] = np.nan
        if self._slope_by_time is not None:
            errors += np.outer(self._slope_by_time, physical[:, -1] - self._time)
        return BatchResiduals(errors=errors, failures=failures)

    def _at(self, stretch: Stretch, physical: Array) -> tuple[Stretch, Array]:
        """A stretch under the law, and from the start, that parameters (P,) make; its own, (p,)."""
        axis, inputs = axis_at(stretch.axis, self._form, physical), stretch.inputs
        if axis is not stretch.axis:
            inputs = inputs_at(axis, self._records[stretch.record], stretch.segment, inputs)
        inputs = started_at(self._form, physical, stretch.record, stretch.segment, inputs)
        return replace(stretch, axis=axis, inputs=inputs), self._form.own(physical, stretch.record)

    def jacobian_by_law(self, physical: Array) -> Mapping[str, Array]:
        """Slopes of the errors by a factor of each term of the law, (n,), by its gains.

        None is given without a law that has terms of its own, or where a loop cannot be simulated.
        """
        slopes = [jacobian_by_law(*self._at(each, physical)) for each in self.stretches]
        names = dict.fromkeys(name for each in slopes for name in each) if all(slopes) else ()
        pairs = [*zip(slopes, (np.zeros(len(s.counted)) for s in self.stretches), strict=True)]
        return {
            name: np.concatenate([each.get(name, none) for each, none in pairs])
            for name in names
            if name == LIMIT or all(name in each for each in slopes)  # not each loop reaches it
        }

    def velocities(self, physical: Array) -> tuple[Array, ...]:
        """Of the loops of parameters (P,) at the samples of each record.

        None where there are no loops, or where one cannot be simulated.
        """
        velocities: list[list[Array]] = [[] for _ in self.samples]
        for each in self.stretches:
            at, theta = self._at(each, physical)
            if at.inputs.clocks is not None:
                return ()
            if (loop := at.simulated(theta[None, :], at.inputs, ["velocity"])).failures:
                return ()
            velocities[each.record].append(loop["velocity"][:, 0])
        return tuple(map(np.concatenate, filter(None, velocities)))

    def follow_time(
        self, later: "OutputResiduals", physical: Array, time: float, step: float
    ) -> None:
        """Let the last parameter be a time of the drive, for which the loops were generated.

        A loop is generated for one lag and one delay. About these its output is a straight line of
        either; where a search ends, the loop is generated anew, until it is there.

        Parameters
        ----------
        later : OutputResiduals
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
        self._later, self._time, self._time_step = later, time, step
        self.begin(physical)

    def begin(self, physical: Array) -> None:
        """Begin a search at parameters (P,): forget what an earlier one settled elsewhere.

        The steps of a sample are settled anew, and the slope by the drive's time is taken there.

        Raises
        ------
        EstimationError
            As of `follow_time`.
        """
        self._forget_steps()
        if self._later is None:
            return
        self._later._forget_steps()
        self._slope_by_time = None
        for each in (self, self._later):
            each.settle(physical)
        here, there = (each(physical[None, :]).errors[:, 0] for each in (self, self._later))
        slope = (there - here) / self._time_step
        if not np.all(np.isfinite(slope)):
            raise EstimationError(
                "the loop cannot be simulated about the drive's time, which is to be found.",
                code="simulation",
            )
        self._slope_by_time = slope


def jacobian_by_law(stretch: Stretch, theta: Array) -> Mapping[str, Array]:
    """Slopes of a stretch's outputs, (n,), by a factor of each product of gains, or of each gain.

    Of gains where the law is no sum of products of them, as what it is off by is told then. And by
    a factor of the drive's limit, where the loop reaches it.

    Parameters
    ----------
    stretch : Stretch
    theta : (p,) array
        Parameters of its axis.

    Returns
    -------
    mapping of str to (n,) array
        Empty of a continuous law, and where a loop cannot be simulated.
    """
    law, inputs = stretch.axis.control, stretch.inputs
    if law is None or law.continuous:
        return {}
    wanted = ("position", "velocity", "control")
    if (loop := stretch.simulated(theta[None, :], replace(inputs, clocks=None), wanted)).failures:
        return {}
    position, velocity, control = (loop[name][:, 0] for name in wanted)
    ticks = LawInputs.at_samples(inputs.reference, position, velocity, inputs.signals)
    # The loop's memory has the drive's behind the law's, whose terms do not depend on it.
    memory, count = inputs.start.memory, law_memory(stretch.axis)
    start = state_at_rest(stretch.axis, ticks) if memory is None else np.asarray(memory)[:count]
    if law.is_polynomial:
        names = [str(gains) for gains, _ in law.terms]
        terms = law_terms_along(stretch.axis, ticks, start)
    else:
        names = [*law.gains]
        terms = LawReplay.of_loop(stretch.axis, ticks, start).jacobian_by_gain()
    # They are those that are applied; what is injected is applied as late as they are.
    terms = np.vstack([terms[law.delay :], np.repeat(terms[-1:], law.delay, axis=0)])
    lanes = _ADDED_SHARE * np.hstack([terms, -terms])
    if inputs.injected is not None:
        lanes += inputs.injected[:, None]
    out, failures = stretch.rows(
        np.tile(theta, (lanes.shape[1], 1)), replace(inputs, injected=lanes)
    )
    if failures:
        return {}
    more, less = np.split(out, 2, axis=1)
    slopes = (more - less) / (2 * _ADDED_SHARE)
    axis, limit = stretch.axis, stretch.axis.drive.limit
    if np.any(np.abs(control) >= (1 - LIMIT_TOLERANCE.value) * limit):
        wider = with_limit(axis, (1 + _ADDED_SHARE) * limit, native=axis.native.enabled)
        other = replace(stretch, axis=wider)
        (here, _), (there, failures) = (s.rows(theta[None, :], inputs) for s in (stretch, other))
        if failures:
            return {}
        names, slopes = [*names, LIMIT], np.hstack([slopes, (there - here) / _ADDED_SHARE])
    return dict(zip(names, (stretch.counted[:, None] * slopes).T, strict=True))


def record_rows(spans: Sequence[slice], place: int = 0, outputs: int = 1) -> slice:
    """Rows of a record by its stretches: all, or those of the output at a place of so many."""
    return slice(spans[0].start + place, spans[-1].stop, outputs)


_ROOM = 2.001  # steps in the range between the bounds
_SHORTER = (1, 1 / 8, 1 / 64)  # of the step, where lanes fail


def jacobian_at(
    predictions: OutputResiduals,
    physical: Array,
    scale: Array,
    lower: Array,
    upper: Array,
    free: NDArray[np.bool_] | None = None,
) -> tuple[Array, Array]:
    """Errors (n,) at parameters (P,), and their slopes by these, (n, P); of what is held 0.

    By second-order differences, central where the bounds leave room. Where no loop can be simulated
    on one side, as friction below 0 drives an axis, both steps are to the other.

    Parameters
    ----------
    predictions : OutputResiduals
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
    pending = {j: _steps(steps[j], physical[j] - lower[j], upper[j] - physical[j]) for j in chosen}
    jacobian, why = np.zeros((len(predictions.measured), len(physical))), ""
    while True:
        pairs = np.array([next(some, (np.nan, np.nan)) for some in pending.values()]).reshape(-1, 2)
        if np.isnan(pairs).any():
            raise EstimationError(why, code="simulation")
        moves = np.zeros((1 + pairs.size, len(physical)))
        moves[np.arange(1, len(moves)), np.repeat([*pending], 2)] = pairs.ravel()
        lanes = predictions(physical + moves)
        if 0 in lanes.failures:
            raise EstimationError(lanes.failures[0], code="simulation")
        here, first, second = lanes.errors[:, :1], lanes.errors[:, 1::2], lanes.errors[:, 2::2]
        a, b = pairs.T
        # At 0 of the parabolas through the values at 0, a and b.
        slopes = (first * b * b - second * a * a) / (a * b * (b - a)) - here * (a + b) / (a * b)
        lost = {(lane - 1) // 2: why for lane, why in lanes.failures.items()}
        why = next(iter(lost.values()), "")
        for k, j in enumerate([*pending]):
            if k not in lost:
                jacobian[:, j] = slopes[:, k]
                del pending[j]
        if not pending:
            return here[:, 0], jacobian


def _steps(step: float, below: float, above: float) -> Iterator[tuple[float, float]]:
    """Two steps of a parameter with so much room: about it, or to one side, then shorter ones."""
    for share in _SHORTER:
        h = share * step
        for pair in ((-h, h), (h, 2 * h), (-2 * h, -h)):
            if -below <= pair[0] and pair[1] <= above:
                yield pair
