"""Initial state of a record's loop: position, velocity, and the memory of the drive.

The memory of the drive is not logged, but the first controls show it: an integral that holds a
load, the last position of a moving axis. The memory is estimated by least squares from the first
controls; elements that the controls do not determine stay as the law declares them for an axis at
rest. All elements stay so if the declared memory explains the controls within the control error
that the law has anyway.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.estimation.records import Record
from axisid.estimation.signals import as_logged, drive_force, limit_in_log, recorded_signals
from axisid.estimation.simulation import law_of
from axisid.estimation.thresholds import LIMIT_TOLERANCE
from axisid.support.arrays import Array, least_squares_step, mask_of
from axisid.support.caching import cached_while_alive

from .initial_velocity import MIN_START_DISTANCE, first_coefficient, first_velocity
from .replay import (
    LawInputs,
    control_along,
    law_along,
    law_memory,
    law_ticks,
    slopes_along,
    state_at_rest,
    states_along,
)

_STEP = 1e-6  # of the reference's range, for the derivative

# control error relative to the control (rms) up to which the memory of an axis at rest is kept:
# less than half of the 0.24 % of the law on the EMPS record
_MIN_START_ERROR = 1e-3
# effect on the first controls relative to the largest, below which a memory stays as declared
MIN_MEMORY_EFFECT = 1e-3
# control error relative to that of the memory at rest, below which another memory is used: on twins
# at rest a wrong gain gives 0.5 and more; under a load or in motion the ratio is 0.04 at most, also
# with gains that are wrong by 10 to 50 %
_MAX_START_LEFT = 0.1

START_SAMPLES = 50  # first samples of the record that are used
_STEPS = 4  # steps of Newton's method; a law that is linear in its memory needs one
_LINEAR = 1e-9  # of the control: deviation from the linear prediction at which Newton's method ends


def loop_starts(axis: GeneratedAxis, record: Record, away: float = 0.0) -> tuple[LoopStart, ...]:
    """Return the start of the loop of each segment of a record.

    Parameters
    ----------
    axis : GeneratedAxis
        Axis with a control law.
    record : Record
        Record with a reference.
    away : float
        Offset of the positions that the law reads from those of the record; positions in the law's
        memory are shifted as well.
    """
    starts = tuple(_start(axis, record, span) for span in record.spans)
    if not away:
        return starts
    reference = np.asarray(record.commanded)
    signals = recorded_signals(axis, record.provenance.source, record.signals)
    return tuple(
        shifted_start(axis, start, float(reference[row]), [float(v[row]) for v in signals], away)
        for (row, _), start in zip(record.spans, starts, strict=True)
    )


def shifted_start(
    axis: GeneratedAxis, start: LoopStart, reference: float, first: Sequence[float], away: float
) -> LoopStart:
    """Return a start with the positions in the law's memory shifted by an offset.

    The shift of the memory is that of an axis at rest when reference and position are shifted. A
    start without a memory is returned unchanged.

    Parameters
    ----------
    axis : GeneratedAxis
    start : LoopStart
    reference : float
        First reference of the segment.
    first : sequence of float
        First values of the recorded signals in the segment.
    away : float
        Offset of the positions that the law reads from those of the axis.
    """
    if start.memory is None:
        return start
    at_rest, position = axis.functions["control_start"], start.position
    change = at_rest(reference + away, position + away, *first)
    change -= at_rest(reference, position, *first)
    return replace(start, memory=start.memory + change.full().ravel())


@cached_while_alive
def _start(axis: GeneratedAxis, record: Record, span: tuple[int, int]) -> LoopStart:
    """Return the start of the loop of one segment: position, velocity and memory.

    The memory contains that of the law, its delay and the drive.
    """
    rows = slice(*span)
    if not record.integrated:
        velocity = first_velocity(record.position[rows], record.period)
    else:
        # Measured velocities are fitted by a straight line.
        velocity = first_coefficient(np.asarray(record.velocity)[rows], degree=1, power=0)
    record = as_read_by_law(axis, record, span)
    start = LoopStart(
        position=float(record.position[span[0]]),
        velocity=velocity,
        memory=first_memory(axis, record, span),
    )
    return with_drive_memory(axis, record, span, start)


def as_read_by_law(axis: GeneratedAxis, record: Record, span: tuple[int, int]) -> Record:
    """Return a record whose integrated position has the offset that its first controls show.

    The position of a record of velocity alone is an integral with an unknown constant, while the
    law read a position with its own zero. The offset is estimated by least squares from the effect
    of a shifted position on the first controls. Records with a measured position are unchanged, and
    so are records whose controls do not determine the offset significantly.
    """
    if not record.integrated or record.control is None:
        return record
    law, control = law_of(axis), np.asarray(record.control)[slice(*span)]
    ticks = law_ticks(axis, record, span).first(START_SAMPLES)
    seen = unlimited(axis, record, span)[: len(ticks.held)]
    wanted = control[: len(ticks.held)] - as_logged(axis, ticks.added_at_samples(law.delay))
    step = _STEP * float(np.ptp(np.asarray(record.reference))) or _STEP
    there = replace(ticks, position=ticks.position + step)
    given, moved = (control_along(axis, at, state_at_rest(axis, at)) for at in (ticks, there))
    slope, off = ((moved - given) / step)[seen], (wanted - given)[seen]
    power = float(slope @ slope)
    if not (np.isfinite(power) and power > 0 and np.all(np.isfinite(off))):
        return record
    away = float(slope @ off) / power
    left = off - away * slope
    deviation = float(np.sqrt(left @ left / max(len(off) - 1, 1) / power))
    is_clear = abs(away) > MIN_START_DISTANCE * deviation
    return replace(record, position=record.position + away) if is_clear else record


def start_of_law(
    axis: GeneratedAxis, record: Record, span: tuple[int, int], ticks: LawInputs
) -> Array:
    """Return the memory of law and delay at the start of a segment, (m,).

    It is estimated from the first controls where they show it; otherwise it is the declared memory
    of an axis at rest. `ticks` has the inputs of the law along the segment.
    """
    found = first_memory(axis, record, span, ticks)
    return state_at_rest(axis, ticks) if found is None else found


def first_memory(
    axis: GeneratedAxis, record: Record, span: tuple[int, int], ticks: LawInputs | None = None
) -> Array | None:
    """Estimate the memory of law and delay at the first sample of a segment, (m,).

    First the memory of an axis at rest is tried: if it explains the first controls, nothing is
    estimated. Otherwise the memory is found by Newton's method, also from the memory of an axis in
    motion where controls are at the drive's limit. It is used if it explains nearly all of the
    control error and is significant.

    Parameters
    ----------
    axis : GeneratedAxis
        Axis with a control law.
    record : Record
        Record with a reference.
    span : tuple of int
        The segment: first row and the one after the last.
    ticks : LawInputs, optional
        Inputs of the law along the segment; by default from the record.

    Returns
    -------
    (m,) array or None
        None for the declared memory of an axis at rest, or if there is no control to estimate from.
    """
    if record.control is None or not law_memory(axis):
        return None
    law = law_of(axis)
    control = record.control[slice(*span)]
    ticks = (ticks or law_ticks(axis, record, span)).first(START_SAMPLES)
    wanted = control[: len(ticks.held)] - as_logged(axis, ticks.added_at_samples(law.delay))
    seen = unlimited(axis, record, span)[: len(wanted)]
    at_rest = state_at_rest(axis, ticks)
    made = control_along(axis, ticks, at_rest)
    off = wanted - made
    if not law.balanced and not at_rest_misses(off, seen, float(np.mean(control**2))):
        return None
    found = _solved(axis, ticks, wanted, seen, at_rest)
    if np.any(seen & ~below_limit(axis, made)):  # at the limit, controls have no derivative
        moving = _solved(axis, ticks, wanted, seen, _state_in_motion(axis, ticks))
        found = min(found, moving, key=lambda each: float(np.linalg.norm(each[1])))
    off, (memory, missed, shown) = off[seen], found
    left, noise = float(np.linalg.norm(missed)), float(missed @ missed)
    gained = (float(off @ off) - noise) / max(shown, 1)
    noise /= max(len(off) - shown, 1)
    explained = left < _MAX_START_LEFT * float(np.linalg.norm(off))
    if law.balanced or (explained and gained > MIN_START_DISTANCE**2 * noise):
        return memory
    return None


def law_residual(
    axis: GeneratedAxis, record: Record, span: tuple[int, int]
) -> tuple[Array, NDArray[np.bool_]]:
    """Return the control error of the law along a segment, and the samples where it is valid.

    Returns
    -------
    (N,) array
        Recorded control minus the control of the law for the recorded signals, in the unit of the
        control; 0 in samples that are not valid.
    (N,) array of bool
        True for valid samples: not masked, and with a control below the drive's limit.
    """
    record = as_read_by_law(axis, record, span)
    ticks, seen = law_ticks(axis, record, span), unlimited(axis, record, span)
    made = law_along(axis, ticks, start_of_law(axis, record, span, ticks))
    made = made + as_logged(axis, ticks.added_at_samples(law_of(axis).delay))
    return np.where(seen, np.asarray(record.control)[slice(*span)] - made, 0.0), seen


def at_rest_misses(
    off: Array, seen: NDArray[np.bool_], power: float | Array
) -> np.bool_ | NDArray[np.bool_]:
    """Return True if the memory of an axis at rest does not explain the first controls.

    This is so if the control error exceeds 0.1 % of the control (rms).

    Parameters
    ----------
    off : (n,) or (n, L) array
        Control error with the memory of an axis at rest; a column for each of L loops that are
        simulated side by side.
    seen : (n,) or (n, L) array of bool
        True for valid samples.
    power : float or (L,) array
        Mean square of the control.

    Returns
    -------
    bool or (L,) array of bool
        One value for each loop.
    """
    left = np.sqrt(np.sum(np.where(seen, off, 0.0) ** 2, axis=0))
    least = _MIN_START_ERROR * np.sqrt(power * seen.sum(axis=0))
    return np.asarray(left > least)[()]


def below_limit(axis: GeneratedAxis, control: Array) -> NDArray[np.bool_]:
    """Return True for each control, (N,), whose size is below the drive's limit."""
    return np.abs(control) < limit_in_log(axis) * (1 - LIMIT_TOLERANCE.value)


