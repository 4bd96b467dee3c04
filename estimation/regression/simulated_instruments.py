"""Rows of the regression as the simulated loop has them: instruments, and the model's left side.

Where the reference is not known, what the axis got is known all the same: its control was recorded.
Simulated with that alone the axis would drift away, so that the law holds it: its reference is the
recorded position, and what it made of that position is taken off the recorded control. The axis so
gets the recorded control, and the law's answer to where it departs from the record. Where the law
is the drive's, and measures what was recorded, this is the loop as it was but for the noise,
whatever its reference was: the noise in the recorded control is taken off with the rest.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.estimation.choices import OPEN_LOOP_FIT
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
from axisid.support.errors import AxisidError, DataError, ModelError, refuse

from .inverse_and_direct import Equations, Form


class LoopDataError(DataError):
    """The record does not serve to simulate the loop."""


_WITHOUT = (
    " Least squares does without, and so does a fit of the position under the "
    f"recorded control: {OPEN_LOOP_FIT}."
)


def lacking_loop(axis: GeneratedAxis, record: Record) -> AxisidError | None:
    """Why there is no closed loop to simulate: the axis has no law, or the record no reference."""
    if axis.control is None:
        return lacking_law(axis)
    return (
        None
        if record.commanded is not None
        else LoopDataError(
            f"{record.provenance.source} has no reference column, from which the closed loop "
            f"is simulated; name it with columns reference=NAME.{_WITHOUT}",
            code="missing-column",
        )
    )


def lacking_law(axis: GeneratedAxis) -> ModelError:
    """The error of an axis whose records' loop cannot be simulated, with what does without."""
    error = no_control_law(axis.name)
    return ModelError(f"{error}{_WITHOUT}", code=error.code)


@cached_while_alive
def loop_reference(axis: GeneratedAxis, record: Record) -> Array:
    """Reference of a loop that was both declared and recorded, (N,); anything less is refused.

    A test signal that was added to it is in it.

    Raises
    ------
    ModelError
        The axis has no control law.
    LoopDataError
        The record has no reference, or another period than the law, which nobody confirms.
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
    """The loop of a record, simulated with physical parameters (p,): once for each segment.

    Each begins as its segment does, see `loop_starts`, unless starts are given. With a resolution
    it has an encoder of such steps, which measures, and is commanded, positions that are `away`
    from those of the axis; and what its law measures has `position_noise`, (N,), if there is any; a
    `disturbance`, (N,), in the drive's unit, acts beside the control. A budget is that of a search.

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
    """Position of the loops, one after the other, (N,)."""
    return np.concatenate([loop.position for loop in loops])


def simulated_rows(
    form: Form, loops: Sequence[Simulation], physical: Array, data: FilteredRecord
) -> Equations:
    """The rows of simulated loops, reduced like the measured ones."""
    pieces = [loop_equations(form, loop, physical, data.prefilter.hold) for loop in loops]
    return Equations.stacked(pieces).reduced(data)


def loop_equations(form: Form, loop: Simulation, physical: Array, hold: str | None) -> Equations:
    """The equations of a simulated loop, sample by sample, as a hold pairs force and motion.

    With `zoh`, the rows just before and just after a sample are averaged, as the measured force is.
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
    law, record = data.axis.control, data.record
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
    law = data.axis.control
    if law is None:
        raise no_control_law(data.axis.name)
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
    record, drive = data.record, data.axis.drive
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
