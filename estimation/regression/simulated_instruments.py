"""Regression rows of the simulated closed loop: instruments, and the left side of the model.

Without a recorded reference, the control is known: it was recorded. Simulated with the recorded
control alone, the axis would drift away, so that the control law keeps it on the record: the
reference of the law is the recorded position, and the law's answer to that position is subtracted
from the recorded control. So the axis receives the recorded control plus the law's answer to the
deviation from the record. If the declared law is the drive's and reads the recorded position, this
is the original loop without its noise, for any reference: the noise in the recorded control is
subtracted as well.
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
    """Return sentences that advise methods without a simulated loop."""
    return (
        " Least squares needs no loop, and neither does a fit of the position under the recorded "
        f"control: {open_loop_fit()}."
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
        f"{record.provenance.source} has no reference column, from which the closed loop "
        f"is simulated. Name it with {setting('columns', {'reference': 'NAME'})}.{_without_loop()}",
        code="missing-column",
    )


def lacking_law(axis: GeneratedAxis) -> ModelError:
    """Return the error of an axis without a control law, with methods that need none."""
    error = no_control_law(axis.name)
    return ModelError(f"{error}{_without_loop()}", code=error.code)


@cached_while_alive
def loop_reference(axis: GeneratedAxis, record: Record) -> Array:
    """Return the recorded reference of a declared loop, (N,), with a test signal added to it.

    Raises
    ------
    ModelError
        The axis has no control law.
    LoopDataError
        The record has no reference, or a period other than the law's that is not confirmed.
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
            f"the record was resampled every {record.period:.6g} s, the control law of axis "
            f"{axis.name!r} runs every {law.period:.6g} s; resample at that, or leave it out",
        ),
        (
            clock.ratio != 1 and not (axis.response is None and axis.drive.path.is_plain),
            f"the record is sampled every {record.period:.6g} s, the control law of axis "
            f"{axis.name!r} runs every {law.period:.6g} s, and its drive has a "
            f"{' and '.join(axis.of_law_samples)}: such a loop is simulated at the law's "
            "samples alone; record at the law's period, or ask for least squares",
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
        Noise that is added to the position that the law reads.
    disturbance : (N,) array, optional
        Disturbance that is added to the control, in the drive's unit.
    budget : StepBudget, optional
        Remaining integration steps of a search.
    starts : sequence of LoopStart, optional
        Initial state of each segment; by default as in `loop_starts`.

    Raises
    ------
    ModelError, LoopDataError
        As in `loop_reference`.
    EstimationError
        The loop cannot be simulated with these parameters.
    """
    reference, added = loop_reference(axis, record), record.added_control
    if disturbance is not None:
        added = disturbance if added is None else added + disturbance
    noise = np.full(len(record), away) if away and position_noise is None else position_noise
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

    With the hold ``zoh``, the rows just before and just after a sample are averaged, as the
    measured force is. `physical`, (p,), are the parameters of the loop.
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


# share of the law's answer to position noise in the control: 1 if the law reads the recorded
# position, 0 if the log is coarser
_LEAST_MEASURED_NOISE = 0.8
_STRETCH = 50  # samples
_LATEST = 3  # samples by which the control may be early or late in the log
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
    """Return a record without a recorded reference, changed so that its loop can be simulated.

    The simulated loop follows the recorded position. The reference is the recorded position, and
    the injected control is the recorded control minus the control that the law computes for the
    recorded position, in the drive's unit. For a velocity that was not recorded, the law reads the
    filtered one.

    Raises
    ------
    ModelError
        The axis has no control law.
    DataError
        The record has a period other than the law's, the law is continuous, or neither control nor
        force shows the command of the drive.
    """
    control, position = _control(data), data.record.position
    answer = _answer_to_noise(data)
    if _share(control, answer) < _LEAST_MEASURED_NOISE:
        raise DataError("the control does not respond to the noise of the recorded position.")
    added = control - _answer(data, position, position)
    late = control_delay_in_log(data.axis, law_of(data.axis))
    for first, last in data.record.spans:  # with the delay of the law
        added[first : last - late] = added[first + late : last]
    return replace(data.record, reference=position, injected=added, injected_at="control")


def _start(data: FilteredRecord, first: int, last: int, away: float) -> LoopStart:
    """Return the initial state of the loop of a segment that follows the recorded position.

    It is at the recorded position, with its velocity. `first` and `last` are the first sample and
    the one after the last; `away` is an offset of the positions that the law reads.
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

    The law reads a velocity that was not recorded, and the loop follows the recorded position: the
    filtered velocity has position noise, which the velocity in the drive did not have.
    """
    law, record = data.axis.control, data.record
    takes_velocity = law is not None and law.takes_velocity
    return takes_velocity and record.reference is None and record.velocity is None


def is_measured_by_law(data: FilteredRecord) -> bool:
    """Return True if the law read the recorded position with its noise, or if that is unknown.

    The law's answer to the noise may be in the log early, late, or with another factor.
    """
    try:
        control, answer = _control(data), _answer_to_noise(data)
    except (ModelError, DataError):
        return True
    lags = range(-_LATEST, _LATEST + 1)
    return any(abs(_share(np.roll(control, lag), answer)) > _MOSTLY for lag in lags)


def _answer_to_noise(data: FilteredRecord) -> Array:
    """Return the change of the law's control by the position noise that the filter removes, (N,).

    Raises
    ------
    ModelError
        The axis has no control law.
    DataError
        The record has a period other than the law's, or the law is continuous.
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
        (data.record.integrated, "a simulated loop cannot follow a record without a position"),
    )
    smooth = data.motion[0]
    return _answer(data, smooth, data.record.position) - _answer(data, smooth, smooth)


def _answer(data: FilteredRecord, reference: Array, position: Array) -> Array:
    """Return the control that the law computes for a reference and a measured position, (N,).

    Without a recorded control, it is the mean of the controls held before and after a sample, as a
    force sensor measures it.
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
    """Return the share of the law's response to position noise that the control has; expected 1.

    ``median_s(d_s' a_s / a_s' a_s)`` over stretches s of 50 samples, with the second differences d
    of the control and a of the answer. Second differences remove most of the motion, except at
    reversals and starts of moves, where the motion may exceed the noise of a good sensor; hence the
    median.

    Parameters
    ----------
    control : (N,) array
        Recorded control.
    answer : (N,) array
        Response of the law to the noise, as from `_answer_to_noise`.
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
    """Return the recorded control, or the control of the recorded force, (N,).

    Raises
    ------
    DataError
        The log hides the command, or has neither a control nor a force of a drive that is a gain.
    """
    record, drive = data.record, data.axis.drive
    is_late = drive.logged == "current"
    if is_late or hides_command(data.axis):
        passed = ["lag"] if is_late else drive.path.declared
        raise DataError(
            "the record does not show the command, as the control was logged behind the drive's "
            f"{' and '.join(passed)}."
        )
    if record.control is not None:
        return record.control
    if record.force is None or not drive.is_gain:
        raise DataError("the record has no control, and no force that is the control times a gain.")
    return record.force / float(drive.gain)
