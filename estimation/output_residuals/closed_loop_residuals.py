"""Residuals of the simulated closed loop of each record, for many parameter sets in one batch.

Several outputs come from one simulation, and their rows alternate: control, position, control,
position, and so on.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis, build
from axisid.estimation.choices import CONTROL, FORCE
from axisid.estimation.law_replay import loop_starts, recorded_inputs
from axisid.estimation.records import Record, sensor_steps
from axisid.estimation.regression import Form, loop_reference
from axisid.estimation.simulation import most_substeps, settled_substeps
from axisid.estimation.unknowns import gains_in, started_at
from axisid.support.arrays import Array, mask_of
from axisid.support.errors import DataError, EstimationError
from axisid.support.settings import setting

from .output_residuals import OutputResiduals, Stretch, interleaved


def measured_output(output: str, axis: GeneratedAxis, record: Record) -> tuple[str, str, Array]:
    """Return the recorded output of a fit: its name in `Simulation`, its unit and its values, (N,).

    Parameters
    ----------
    output : str
        One of `axisid.estimation.choices.OUTPUTS`.
    axis : GeneratedAxis
    record : Record

    Raises
    ------
    DataError
        The record has no such column, or its position is integrated from a measured velocity.
    """
    q, drive = axis.coordinate, axis.drive
    name, unit, values = {
        CONTROL: (CONTROL, drive.unit, record.control),
        FORCE: (FORCE, q.force_unit, record.force),
    }.get(output, ("position", q.unit, None if record.integrated else record.position))
    if values is None:
        raise DataError(
            f"{record.provenance.source} has no {name} column, which is the output of the fit. "
            f"Name the column with {setting('columns', {name: 'NAME'})}, or choose another output.",
            code="missing-column",
        )
    return name, str(unit), np.asarray(values)


class ClosedLoopResiduals(OutputResiduals):
    """Residuals of the simulated closed loops of the records.

    Parameters
    ----------
    form : Form
        Map of the parameters of the fit to those of each record's axis.
    axes : sequence of GeneratedAxis
        Axis of each record. Its drive is simulated without rounding, see `unrounded`.
    records : sequence of Record
    outputs : str or sequence of str
        Names of the fitted outputs, from `axisid.estimation.choices.OUTPUTS`.

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
        stretches: list[Stretch] = []
        for number, (axis, record) in enumerate(zip(axes, records, strict=True)):
            measured = [measured_output(name, axis, record) for name in names]
            smooth = unrounded(axis, native=axis.native.enabled)
            stretches += _stretches(number, smooth, record, measured)
            self.units = tuple(unit for _, unit, _ in measured)
            self.step = max(self.step, sensor_steps(axis, record)[0])
        self.stretches = stretches
        super().__init__(form, records, stretches)

    def outputs_of(self, records: Sequence[Record], physical: Array) -> Array:
        """Return recorded minus simulated outputs of other records of the same samples, (n,).

        The loops start from the initial states that the first samples of those records give.
        """
        pieces = []
        for each in self.stretches:
            record, (at, theta) = records[each.record], self._at(each, physical)
            rows = slice(*record.spans[each.segment])
            start = loop_starts(at.axis, record)[each.segment]
            inputs = started_at(
                self._form, physical, each.record, each.segment, replace(at.inputs, start=start)
            )
            out, failures = at.rows(theta[None, :], inputs)
            if failures:
                raise EstimationError(failures[0], code="simulation")
            recorded = interleaved([getattr(record, name)[rows] for name in each.outputs])
            pieces.append(recorded - out[:, 0])
        return np.concatenate(pieces)

    def settle(self, physical: Array) -> None:
        """Choose the number of steps per sample for all lanes near parameters (P,).

        Raises
        ------
        EstimationError
            Friction with internal state is so stiff that samples need the largest number of steps:
            such loops are not resolved, and a search would take hours.
        """
        for each in self.stretches:
            theta = self._form.own(physical, each.record)
            steps = settled_substeps(each.axis, theta, each.inputs) or 1
            if each.axis.states and steps >= most_substeps(len(each.inputs.reference)):
                raise EstimationError(
                    f"with {each.axis.describe(theta)} the friction of axis "
                    f"{each.axis.name!r} is so stiff that a sample needs {steps} steps, the "
                    "largest allowed number. Start from nominal values of the right order of "
                    "magnitude, or give the stiffness a bound.",
                    code="simulation",
                )
            each.substeps = max(steps, each.substeps or 1)

    def _errors(self, physical: Array) -> Iterator[tuple[Array, Mapping[int, str]]]:
        """Yield the residuals of each segment for parameters (B, P), (n, B), and failures by lane.

        Each lane has its own gains of the law and initial states. The residuals of masked samples
        are 0.
        """
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
    number: int, axis: GeneratedAxis, record: Record, measured: Sequence[tuple[str, str, Array]]
) -> Iterator[Stretch]:
    """Yield the segments of a record with the inputs of their loops and the measured outputs.

    Parameters
    ----------
    number : int
        Number of the record.
    axis : GeneratedAxis
    record : Record
    measured : sequence of (str, str, (N,) array)
        Name, unit and values of each output, as from `measured_output`.
    """
    loop_reference(axis, record)  # refuses a record without a reference
    counted = ~mask_of(record.masked, len(record))
    starts = zip(record.spans, loop_starts(axis, record), strict=True)
    for segment, (span, start) in enumerate(starts):
        rows = slice(*span)
        yield Stretch(
            record=number,
            spans=((span[1] - span[0]) * len(measured),),
            samples=np.arange(*span),
            measured=interleaved([values[rows] for *_, values in measured]),
            counted=np.repeat(counted[rows], len(measured)).astype(float),
            axis=axis,
            segment=segment,
            inputs=recorded_inputs(axis, record, span, start),
            outputs=tuple(signal for signal, *_ in measured),
        )


# Cached, because the records of a fit have few axes, and building an axis may compile its loop. Of
# two equal axes, one may have compiled code and the other not.
@lru_cache(maxsize=16)
def unrounded(axis: GeneratedAxis, *, native: bool) -> GeneratedAxis:
    """Return the axis with a drive that does not round commands, so that outputs are smooth.

    The loop of the returned axis is compiled if `native` is True. An axis whose drive does not
    round is unchanged.
    """
    if not axis.declared.drive.quantisation:
        return axis
    drive = axis.declared.drive
    others = drive.delay or not replace(drive.path, quantisation=0.0).is_plain
    # A command that the drive does not change is the acting control.
    logged = drive.logged if others or drive.logged != "applied" else "command"
    smooth = replace(drive, quantisation=0.0, logged=logged)
    return build(replace(axis.declared, drive=smooth), native=native)
