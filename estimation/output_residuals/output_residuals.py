"""Residuals of simulated outputs, one column per parameter set, and derivatives by differences."""

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

#: Step of differences relative to a parameter's scale. Derivatives agree to 0.06 % for steps from
#: 1e-3 to 1e-6.
STEP = 1e-4
# step of the factor of a law's term for a central difference
_ADDED_SHARE = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class BatchResiduals:
    """Simulated minus recorded outputs of several parameter sets, each of which is a lane.

    Attributes
    ----------
    errors : (n, B) array
        One column for each lane; NaN for a simulation that ended early.
    failures : mapping of int to str
        Reason of a failure, by lane.
    """

    errors: Array
    failures: Mapping[int, str]


@dataclass(slots=True, kw_only=True)
class Piece:
    """Recorded outputs that are simulated together: of a segment, or of the windows of a segment.

    Attributes
    ----------
    record : int
        Number of the record, from 0; pieces are in the order of the records.
    spans : tuple of int
        Number of rows of each stretch without a gap, which is the segment or a window.
    samples : (N,) array of int
        Sample numbers in the record.
    measured : (n,) array
        Recorded outputs.
    counted : (n,) array
        1 for rows that are used, 0 for rows that are no measurements.
    """

    record: int
    spans: tuple[int, ...]
    samples: NDArray[np.intp]
    measured: Array
    counted: Array


