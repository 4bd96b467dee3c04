"""Initial state of a record's loop: position, velocity, and the memory of the drive.

The memory of the drive is not logged, but the first controls show it: an integral that holds a
load, the last position of a moving axis. The memory is estimated by least squares from the first
controls. Elements that the controls do not determine keep the values that the law declares for an
axis at rest. All elements keep these values if they explain the first controls within 0.1 % of the
control (rms), see `at_rest_misses`.
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
        Offset of the positions that the law reads from the positions of the record. Positions in
        the law's memory are shifted as well.
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

    The memory is shifted like the memory of an axis at rest whose reference and position are
    shifted. A start without a memory is returned unchanged.

    Parameters
    ----------
    axis : GeneratedAxis
    start : LoopStart
    reference : float
        First reference of the segment.
    first : sequence of float
        First values of the recorded signals in the segment.
    away : float
        Offset of the positions that the law reads from the positions of the axis.
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

    The memory has the states of the law, of its delay and of the drive.
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
    # First controls of the record, and of the law without and with a small offset.
    law, control = law_of(axis), np.asarray(record.control)[slice(*span)]
    ticks = law_ticks(axis, record, span).first(START_SAMPLES)
    is_valid = unlimited(axis, record, span)[: len(ticks.held)]
    wanted = control[: len(ticks.held)] - as_logged(axis, ticks.added_at_samples(law.delay))
    step = _STEP * float(np.ptp(np.asarray(record.reference))) or _STEP
    shifted = replace(ticks, position=ticks.position + step)
    before, after = (control_along(axis, at, state_at_rest(axis, at)) for at in (ticks, shifted))
    # Regress the control error on the derivative of the control by the offset.
    slope, error = ((after - before) / step)[is_valid], (wanted - before)[is_valid]
    power = float(slope @ slope)
    if not (np.isfinite(power) and power > 0 and np.all(np.isfinite(error))):
        return record
    offset = float(slope @ error) / power
    residuals = error - offset * slope
    deviation = float(np.sqrt(residuals @ residuals / max(len(error) - 1, 1) / power))
    if abs(offset) > MIN_START_DISTANCE * deviation:
        return replace(record, position=record.position + offset)
    return record


def start_of_law(
    axis: GeneratedAxis, record: Record, span: tuple[int, int], ticks: LawInputs
) -> Array:
    """Return the memory of law and delay at the start of a segment, (m,).

    It is estimated from the first controls. If they do not determine it, it is the declared memory
    of an axis at rest. `ticks` has the inputs of the law along the segment.
    """
    found = first_memory(axis, record, span, ticks)
    return state_at_rest(axis, ticks) if found is None else found


def first_memory(
    axis: GeneratedAxis, record: Record, span: tuple[int, int], ticks: LawInputs | None = None
) -> Array | None:
    """Estimate the memory of law and delay at the first sample of a segment, (m,).

    First the memory of an axis at rest is tried: if it explains the first controls, nothing is
    estimated. Otherwise the memory is found by Newton's method, which starts from the memory at
    rest. If controls of the law are at the drive's limit, a second search starts from the memory of
    an axis in motion, and the better result is taken. The result is used if it explains at least
    nine tenths of the control error and is significant. For a law with `balanced` elements of its
    memory it is always used.

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
    is_valid = unlimited(axis, record, span)[: len(wanted)]
    # The memory of an axis at rest.
    at_rest = state_at_rest(axis, ticks)
    control_at_rest = control_along(axis, ticks, at_rest)
    error_at_rest = wanted - control_at_rest
    if not law.balanced and not at_rest_misses(error_at_rest, is_valid, float(np.mean(control**2))):
        return None
    # Newton's method from one or two starts.
    found = _estimated_memory(axis, ticks, wanted, is_valid, at_rest)
    if np.any(is_valid & ~below_limit(axis, control_at_rest)):  # which have no derivative
        in_motion = _state_in_motion(axis, ticks)
        other = _estimated_memory(axis, ticks, wanted, is_valid, in_motion)
        found = min(found, other, key=lambda each: float(np.linalg.norm(each[1])))
    # Share of the control error that the estimated memory explains, and its significance.
    before, (memory, after, rank) = error_at_rest[is_valid], found
    remaining, noise = float(np.linalg.norm(after)), float(after @ after)
    gained = (float(before @ before) - noise) / max(rank, 1)
    noise /= max(len(before) - rank, 1)
    is_explained = remaining < _MAX_START_LEFT * float(np.linalg.norm(before))
    if law.balanced or (is_explained and gained > MIN_START_DISTANCE**2 * noise):
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
    ticks, is_valid = law_ticks(axis, record, span), unlimited(axis, record, span)
    expected = law_along(axis, ticks, start_of_law(axis, record, span, ticks))
    expected = expected + as_logged(axis, ticks.added_at_samples(law_of(axis).delay))
    control = np.asarray(record.control)[slice(*span)]
    return np.where(is_valid, control - expected, 0.0), is_valid