def unlimited(axis: GeneratedAxis, record: Record, span: tuple[int, int]) -> NDArray[np.bool_]:
    """Return True for samples of a segment that are not masked nor at the drive's limit, (N,)."""
    rows = slice(*span)
    masked = mask_of(record.masked, len(record))[rows]
    return np.asarray(~masked & below_limit(axis, np.asarray(record.control)[rows]))


def _state_in_motion(axis: GeneratedAxis, ticks: LawInputs) -> Array:
    """Return the memory of law and delay that a motion at constant velocity has left, (m,).

    The motion is that of the first samples, extrapolated to the time before the first evaluation.

    For a law that differences positions, a motion that starts at once from rest is a jump: its
    control is then at the drive's limit for any other memory.
    """
    before = np.arange(-len(ticks), 0)

    def led(values: Array) -> Array:
        """Return values extrapolated linearly to the time before the first evaluation."""
        slope = (values[-1] - values[0]) / max(len(values) - 1, 1)
        return np.append(values[0] + slope * before, values[0])

    # Inputs of the law during the motion before the record.
    way = LawInputs.at_samples(
        led(ticks.reference),
        led(ticks.position),
        np.full(len(before) + 1, ticks.velocity[0]),
        tuple(np.full(len(before) + 1, values[0]) for values in ticks.recorded),
    )
    return np.asarray(states_along(axis, way, state_at_rest(axis, way))[-1])