@dataclass(slots=True, kw_only=True)
class Stretch(Piece):
    """A segment of a record, with the inputs of its simulated loop.

    Attributes
    ----------
    axis : GeneratedAxis
    segment : int
        Number of the segment in the record, from 0.
    inputs : LoopInputs
    outputs : tuple of str
        Fitted outputs, by their names in `Simulation`; rows of several outputs alternate.
    substeps : int or None
        Steps per sample; None before they are chosen.
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
        """Return the simulated loops of the segment, one lane for each parameter set (B, p).

        Parameters
        ----------
        theta : (B, p) array
            Parameters of the segment's axis.
        inputs : LoopInputs
        wanted : sequence of str
            Names of the signals, as in `Simulation`.
        gains : mapping of str to (B,) array, optional
            Gains of the law; the declared ones by default.
        """
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
        """Return the simulated outputs as alternating rows, (n, B), and failures by lane.

        The arguments are those of `simulated`.
        """
        batch = self.simulated(theta, inputs, self.outputs, gains)
        return interleaved([batch[name] for name in self.outputs]), batch.failures


def interleaved(columns: Sequence[Array]) -> Array:
    """Return values (N, ...) of each output as alternating rows, (n, ...)."""
    return np.stack(columns, axis=1).reshape(-1, *columns[0].shape[1:])


class OutputResiduals(ABC):
    """Residuals of outputs as a function of the parameters: simulated minus recorded, all records.

    The rows are those of all records in their order; rows of several outputs alternate.

    Parameters
    ----------
    form : Form
        Map of the parameters of the fit, (P,), to those of each record's axis, (p,).
    records : sequence of Record
    pieces : sequence of Piece
        Recorded outputs, in the order of the records.

    Attributes
    ----------
    spans : tuple of tuple of slice
        Rows of each stretch without a gap, by record.
    samples : tuple of array of int
        Sample numbers in each record; one number for the rows of several outputs.
    units : tuple of str
        Unit of each output; the rows of the outputs of a sample alternate.
    step : float
        Step of the coarsest encoder; 0 without a known encoder.
    measured : (n,) array
        Recorded outputs.
    counted : (n,) array
        1 for rows that are used, 0 for rows that are no measurements.
    horizon : float or None
        Length of the windows of multiple shooting, s; None for simulated loops.
    stretches : sequence of Stretch
        Segments whose loops are simulated; empty for windows.
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
        # The pieces of each record, their samples, and the rows of their stretches.
        by_record = [[each for each in pieces if each.record == i] for i in range(len(records))]
        self.samples = tuple(np.concatenate([p.samples for p in each]) for each in by_record)
        ends = np.cumsum([0, *(size for each in pieces for size in each.spans)]).tolist()
        stretches = starmap(slice, pairwise(ends))
        counts = (sum(len(p.spans) for p in each) for each in by_record)
        self.spans = tuple(tuple(islice(stretches, count)) for count in counts)

    @abstractmethod
    def _errors(self, physical: Array) -> Iterator[tuple[Array, Mapping[int, str]]]:
        """Yield the residuals of each piece for parameters (B, P), (n, B), and failures by lane."""

    @abstractmethod
    def settle(self, physical: Array) -> None:
        """Choose the settings of simulations with parameters near the given parameters, (P,).

        Settings are the steps per sample, and the initial states of windows.

        Raises
        ------
        EstimationError
            The parameters cannot be simulated.
        """

    def _forget_steps(self) -> None:
        """Forget the chosen steps per sample of the stretches, unless a subclass has others."""
        for each in self.stretches:
            each.substeps = None

    @abstractmethod
    def outputs_of(self, records: Sequence[Record], physical: Array) -> Array:
        """Return recorded minus simulated outputs of other records of the same samples, (n,).

        The outputs are simulated with parameters (P,) from the initial states of those records.

        Raises
        ------
        EstimationError
            A record cannot be simulated.
        """

    def __call__(self, physical: Array) -> BatchResiduals:
        """Return the residuals of all records for B sets of parameters, (B, P).

        After `follow_time`, the residuals are linear in the last parameter, a time of the drive.
        """
        pieces, failed = zip(*self._errors(physical), strict=True)
        errors = pieces[0] if len(pieces) == 1 else np.concatenate(pieces)
        failures = dict(ChainMap(*map(dict, failed)))
        errors[:, [*failures]] = np.nan
        if self._slope_by_time is not None:
            errors += np.outer(self._slope_by_time, physical[:, -1] - self._time)
        return BatchResiduals(errors=errors, failures=failures)

    def _at(self, stretch: Stretch, physical: Array) -> tuple[Stretch, Array]:
        """Return a stretch at parameters of the fit (P,), and the parameters of its axis (p,).

        Gains of the law and initial states that are parameters of the fit have the given values.
        """
        axis, inputs = axis_at(stretch.axis, self._form, physical), stretch.inputs
        if axis is not stretch.axis:
            inputs = inputs_at(axis, self._records[stretch.record], stretch.segment, inputs)
        inputs = started_at(self._form, physical, stretch.record, stretch.segment, inputs)
        return replace(stretch, axis=axis, inputs=inputs), self._form.own(physical, stretch.record)

    def jacobian_by_law(self, physical: Array) -> Mapping[str, Array]:
        """Return the derivative of the residuals by the factor of each law term, (n,) by name.

        The parameters are (P,). Empty without a sampled law, or if a loop cannot be simulated.
        """
        slopes = [jacobian_by_law(*self._at(each, physical)) for each in self.stretches]
        names = dict.fromkeys(name for each in slopes for name in each) if all(slopes) else ()
        pairs = [*zip(slopes, (np.zeros(len(s.counted)) for s in self.stretches), strict=True)]
        return {
            name: np.concatenate([each.get(name, none) for each, none in pairs])
            for name in names
            if name == LIMIT or all(name in each for each in slopes)  # some loops may not reach it
        }

    def velocities(self, physical: Array) -> tuple[Array, ...]:
        """Return the simulated velocities with parameters (P,) at the samples of each record.

        Empty without loops, if a loop cannot be simulated, or if law and log have different
        periods.
        """
        velocities: list[list[Array]] = [[] for _ in self.samples]
        for each in self.stretches:
            at, theta = self._at(each, physical)
            if at.inputs.clocks is not None:
                return ()
            loop = at.simulated(theta[None, :], at.inputs, ["velocity"])
            if loop.failures:
                return ()
            velocities[each.record].append(loop["velocity"][:, 0])
        return tuple(np.concatenate(of_record) for of_record in velocities if of_record)

    def follow_time(
        self, later: "OutputResiduals", physical: Array, time: float, step: float
    ) -> None:
        """Let the residuals depend linearly on a time of the drive, which is the last parameter.

        A loop is generated for one lag and one delay, and the output is linearised about them. At
        the end of a search the caller generates the loop again for the estimated time, until the
        time no longer changes.

        Parameters
        ----------
        later : OutputResiduals
            Residuals for drives whose time is longer by `step`.
        physical : (P,) array
            Parameters at which the derivative by the time is taken.
        time, step : float
            Time of the drive of these residuals, and the difference of the time of `later`, s.

        Raises
        ------
        EstimationError
            The loops with one of the two times cannot be simulated at these parameters.
        """
        self._later, self._time, self._time_step = later, time, step
        self.begin(physical)

    def begin(self, physical: Array) -> None:
        """Prepare for a search from parameters (P,), without settings of earlier searches.

        The steps per sample are chosen again, and so is the derivative by the drive's time after
        `follow_time`.

        Raises
        ------
        EstimationError
            As in `follow_time`.
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
                "the loop cannot be simulated near the start value of the drive's lag or delay, "
                "which is free. Declare another value, or leave the lag or delay out of the free "
                "parameters.",
                code="simulation",
            )
        self._slope_by_time = slope


def jacobian_by_law(stretch: Stretch, theta: Array) -> Mapping[str, Array]:
    """Return the derivatives of a stretch's outputs, (n,), by a factor of each law term, by name.

    The terms are products of gains, or the gains themselves if the law is no sum of such products;
    and the drive's limit, if the loop reaches the limit. The derivatives are differences of
    simulated loops: a larger factor of a term acts like a part of the term that is added to the
    control.

    Parameters
    ----------
    stretch : Stretch
    theta : (p,) array
        Parameters of the stretch's axis.

    Returns
    -------
    mapping of str to (n,) array
        Empty for a continuous law, or if a loop cannot be simulated.
    """
    law, inputs = stretch.axis.control, stretch.inputs
    if law is None or law.continuous:
        return {}
    wanted = ("position", "velocity", "control")
    loop = stretch.simulated(theta[None, :], replace(inputs, clocks=None), wanted)
    if loop.failures:
        return {}
    position, velocity, control = (loop[name][:, 0] for name in wanted)
    # Terms of the law along the simulated loop, in the drive's unit.
    ticks = LawInputs.at_samples(inputs.reference, position, velocity, inputs.signals)
    # The memory of a loop is that of the law, then that of the drive, on which no term depends.
    memory, count = inputs.start.memory, law_memory(stretch.axis)
    start = state_at_rest(stretch.axis, ticks) if memory is None else np.asarray(memory)[:count]
    if law.is_polynomial:
        names = [str(gains) for gains, _ in law.terms]
        terms = law_terms_along(stretch.axis, ticks, start)
    else:
        names = [*law.gains]
        terms = LawReplay.of_loop(stretch.axis, ticks, start).jacobian_by_gain()
    # An injected signal has the delay of the law, so that the terms are those at their action.
    terms = np.vstack([terms[law.delay :], np.repeat(terms[-1:], law.delay, axis=0)])
    # Loops with a part of each term added to the control, and subtracted from it.
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
    # The drive's limit, if the loop reaches it.
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
    """Return the slice of a record's rows, of all outputs or of one output.

    Parameters
    ----------
    spans : sequence of slice
        Rows of the record's stretches.
    place, outputs : int
        Index of the output, and number of outputs; by default the rows of all outputs.
    """
    return slice(spans[0].start + place, spans[-1].stop, outputs)


_ROOM = 2.001  # number of steps that must fit between the bounds of a parameter
_SHORTER = (1, 1 / 8, 1 / 64)  # shorter steps that are tried if loops cannot be simulated


def jacobian_at(
    predictions: OutputResiduals,
    physical: Array,
    scale: Array,
    lower: Array,
    upper: Array,
    free: NDArray[np.bool_] | None = None,
) -> tuple[Array, Array]:
    """Return the residuals (n,) at parameters (P,), and their Jacobian (n, P); 0 for fixed ones.

    The derivatives are second-order differences, central if the bounds allow. If no loop can be
    simulated on one side of a parameter, as with friction below 0, both steps are to the other
    side; then shorter steps are tried. All loops of one try run in parallel lanes.

    Parameters
    ----------
    predictions : OutputResiduals
    physical : (P,) array
    scale : (P,) array
        Scale of each parameter; the step is `STEP` times the scale.
    lower, upper : (P,) array
        Bounds of the parameters, which no step exceeds.
    free : (P,) array of bool, optional
        True for free parameters; all by default.

    Raises
    ------
    EstimationError
        A loop cannot be simulated at the parameters, or with no step of one of the parameters.
    """
    chosen = range(len(physical)) if free is None else map(int, np.flatnonzero(free))
    steps = np.minimum(STEP * scale, (upper - lower) / _ROOM)
    # For each parameter whose derivative is pending: the pairs of steps that are still to be tried.
    pending = {j: _steps(steps[j], physical[j] - lower[j], upper[j] - physical[j]) for j in chosen}
    jacobian, why = np.zeros((len(predictions.measured), len(physical))), ""
    while True:
        # One lane at the parameters, then two lanes for the next pair of each pending parameter.
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
        # Derivatives at 0 of the parabolas through the values at 0, a and b.
        slopes = (first * b * b - second * a * a) / (a * b * (b - a)) - here * (a + b) / (a * b)
        # Parameters of failed lanes stay pending, with their next pair of steps.
        failed = {(lane - 1) // 2: reason for lane, reason in lanes.failures.items()}
        why = next(iter(failed.values()), "")
        for k, j in enumerate([*pending]):
            if k not in failed:
                jacobian[:, j] = slopes[:, k]
                del pending[j]
        if not pending:
            return here[:, 0], jacobian


def _steps(step: float, below: float, above: float) -> Iterator[tuple[float, float]]:
    """Yield pairs of steps for a difference: central, forward, backward, then the same but shorter.

    The steps stay within the distances `below` and `above` to the bounds.
    """
    for share in _SHORTER:
        h = share * step
        for pair in ((-h, h), (h, 2 * h), (-2 * h, -h)):
            if -below <= pair[0] and pair[1] <= above:
                yield pair