def at_rest_misses(
    off: Array, seen: NDArray[np.bool_], power: float | Array
) -> np.bool_ | NDArray[np.bool_]:
    """Return True if the memory of an axis at rest does not explain the first controls.

    The limit of the control error is 0.1 % of the control (rms).

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
    error = np.sqrt(np.sum(np.where(seen, off, 0.0) ** 2, axis=0))
    limit = _MIN_START_ERROR * np.sqrt(power * seen.sum(axis=0))
    return np.asarray(error > limit)[()]


def below_limit(axis: GeneratedAxis, control: Array) -> NDArray[np.bool_]:
    """Return True for each control whose size is below the drive's limit, in the shape given."""
    return np.abs(control) < limit_in_log(axis) * (1 - LIMIT_TOLERANCE.value)


def unlimited(axis: GeneratedAxis, record: Record, span: tuple[int, int]) -> NDArray[np.bool_]:
    """Return True for samples of a segment that are not masked nor at the drive's limit, (N,)."""
    rows = slice(*span)
    masked = mask_of(record.masked, len(record))[rows]
    return np.asarray(~masked & below_limit(axis, np.asarray(record.control)[rows]))


def _state_in_motion(axis: GeneratedAxis, ticks: LawInputs) -> Array:
    """Return the memory of law and delay after a motion at constant velocity, (m,).

    The motion of the first samples is extrapolated to the time before the first evaluation, and the
    law is run along it. A law that differences positions sees a motion that starts suddenly from
    rest as a jump: with the memory at rest, its control is at the drive's limit.
    """
    before = np.arange(-len(ticks), 0)

    def extrapolated(values: Array) -> Array:
        """Return values extrapolated linearly to the time before the first evaluation."""
        slope = (values[-1] - values[0]) / max(len(values) - 1, 1)
        return np.append(values[0] + slope * before, values[0])

    # Inputs of the law during the motion before the record.
    motion = LawInputs.at_samples(
        extrapolated(ticks.reference),
        extrapolated(ticks.position),
        np.full(len(before) + 1, ticks.velocity[0]),
        tuple(np.full(len(before) + 1, values[0]) for values in ticks.recorded),
    )
    return np.asarray(states_along(axis, motion, state_at_rest(axis, motion))[-1])


def _estimated_memory(
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
    array
        Control error with this memory in the valid samples.
    int
        Number of directions of the memory that the controls determine.
    """
    error, rank = (wanted - control_along(axis, ticks, state))[seen], 0
    for _ in range(_STEPS):
        slopes = slopes_along(axis, ticks, state)[seen]
        if not (np.all(np.isfinite(error)) and np.all(np.isfinite(slopes))):
            break
        step, rank = least_squares_step(slopes, error, MIN_MEMORY_EFFECT)
        state, expected = state + step, error - slopes @ step
        error = (wanted - control_along(axis, ticks, state))[seen]
        if np.linalg.norm(error - expected) <= _LINEAR * np.linalg.norm(wanted):
            break
    return state, error, rank


def with_drive_memory(
    axis: GeneratedAxis, record: Record, span: tuple[int, int], start: LoopStart
) -> LoopStart:
    """Return a start whose memory also has the state of the drive, from the first controls.

    The state of the drive consists of the commands that are still pending in its delay, and of its
    force. Before the record, the drive is assumed to have received the first control. The start is
    returned unchanged for a drive without delay and lag.

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
    # Memory of the law and its delay.
    signals, memory = recorded_signals(axis, record.provenance.source, record.signals), start.memory
    if memory is None:
        reference = start.position if record.commanded is None else record.commanded[first]
        read = reference, start.position, *(values[first] for values in signals)
        memory = axis.functions["control_start"](*read).full().ravel()
        if record.control is None:
            return replace(start, memory=memory)
        memory = memory[: -len(response.remembered)]
    # Rows of the record whose controls are pending, the newest first. For commands before the
    # record, and for the present force, it is the first row.
    late = response.late if axis.drive.logged == "applied" else 0
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