def _solved(
    axis: GeneratedAxis, ticks: LawInputs, wanted: Array, seen: NDArray[np.bool_], state: Array
) -> tuple[Array, Array, int]:
    """Estimate the memory of law and delay from the controls by Newton's method.

    Parameters
    ----------
    axis : GeneratedAxis
    ticks : LawInputs
        Inputs of the law in the first n samples.
    wanted : (n,) array
        Recorded control without the added test signal.
    seen : (n,) array of bool
        True for valid samples.
    state : (m,) array
        Memory from which Newton's method starts.

    Returns
    -------
    (m,) array
        Memory.
    (n,) array
        Control error with it.
    int
        Number of directions of the memory that the controls determine.
    """
    off, shown = (wanted - control_along(axis, ticks, state))[seen], 0
    for _ in range(_STEPS):
        slopes = slopes_along(axis, ticks, state)[seen]
        if not (np.all(np.isfinite(off)) and np.all(np.isfinite(slopes))):
            break
        step, shown = least_squares_step(slopes, off, MIN_MEMORY_EFFECT)
        state, expected = state + step, off - slopes @ step
        off = (wanted - control_along(axis, ticks, state))[seen]
        if np.linalg.norm(off - expected) <= _LINEAR * np.linalg.norm(wanted):
            break
    return state, off, shown


def with_drive_memory(
    axis: GeneratedAxis, record: Record, span: tuple[int, int], start: LoopStart
) -> LoopStart:
    """Return a start whose memory also has the state of the drive, from the first controls.

    The state of the drive has the commands that are still pending in its delay, and its force.
    Before the record, the drive is assumed to have received the first control. A drive without
    delay and lag leaves the start unchanged.

    Parameters
    ----------
    axis : GeneratedAxis
    record : Record
    span : tuple of int
        The segment: first row and the one after the last.
    start : LoopStart
        Start with the memory of the law, or with None for that of an axis at rest.
    """
    response, first = axis.response, span[0]
    if response is None:
        return start
    signals, memory = recorded_signals(axis, record.provenance.source, record.signals), start.memory
    if memory is None:
        reference = start.position if record.commanded is None else record.commanded[first]
        read = reference, start.position, *(values[first] for values in signals)
        memory = axis.functions["control_start"](*read).full().ravel()
        if record.control is None:
            return replace(start, memory=memory)
        memory = memory[: -len(response.remembered)]
    late = response.late if axis.drive.logged == "applied" else 0
    # The newest first; commands before the record, and the present force, are those of the first
    # control in the record.
    ahead = np.maximum(late - 1 - np.arange(len(response.forces)), 0)
    ahead[len(ahead) - response.keeps_force :] = 0
    rows = np.minimum(first + ahead, span[1] - 1)
    controls, path = np.asarray(record.control)[rows], axis.drive.path
    # Commands of the control, and the forces that they make at the initial position and velocity.
    last = float(np.asarray(record.control)[first])
    if axis.drive.logs_what_acts:
        last = path.command(last)
    else:
        controls = np.array([path.end(float(each)) for each in controls])
    motion = np.full(len(rows), start.position), np.full(len(rows), start.velocity)
    forces = drive_force(axis, controls, *motion, tuple(values[rows] for values in signals))
    pending = np.append(controls[:-1], forces[-1]) if response.holds_control else forces
    return replace(start, memory=np.concatenate([memory, [last] * path.is_limited, pending]))
