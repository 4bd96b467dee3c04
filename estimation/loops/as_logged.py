"""The law's output where a record has it: as it is given, after the drive's delay or its lag."""

from dataclasses import replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.estimation.records import Record
from axisid.estimation.signals import (
    acting_along,
    drive_force,
    recorded_signals,
    through_path,
)
from axisid.estimation.simulation import law_of
from axisid.support.arrays import Array


def as_logged(axis: GeneratedAxis, values: Array) -> Array:
    """What a law gives, or its terms, where the records of its axis have the control.

    Parameters
    ----------
    axis : GeneratedAxis
    values : (N,) or (N, k) array
        Sample by sample, of one stretch.
    """
    drive, response = axis.axis.drive, axis.axis.response
    if response is None or not drive.logs_what_acts:
        return values
    if drive.logged == "current":
        columns = values.reshape(len(values), -1).T
        seen = [acting_along(column, response).at_samples for column in columns]
        return np.stack(seen, axis=1).reshape(values.shape) if seen else values
    return values[np.maximum(np.arange(len(values)) - response.late, 0)]


def commands_as_logged(axis: GeneratedAxis, commands: Array, *, steps: bool = True) -> Array:
    """The same of commands, (N,), also behind the drive's limit and path where the log has that.

    Without `steps` they are not rounded to those of the drive, which have no slope.
    """
    if hides_command(axis):
        limit, path = axis.axis.drive.limit, axis.axis.drive.path
        path = path if steps else replace(path, quantisation=0.0)
        commands = through_path(path, np.clip(commands, -limit, limit), law_of(axis).period)
    return as_logged(axis, commands)


def hides_command(axis: GeneratedAxis) -> bool:
    """Whether different commands may be one in the log: it has what the drive makes of them."""
    return axis.axis.drive.logs_what_acts and not axis.axis.drive.path.is_plain


def limit_in_log(axis: GeneratedAxis) -> float:
    """What the record has of a command at the drive's limit, but for what a rate leaves of it."""
    drive = axis.axis.drive
    return drive.path.end(drive.limit) if drive.logs_what_acts else drive.limit


def late_in_log(axis: GeneratedAxis) -> int:
    """Samples by which the recorded control is later than the law gives it."""
    law, response = axis.axis.control, axis.axis.response
    late = 0 if law is None else law.delay
    applied = response is not None and axis.axis.drive.logged == "applied"
    return late + (response.late if applied and response is not None else 0)


def with_drive(
    axis: GeneratedAxis, record: Record, span: tuple[int, int], start: LoopStart
) -> LoopStart:
    """A start of a segment's loop with what the drive remembers there, of its first controls.

    Before the record it is taken to have got the first of them.

    Parameters
    ----------
    axis : GeneratedAxis
    record : Record
    span : tuple of int
        The segment: first row and the one after the last.
    start : LoopStart
        With what the law remembers; None of it for that of an axis at rest.
    """
    response, row = axis.axis.response, span[0]
    if response is None:
        return start
    memory = start.memory
    if memory is None:
        reference = start.position if record.commanded is None else record.commanded[row]
        signals = recorded_signals(axis, record.provenance.source, record.signals)
        at_rest = axis.functions["control_start"]
        memory = at_rest(reference, start.position, *(values[row] for values in signals))
        memory = memory.full().ravel()
        if record.control is None:
            return replace(start, memory=memory)
        memory = memory[: -len(response.remembered)]
    drive = _first_remembered(axis, record, span, start)
    return replace(start, memory=np.concatenate([memory, drive]))


def _first_remembered(
    axis: GeneratedAxis, record: Record, span: tuple[int, int], start: LoopStart
) -> Array:
    """What a drive remembers where a segment begins, in its order."""
    response = axis.axis.response
    assert response is not None  # noqa: S101  # whoever asks has one
    late = response.late if axis.axis.drive.logged == "applied" else 0
    pending = len(response.forces) - response.keeps_force
    # The newest first; those that act before the record are taken for the first that does in it.
    ahead = [max(late - 1 - i, 0) for i in range(pending)] + [0] * response.keeps_force
    rows = np.minimum(span[0] + np.array(ahead, dtype=np.intp), span[1] - 1)
    signals = recorded_signals(axis, record.provenance.source, record.signals)
    still = np.full(len(rows), start.position), np.full(len(rows), start.velocity)
    recorded = tuple(values[rows] for values in signals)
    control, path = np.asarray(record.control), axis.axis.drive.path
    controls, first = control[rows], float(control[span[0]])
    if axis.axis.drive.logs_what_acts:
        first = path.command(first)
    else:
        controls = np.array([path.end(float(each)) for each in controls])
    last = [first] * path.is_limited
    made = drive_force(axis, controls, *still, recorded)
    kept = np.append(controls[:-1], made[-1]) if response.holds_control else made
    return np.concatenate([last, kept])
