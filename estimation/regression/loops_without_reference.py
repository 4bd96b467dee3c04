"""Simulated loops of a record of which the reference is not known, and what tells that they serve.

What the axis got is known all the same: its control was recorded. Simulated with that alone the
axis would drift away, so that the law holds it: its reference is the recorded position, and what it
made of that position is taken off the recorded control. The axis so gets the recorded control, and
the law's answer to where it departs from the record. Where the law is the drive's, and measures
what was recorded, this is the loop as it was but for the noise, whatever its reference was: the
noise in the recorded control is taken off with the rest.
"""

from dataclasses import replace

import numpy as np

from axisid.codegen.lowering import LoopStart
from axisid.estimation.law_replay import (
    LawInputs,
    first_velocity,
    law_along,
    shifted_start,
    state_at_rest,
    with_drive_memory,
)
from axisid.estimation.records import Record, law_clock
from axisid.estimation.signals import FilteredRecord, control_delay_in_log, hides_command, hold_mean
from axisid.estimation.simulation import Simulation, law_of, no_control_law
from axisid.support.arrays import Array
from axisid.support.errors import DataError, ModelError, refuse

from .simulated_instruments import simulated_loops

# of the law's answer to the position's noise is in the control: 1 where the law measured what was
# recorded, 0 where the log is coarser
_LEAST_MEASURED_NOISE = 0.8
_STRETCH = 50  # samples
_LATEST = 3  # samples by which a log may be late
_MOSTLY = 0.5


def recorded_loops(
    data: FilteredRecord,
    physical: Array,
    *,
    resolution: float = 0.0,
    away: float = 0.0,
    position_noise: Array | None = None,
    disturbance: Array | None = None,
) -> tuple[Simulation, ...]:
    """The loops of a record: from its reference, or following its position; see `simulated_loops`.

    Raises
    ------
    ModelError, DataError, EstimationError
        As `simulated_loops` and `followed_record` do.
    """
    record, starts = data.record, None
    if record.reference is None:
        record = followed_record(data)
        starts = tuple(_start(data, *span, away) for span in record.spans)
    return simulated_loops(
        data.axis,
        record,
        physical,
        resolution=resolution,
        away=away,
        position_noise=position_noise,
        disturbance=disturbance,
        starts=starts,
    )


def followed_record(data: FilteredRecord) -> Record:
    """A record whose loop follows it: its position is the reference, and what is added is known.

    That is the recorded control without the law's answer to the recorded position, in the drive's
    unit. A velocity that no record has is the filtered one.

    Raises
    ------
    ModelError
        The axis has no control law.
    DataError
        The record is of another period than the law, its law is continuous, or neither control
        nor force tells what the drive was given.
    """
    control, position = _control(data), data.record.position
    answer = _answer_to_noise(data)
    if _share(control, answer) < _LEAST_MEASURED_NOISE:
        raise DataError("the control does not answer to the noise of the recorded position.")
    added = control - _answer(data, position, position)
    late = control_delay_in_log(data.axis, law_of(data.axis))
    for first, last in data.record.spans:  # it is applied as late as the law's own
        added[first : last - late] = added[first + late : last]
    return replace(data.record, reference=position, injected=added, injected_at="control")


def _start(data: FilteredRecord, first: int, last: int, away: float) -> LoopStart:
    """Where the loop of a segment starts: on its reference, and all that is added balances."""
    record = data.record
    start = LoopStart(
        position=float(record.position[first]),
        velocity=first_velocity(record.position[first:last], record.period),
    )
    followed = replace(record, reference=record.position)
    start = with_drive_memory(data.axis, followed, (first, last), start)
    if not away:
        return start
    signals = [float(values[first]) for values in data.recorded]
    return shifted_start(data.axis, start, start.position, signals, away)


def loop_carries_noise(data: FilteredRecord) -> bool:
    """Whether the loop of a record has noise of its position.

    It follows by a velocity that is in no record: that of the filter has the noise of the position,
    which the law's own had not.
    """
    law, record = data.axis.axis.control, data.record
    takes_velocity = law is not None and law.takes_velocity
    return takes_velocity and record.reference is None and record.velocity is None


def is_measured_by_law(data: FilteredRecord) -> bool:
    """Whether the law measured the recorded position, noise and all; so where none can be asked.

    A log that tells its answer early, late or with another factor tells it all the same.
    """
    try:
        control, answer = _control(data), _answer_to_noise(data)
    except (ModelError, DataError):
        return True
    lags = range(-_LATEST, _LATEST + 1)
    return any(abs(_share(np.roll(control, lag), answer)) > _MOSTLY for lag in lags)


def _answer_to_noise(data: FilteredRecord) -> Array:
    """What the law makes of what the filter takes off the recorded position, (N,).

    Raises
    ------
    ModelError
        The axis has no control law.
    DataError
        The record is of another period than the law, or its law is continuous.
    """
    law = data.axis.axis.control
    if law is None:
        raise no_control_law(data.axis.axis.name)
    refuse(
        DataError,
        (
            law.continuous or law_clock(law, data.record).ratio != 1.0,
            "no sampled law is known that a simulated loop would follow by",
        ),
        (data.record.integrated, "no position was recorded that a simulated loop would follow"),
    )
    smooth = data.motion[0]
    return _answer(data, smooth, data.record.position) - _answer(data, smooth, smooth)


def _answer(data: FilteredRecord, reference: Array, position: Array) -> Array:
    """The law's control for a reference and a measured position, (N,).

    As a force sensor sees it, where that tells the control: in the mean of what is held before and
    after a sample.
    """
    velocity, averaged = data.motion[1], data.record.control is None
    pieces = []
    for a, b in data.record.spans:
        recorded = tuple(values[a:b] for values in data.recorded)
        ticks = LawInputs.at_samples(reference[a:b], position[a:b], velocity[a:b], recorded)
        made = law_along(data.axis, ticks, state_at_rest(data.axis, ticks))
        pieces.append(hold_mean(made, [0]) if averaged else made)
    return np.concatenate(pieces)


def _share(control: Array, answer: Array) -> float:
    """How much of the law's answer to the position's noise is in the control; 1 if it should be.

    Of the motion little is left in second differences, but where it turns or a move begins: beside
    a quiet sensor that is more than its noise. So it is the median of short stretches.
    """
    count = (len(control) - 2) // _STRETCH
    actual, expected = (
        np.diff(values, 2)[: count * _STRETCH].reshape(count, _STRETCH)
        for values in (control, answer)
    )
    power = np.sum(expected**2, axis=1)
    actual, expected, power = actual[power > 0], expected[power > 0], power[power > 0]
    return float(np.median(np.sum(actual * expected, axis=1) / power)) if len(power) else 1.0


def _control(data: FilteredRecord) -> Array:
    record, drive = data.record, data.axis.axis.drive
    is_late = drive.logged == "current"
    if is_late or hides_command(data.axis):
        passed = ["lag"] if is_late else drive.path.declared
        raise DataError(
            "the record tells no command, but what the drive passes on of it: its "
            f"{' and '.join(passed)}."
        )
    if record.control is not None:
        return record.control
    if record.force is None or not drive.is_gain:
        raise DataError("the record tells no control, nor a force that is the control's gain.")
    return record.force / float(drive.gain)
