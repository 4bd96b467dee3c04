"""Outputs of the simulated loop of each record, for many parameter sets in one batch.

Several outputs are of one simulation, and the rows of a sample are neighbours: control, position,
control, position, and so on.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.generated_axes import GeneratedAxis, build
from axisid.estimation.choices import CONTROL, FORCE
from axisid.estimation.law_replay import (
    MIN_MEMORY_EFFECT,
    START_SAMPLES,
    LawInputs,
    as_read_by_law,
    cached_per_record,
    first_memory,
    law_memory,
    law_residual,
    law_terms_along,
    law_ticks,
    loop_starts,
    recorded_inputs,
    slopes_along,
    state_at_rest,
)
from axisid.estimation.parameters import (
    axis_at,
    gains_in,
    inputs_at,
    least_sizes,
    start_sizes,
    started_at,
)
from axisid.estimation.records import Record
from axisid.estimation.regression import Form, autoregression_of, loop_reference, sensor_steps
from axisid.estimation.simulation import (
    BatchSimulation,
    LoopInputs,
    gains_by_lane,
    most_substeps,
    settled_substeps,
    simulate_lanes,
)
from axisid.support.arrays import Array, mask_of
from axisid.support.errors import DataError, EstimationError

from .lanes import STEP, Piece, PredictionErrors

# of a term of the law: by how much it is added and taken away for a slope
_ADDED_SHARE = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredOutput:
    """An output as a record has it.

    Attributes
    ----------
    signal : str
        What it is of a simulation, as `Simulation` names it.
    unit : str
    values : (N,) array
    """

    signal: str
    unit: str
    values: Array


def measured_output(output: str, axis: GeneratedAxis, record: Record) -> MeasuredOutput:
    """The recorded output that a fit follows.

    Parameters
    ----------
    output : str
        Of `axisid.estimation.choices.OUTPUTS`.
    axis : GeneratedAxis
    record : Record

    Raises
    ------
    DataError
        The record has no such column.
    """
    q, drive = axis.axis.coordinate, axis.axis.drive
    name, unit, values = {
        CONTROL: (CONTROL, drive.unit, record.control),
        FORCE: (FORCE, q.force_unit, record.force),
    }.get(output, ("position", q.unit, None if record.integrated else record.position))
    if values is None:
        raise DataError(
            f"{record.provenance.source} has no {name} column, which the fit is to follow; "
            f"name it with columns {name}=NAME, or choose another output.",
            code="missing-column",
        )
    return MeasuredOutput(signal=name, unit=str(unit), values=np.asarray(values))


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
    first = columns[0]
    return first if len(columns) == 1 else np.stack(columns, axis=1).reshape(-1, *first.shape[1:])


class LoopPredictions(PredictionErrors):
    """The simulated loops of the records.

    Parameters
    ----------
    form : Form
        Says which parameters of its axis each record has.
    axes : sequence of GeneratedAxis
        By record. Their drives are simulated without rounding, see `unrounded`.
    records : sequence of Record
    outputs : str or sequence of str
        Of `axisid.estimation.choices.OUTPUTS`.

    Raises
    ------
    ModelError, DataError
        An axis has no control law, or a record no reference or no such output.
    """

    def __init__(
        self,
        form: Form,
        axes: Sequence[GeneratedAxis],
        records: Sequence[Record],
        outputs: str | Sequence[str],
    ) -> None:
        names = (outputs,) if isinstance(outputs, str) else outputs
        self.stretches: list[Stretch] = []
        for number, (axis, record) in enumerate(zip(axes, records, strict=True)):
            measured = [measured_output(name, axis, record) for name in names]
            smooth = unrounded(axis, native=axis.native.enabled)
            self.stretches += _stretches(number, smooth, record, measured)
            self.units = tuple(each.unit for each in measured)
            self.step = max(self.step, sensor_steps(axis, record)[0])
        super().__init__(form, records, self.stretches)

    def outputs_of(
        self,
        records: Sequence[Record],
        physical: Array,  # noqa: ARG002
    ) -> Array:
        """See `PredictionErrors.outputs_of`."""
        return np.concatenate(
            [
                interleaved([getattr(each, name)[first:last] for name in self.stretches[0].outputs])
                for each in records
                for first, last in each.spans
            ]
        )

    def settle(self, physical: Array) -> None:
        """See `PredictionErrors.settle`: how many steps a sample is simulated in.

        Raises
        ------
        EstimationError
            Friction that remembers is so stiff there that samples take the most steps there are:
            such loops are not resolved, and a search would take hours.
        """
        for each in self.stretches:
            theta = self._form.own(physical, each.record)
            steps = settled_substeps(each.axis, theta, each.inputs) or 1
            if each.axis.states and steps >= most_substeps(len(each.inputs.reference)):
                raise EstimationError(
                    f"with {each.axis.describe(theta)} the friction of axis "
                    f"{each.axis.axis.name!r} is so stiff that a sample takes {steps} "
                    "steps, the most there are; start from nominal values of the right order, or "
                    "bound the stiffness.",
                    code="simulation",
                )
            each.substeps = max(steps, each.substeps or 1)

    def _at(self, stretch: Stretch, physical: Array) -> tuple[Stretch, Array]:
        """A stretch under the law, and from the start, that parameters (P,) make; its own, (p,)."""
        axis, inputs = axis_at(stretch.axis, self._form, physical), stretch.inputs
        if axis is not stretch.axis:
            inputs = inputs_at(axis, self._records[stretch.record], stretch.segment, inputs)
        inputs = started_at(self._form, physical, stretch.record, stretch.segment, inputs)
        theta = self._form.own(physical, stretch.record)
        return replace(stretch, axis=axis, inputs=inputs), theta

    def jacobian_by_start(self, physical: Array) -> tuple[tuple[slice, Array], ...]:
        """See `PredictionErrors.jacobian_by_start`."""
        if least_sizes(self._form).any():
            return ()
        found = []
        for each, rows in zip(self.stretches, chain(*self.spans), strict=True):
            if not each.inputs.start.velocity:
                continue
            record, (at, own) = self._records[each.record], self._at(each, physical)
            position = record.position[slice(*record.spans[each.segment])]
            start, step = at.inputs.start, STEP * np.array(start_sizes(position, record.period))
            there = np.array([[float(start.position)], [float(start.velocity)]])
            moved = there + step[:, None] * np.array([[1, -1, 0, 0], [0, 0, 1, -1]])
            inputs = replace(at.inputs, start=replace(start, position=moved[0], velocity=moved[1]))
            out, failures = at.rows(np.tile(own, (4, 1)), inputs)
            slopes = at.counted[:, None] * (out[:, ::2] - out[:, 1::2]) / (2 * step)
            if not failures and np.all(np.isfinite(slopes)):
                found.append((rows, slopes))
        return tuple(found)

    def doubts_of_memory(self, physical: Array) -> Array:
        """See `PredictionErrors.doubts_of_memory`."""
        columns = [super().doubts_of_memory(physical)]
        for each, rows in zip(self.stretches, chain(*self.spans), strict=True):
            at, own = self._at(each, physical)
            root = memory_deviations(at.axis, self._records[each.record])[each.segment]
            if not len(root):
                continue
            start = at.inputs.start
            law = np.pad(root, ((0, 0), (0, len(start.memory) - root.shape[1])))  # not the drive's
            lanes = replace(start, memory=start.memory + np.vstack([law, -law]))
            tiled = np.tile(own, (2 * len(law), 1))
            out, failures = at.rows(tiled, replace(at.inputs, start=lanes))
            if failures:
                raise EstimationError(next(iter(failures.values())), code="simulation")
            more, less = np.split(out, 2, axis=1)
            columns.append(np.zeros((len(self.measured), len(law))))
            columns[-1][rows] = at.counted[:, None] * (more - less) / 2
        return np.hstack(columns)

    def jacobian_by_law(self, physical: Array) -> Mapping[str, Array]:
        """See `PredictionErrors.jacobian_by_law`."""
        slopes = [jacobian_by_law(*self._at(each, physical)) for each in self.stretches]
        shared = [name for name in slopes[0] if all(name in each for each in slopes)]
        return {name: np.concatenate([each[name] for each in slopes]) for name in shared}

    def velocities(self, physical: Array) -> tuple[Array, ...]:
        """See `PredictionErrors.velocities`."""
        velocities: list[list[Array]] = [[] for _ in self.samples]
        for each in self.stretches:
            at, theta = self._at(each, physical)
            loop = at.simulated(theta[None, :], at.inputs, ["velocity"])
            if loop.failures or at.inputs.clocks is not None:
                return ()
            velocities[each.record].append(loop["velocity"][:, 0])
        return tuple(map(np.concatenate, velocities))

    def _errors(self, physical: Array) -> Iterator[tuple[Array, Mapping[int, str]]]:
        gains = gains_in(self._form, physical)
        for stretch in self.stretches:
            theta = np.array([self._form.own(lane, stretch.record) for lane in physical])
            inputs = stretch.inputs
            if gains:
                memories = [self._at(stretch, lane)[0].inputs.start.memory for lane in physical]
                inputs = replace(inputs, start=replace(inputs.start, memory=np.array(memories)))
            inputs = started_at(self._form, physical, stretch.record, stretch.segment, inputs)
            with np.errstate(all="ignore"):
                out, failures = stretch.rows(theta, inputs, gains)
            errors = out - stretch.measured[:, None]
            errors[stretch.counted == 0] = 0.0
            yield errors, failures


def _stretches(
    number: int, axis: GeneratedAxis, record: Record, measured: Sequence[MeasuredOutput]
) -> Iterator[Stretch]:
    loop_reference(axis, record)  # or it is refused
    counted = ~mask_of(record.masked, len(record))
    starts = zip(record.spans, loop_starts(axis, record), strict=True)
    for segment, (span, start) in enumerate(starts):
        rows = slice(*span)
        yield Stretch(
            record=number,
            spans=((span[1] - span[0]) * len(measured),),
            samples=np.arange(*span),
            measured=interleaved([each.values[rows] for each in measured]),
            counted=np.repeat(counted[rows], len(measured)).astype(float),
            axis=axis,
            segment=segment,
            inputs=recorded_inputs(axis, record, span, start),
            outputs=tuple(each.signal for each in measured),
        )


@cached_per_record
def memory_deviations(axis: GeneratedAxis, record: Record) -> list[Array]:
    """Deviations of what the law remembers where segments begin: roots of covariances, (k, m) each.

    It is of the first controls, whose noise follows the autoregression that the law leaves of all,
    but for another memory. None of a memory that is declared, (0, m).

    Parameters
    ----------
    axis : GeneratedAxis
        With a control law.
    record : Record
    """
    size, influences = law_memory(axis), dict[int, Array]()
    residuals, every_counted = list[Array](), list[NDArray[np.bool_]]()
    for segment, span in enumerate(record.spans):
        read = as_read_by_law(axis, record, span)
        memory = first_memory(axis, read, span)
        if memory is None:
            continue
        (residual, counted), ticks = law_residual(axis, record, span), law_ticks(axis, read, span)
        slopes = slopes_along(axis, ticks, memory)
        slopes = np.where(counted[:, None] & np.isfinite(slopes), slopes, 0.0)
        norms = np.linalg.norm(slopes[:START_SAMPLES], axis=0)
        norms = np.where(norms > 0, norms, 1.0)
        unit = slopes / norms
        inverse = np.linalg.pinv(unit[:START_SAMPLES], rcond=MIN_MEMORY_EFFECT)
        influences[segment] = inverse / norms[:, None]
        explained = unit @ np.linalg.lstsq(unit, residual, rcond=MIN_MEMORY_EFFECT)[0]
        residuals.append(residual - explained)
        every_counted.append(counted)
    roots = [np.zeros((0, size)) for _ in record.spans]
    if not influences:
        return roots
    model = autoregression_of(residuals, record.period, every_counted)
    used = sum(map(np.count_nonzero, every_counted))
    widened = used / max(used - size * len(residuals), 1)
    for segment, influence in influences.items():
        variances, directions = np.linalg.eigh(widened * model.coloured(influence.T))
        roots[segment] = np.sqrt(np.maximum(variances, 0.0))[:, None] * directions.T
    return roots


def jacobian_by_law(stretch: Stretch, theta: Array) -> Mapping[str, Array]:
    """Slopes of a stretch's outputs, (n,), by the gains of the term.

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
    law, inputs = stretch.axis.axis.control, stretch.inputs
    if law is None or law.continuous:
        return {}
    wanted = ("position", "velocity")
    loop = stretch.simulated(theta[None, :], replace(inputs, clocks=None), wanted)
    if loop.failures:
        return {}
    position, velocity = (loop[name][:, 0] for name in wanted)
    ticks = LawInputs.at_samples(inputs.reference, position, velocity, inputs.signals)
    # The loop's memory has the drive's behind the law's, whose terms do not depend on it.
    memory, count = inputs.start.memory, law_memory(stretch.axis)
    start = state_at_rest(stretch.axis, ticks) if memory is None else np.asarray(memory)[:count]
    terms = law_terms_along(stretch.axis, ticks, start)
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
    slopes = stretch.counted[:, None] * (more - less) / (2 * _ADDED_SHARE)
    return {str(gains): each for (gains, _), each in zip(law.terms, slopes.T, strict=True)}


# The records of a fit have one axis, or few, and to build one may compile its loop. Of two that are
# equal one may be compiled and the other not.
@lru_cache(maxsize=16)
def unrounded(axis: GeneratedAxis, *, native: bool) -> GeneratedAxis:
    """The same axis, its drive without steps, compiled or not; itself where that has none."""
    if not axis.declared.drive.quantisation:
        return axis
    drive = axis.declared.drive
    others = drive.delay or not replace(drive.path, quantisation=0.0).is_plain
    # What acts of a command that nothing changes is the command.
    logged = drive.logged if others or drive.logged != "applied" else "command"
    smooth = replace(drive, quantisation=0.0, logged=logged)
    return build(replace(axis.declared, drive=smooth), native=native)
