"""Regression rows of the simulated closed loop: instruments, and the left side of the model.

Without a recorded reference, the recorded control is used. Simulated with this control alone, the
axis would drift away from the record, so the control law keeps it there: the reference of the law
is the recorded position, and the control that the law computes for the recorded position is
subtracted from the recorded control. The axis then receives the recorded control plus the law's
response to the deviation from the record. If the drive has the declared law, and the law reads the
recorded position, this is the original loop without its noise, for any reference: the noise in the
recorded control is subtracted as well.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.estimation.choices import open_loop_fit
from axisid.estimation.law_replay import (
    LawInputs,
    first_velocity,
    law_along,
    loop_starts,
    shifted_start,
    state_at_rest,
    two_clocks,
    with_drive_memory,
)
from axisid.estimation.records import (
    Record,
    law_clock,
)
from axisid.estimation.signals import (
    FilteredRecord,
    control_delay_in_log,
    hides_command,
    hold_mean,
    recorded_signals,
)
from axisid.estimation.simulation import (
    LoopInputs,
    Simulation,
    StepBudget,
    law_of,
    no_control_law,
    signals_about,
    simulate_loop,
)
from axisid.support.arrays import Array
from axisid.support.caching import cached_while_alive
from axisid.support.checks import refuse
from axisid.support.errors import AxisidError, DataError, ModelError
from axisid.support.settings import setting

from .inverse_and_direct import Equations, Form


class LoopDataError(DataError):
    """The record lacks data to simulate its closed loop."""


def _without_loop() -> str:
    """Return a sentence, after a space, that advises methods without a simulated loop."""
    return (
        " Otherwise keep the least-squares estimate, which needs no closed loop, or fit the "
        f"position under the recorded control: {open_loop_fit()}."
    )


def lacking_loop(axis: GeneratedAxis, record: Record) -> AxisidError | None:
    """Return the error of a record whose closed loop cannot be simulated; None if it can.

    The axis has no control law, or the record has no reference.
    """
    if axis.control is None:
        return lacking_law(axis)
    if record.commanded is not None:
        return None
    return LoopDataError(
        "the simulation of the closed loop needs the reference, and "
        f"{record.provenance.source} has no reference column. Name the reference column with "
        f"{setting('columns', {'reference': 'NAME'})}.{_without_loop()}",
        code="missing-column",
    )


def lacking_law(axis: GeneratedAxis) -> ModelError:
    """Return the error of an axis without a control law, with methods that need none."""
    error = no_control_law(axis.name)
    return ModelError(f"{error}{_without_loop()}", code=error.code)


@cached_while_alive
def loop_reference(axis: GeneratedAxis, record: Record) -> Array:
    """Return the reference of the closed loop of a record, (N,), in the unit of the position.

    It is the recorded reference, plus a test signal that was added to the reference.

    Raises
    ------
    ModelError
        The axis has no control law.
    LoopDataError
        The record has no reference; the period of the record differs from that of the law, and is
        not confirmed; or the loop cannot be simulated at the record's period.
    """
    law, reference = axis.control, record.commanded
    if law is None or reference is None:
        raise lacking_loop(axis, record) or lacking_law(axis)
    clock = law_clock(law, record)
    refuse(
        LoopDataError,
        (clock.ratio is None and clock.doubt, clock.doubt),
        (
            clock.ratio is None,
            f"the record was resampled every {record.period:.6g} s, but the control law of axis "
            f"{axis.name!r} runs every {law.period:.6g} s. Resample at the period of the law, or "
            "do not resample",
        ),
        (
            clock.ratio != 1 and not (axis.response is None and axis.drive.path.is_plain),
            f"the record is sampled every {record.period:.6g} s, but the control law of axis "
            f"{axis.name!r} runs every {law.period:.6g} s. Its drive has a "
            f"{' and '.join(axis.of_law_samples)}, and the loop of this drive can only be "
            "simulated at the samples of the law. Record at the period of the law, or use least "
            "squares",
        ),
        code="loop-period",
    )
    return reference


def simulated_loops(
    axis: GeneratedAxis,
    record: Record,
    physical: Array,
    *,
    resolution: float = 0.0,
    away: float = 0.0,
    position_noise: Array | None = None,
    disturbance: Array | None = None,
    budget: StepBudget | None = None,
    starts: Sequence[LoopStart] | None = None,
) -> tuple[Simulation, ...]:
    """Return the simulated closed loops of a record, one for each segment.

    Parameters
    ----------
    axis : GeneratedAxis
    record : Record
        Record with a reference.
    physical : (p,) array
        Parameters of the axis.
    resolution : float
        Encoder step; 0 for none.
    away : float
        Offset of the positions that the law reads, and of the reference, from those of the axis.
    position_noise : (N,) array, optional
        Noise that is added to the position that the law reads; `away` by default.
    disturbance : (N,) array, optional
        Disturbance that is added to the control, in the drive's unit.
    budget : StepBudget, optional
        Remaining integration steps of a search.
    starts : sequence of LoopStart, optional
        Initial state of each segment; by default that of `loop_starts`.

    Raises
    ------
    ModelError, LoopDataError
        As in `loop_reference`.
    EstimationError
        The loop cannot be simulated with these parameters.
    """
    # Signals of the whole record: reference, added control, noise and recorded signals.
    reference, added = loop_reference(axis, record), record.added_control
    if disturbance is not None:
        added = disturbance if added is None else added + disturbance
    noise = position_noise
    if away and noise is None:
        noise = np.full(len(record), away)
    signals = recorded_signals(axis, record.provenance.source, record.signals)
    begins = loop_starts(axis, record, away) if starts is None else starts
    loops = []
    for (first, last), start in zip(record.spans, begins, strict=True):
        inputs = LoopInputs(
            reference=reference[first:last] + away,
            period=record.period,
            start=start,
            noise=None if noise is None else noise[first:last],
            injected=None if added is None else added[first:last],
            signals=tuple(values[first:last] for values in signals),
            resolution=resolution,
        ).at_law(axis, two_clocks(axis, record, (first, last)))
        loops.append(simulate_loop(axis, physical, inputs, budget=budget))
    return tuple(loops)


def simulated_position(loops: Sequence[Simulation]) -> Array:
    """Return the concatenated positions of the loops, (N,)."""
    return np.concatenate([loop.position for loop in loops])


def simulated_rows(
    form: Form, loops: Sequence[Simulation], physical: Array, data: FilteredRecord
) -> Equations:
    """Return the rows of simulated loops, filtered and decimated like those of the record.

    Parameters
    ----------
    form : Form
        Form of the rows.
    loops : sequence of Simulation
        Loop of each segment.
    physical : (p,) array
        Parameters of the loops.
    data : FilteredRecord
        The record with its filter.
    """
    pieces = [loop_equations(form, loop, physical, data.prefilter.hold) for loop in loops]
    return Equations.stacked(pieces).reduced(data)


def loop_equations(form: Form, loop: Simulation, physical: Array, hold: str | None) -> Equations:
    """Return the rows of a form at each sample of a simulated loop, without filter.

    With the hold ``zoh``, the control changes at each sample. The rows just before and just after
    the sample are then averaged, as the measured force is. `physical`, (p,), are the parameters of
    the loop.
    """
    at = form.at(physical)
    if hold != "zoh":
        return at.equations(loop.signals)
    after, earlier = map(at.equations, signals_about(form.axis, physical, loop))
    return Equations(
        left=(after.left + earlier.left) / 2,
        intercept=(after.intercept + earlier.intercept) / 2,
        regressor=(after.regressor + earlier.regressor) / 2,
    )


# least share of the law's response to position noise that the control must have, for a loop that
# follows the record: 1 if the law reads the recorded position, 0 if the log is coarser
_LEAST_SHARE_TO_FOLLOW = 0.8
_STRETCH = 50  # samples of a stretch, whose shares are compared
_LATEST = 3  # samples by which the control may be early or late in the log
_LEAST_SHARE_IF_READ = 0.5  # from which the law read the recorded position


def recorded_loops(
    data: FilteredRecord,
    physical: Array,
    *,
    resolution: float = 0.0,
    away: float = 0.0,
    position_noise: Array | None = None,
    disturbance: Array | None = None,
) -> tuple[Simulation, ...]:
    """Return the simulated loops of a record, one for each segment.

    They follow the recorded reference, or the recorded position if there is no reference. The
    arguments are those of `simulated_loops`, with the filtered record instead of axis and record.

    Raises
    ------
    ModelError, DataError, EstimationError
        As in `simulated_loops` and `followed_record`.
    """
    record, starts = data.record, None
    if record.reference is None:
        record = followed_record(data)
        starts = tuple(_start_on_record(data, *span, away) for span in record.spans)
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
    """Return a record without a recorded reference, changed so that its loop can be simulated.

    The simulated loop follows the recorded position. The reference is the recorded position, and
    the injected control is the recorded control minus the control that the law computes for the
    recorded position, in the drive's unit. If the velocity was not recorded, the law reads the
    filtered velocity.

    Raises
    ------
    ModelError
        The axis has no control law.
    DataError
        The record has a period other than the law's, the law is continuous, neither control nor
        force shows the command of the drive, or the control does not respond to the noise of the
        recorded position.
    """
    control, position = _recorded_command(data), data.record.position
    response = _response_to_noise(data)
    if _share_of_response(control, response) < _LEAST_SHARE_TO_FOLLOW:
        raise DataError(
            "the control in the record does not respond to the noise of the recorded position."
        )
    added = control - _control_by_law(data, position, position)
    # In the log, the control is late by the delay of the law, in samples.
    delay = control_delay_in_log(data.axis, law_of(data.axis))
    for first, last in data.record.spans:
        added[first : last - delay] = added[first + delay : last]
    return replace(data.record, reference=position, injected=added, injected_at="control")


def _start_on_record(data: FilteredRecord, first: int, last: int, away: float) -> LoopStart:
    """Return the initial state of the loop of a segment that follows the recorded position.

    The axis starts at the recorded position, with the velocity of the record.

    Parameters
    ----------
    data : FilteredRecord
    first, last : int
        First sample of the segment, and the sample after its last one.
    away : float
        Offset of the positions that the law reads, as in `simulated_loops`.
    """
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
    """Return True if position noise enters the simulated loop of a record.

    This is so if the law reads a velocity that was not recorded, and the loop follows the recorded
    position. The law then reads the filtered velocity, which has position noise that the velocity
    in the drive did not have.
    """
    law, record = data.axis.control, data.record
    takes_velocity = law is not None and law.takes_velocity
    return takes_velocity and record.reference is None and record.velocity is None


def is_measured_by_law(data: FilteredRecord) -> bool:
    """Return True if the law read the recorded position with its noise, or if that is unknown.

    The recorded control then has at least half of the law's response to the noise. The response may
    be some samples early or late in the log, or have another factor or sign.
    """
    try:
        control, response = _recorded_command(data), _response_to_noise(data)
    except (ModelError, DataError):
        return True
    for lag in range(-_LATEST, _LATEST + 1):
        share = _share_of_response(np.roll(control, lag), response)
        if abs(share) > _LEAST_SHARE_IF_READ:
            return True
    return False


def _response_to_noise(data: FilteredRecord) -> Array:
    """Return the change of the law's control by the position noise that the filter removes, (N,).

    Raises
    ------
    ModelError
        The axis has no control law.
    DataError
        The record has a period other than the law's, the law is continuous, or the position is an
        integrated velocity.
    """
    law = data.axis.control
    if law is None:
        raise no_control_law(data.axis.name)
    refuse(
        DataError,
        (
            law.continuous or law_clock(law, data.record).ratio != 1.0,
            "a simulated loop cannot follow the record without a sampled law of the same period",
        ),
        (
            data.record.integrated,
            "a simulated loop cannot follow a record without a measured position",
        ),
    )
    smooth = data.motion[0]
    with_noise = _control_by_law(data, smooth, data.record.position)
    return with_noise - _control_by_law(data, smooth, smooth)


def _control_by_law(data: FilteredRecord, reference: Array, position: Array) -> Array:
    """Return the control that the law computes for a reference and a measured position, (N,).

    The law reads the filtered velocity. Without a recorded control, the mean of the controls held
    before and after a sample is returned, as a force sensor measures it.
    """
    velocity = data.motion[1]
    pieces = []
    for first, last in data.record.spans:
        span = slice(first, last)
        recorded = tuple(values[span] for values in data.recorded)
        inputs = LawInputs.at_samples(reference[span], position[span], velocity[span], recorded)
        control = law_along(data.axis, inputs, state_at_rest(data.axis, inputs))
        if data.record.control is None:
            control = hold_mean(control, [0])
        pieces.append(control)
    return np.concatenate(pieces)


def _share_of_response(control: Array, response: Array) -> float:
    """Return the share of the law's response to position noise that the control has; expected 1.

    It is ``median_s(d_s' a_s / a_s' a_s)`` over stretches s of 50 samples, with the second
    differences d of the control and a of the response. Second differences remove most of the
    motion, except at reversals and starts of moves, where the motion may exceed the noise of a good
    sensor; hence the median. It is 1 if there is no response.

    Parameters
    ----------
    control : (N,) array
        Recorded control.
    response : (N,) array
        Response of the law to the noise, as from `_response_to_noise`.
    """
    # Second differences by stretch, (s, 50).
    count = (len(control) - 2) // _STRETCH
    actual = np.diff(control, 2)[: count * _STRETCH].reshape(count, _STRETCH)
    expected = np.diff(response, 2)[: count * _STRETCH].reshape(count, _STRETCH)
    power = np.sum(expected**2, axis=1)
    has_response = power > 0
    if not has_response.any():
        return 1.0
    products = np.sum(actual[has_response] * expected[has_response], axis=1)
    return float(np.median(products / power[has_response]))


def _recorded_command(data: FilteredRecord) -> Array:
    """Return the command of the drive, (N,): the recorded control, or that of the recorded force.

    Raises
    ------
    DataError
        The log hides the command, or has neither a control nor a force of a drive that is a gain.
    """
    record, drive = data.record, data.axis.drive
    is_after_lag = drive.logged == "current"
    if is_after_lag or hides_command(data.axis):
        passed = ["lag"] if is_after_lag else drive.path.declared
        raise DataError(
            "the record does not show the command, because the control was logged after the "
            f"drive's {' and '.join(passed)}."
        )
    if record.control is not None:
        return record.control
    if record.force is None or not drive.is_gain:
        raise DataError("the record has no control, and no force that is the control times a gain.")
    return record.force / float(drive.gain)
