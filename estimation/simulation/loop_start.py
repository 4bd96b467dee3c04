"""Where a simulated loop starts: its motion, and what its drive remembers."""

import math
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.modeling.declaration import ControlLaw
from axisid.support.arrays import Array
from axisid.support.errors import UsageError
from axisid.support.real_numbers import is_real, real_array
from axisid.support.user_values import quoted

from .lane_arguments import axes_by_gains
from .simulated import measured_positions

_STEPS = 20  # of Newton's method; a law that is linear in its memory takes one
_CLOSE = 1e-14  # of the control


def single_start(
    axis: GeneratedAxis,
    parameters: Array,
    reference: float,
    noise: float,
    resolution: float,
    start: float | None,
    velocity: float,
    memory: ArrayLike | None,
    recorded: Array,
) -> LoopStart:
    """Check where one simulation is to start, and find what balances.

    Parameters
    ----------
    axis : GeneratedAxis
        With a control law.
    parameters : (p,) array
    reference : float
        The first.
    noise, resolution : float
        Of the first measured position, and of the encoder.
    start, velocity, memory
        As `simulate` takes them.
    recorded : (s,) array
        The first of the recorded signals.
    """
    for value, what in ((start, "start"), (velocity, "start velocity")):
        if not (value is None or (is_real(value) and math.isfinite(value))):
            kind = "position" if what == "start" else "velocity"
            raise UsageError(
                f"the {what} is {quoted(value)}; give a {kind}, or leave it out.",
                code="simulation-start",
            )
    position = float(reference if start is None else start)
    remembered = _remembered(axis, memory, None)
    if remembered is None and law_of(axis).balanced:
        measured = float(measured_positions(position, noise, resolution))
        remembered = balanced_memory(
            axis, parameters, position, float(velocity), reference, measured, *recorded
        )
    return LoopStart(position=position, velocity=float(velocity), memory=remembered)


def lane_starts(
    axis: GeneratedAxis,
    parameters: Array,
    reference: Array,
    noise: Array,
    resolution: float,
    start: ArrayLike | None,
    velocity: ArrayLike | None,
    memory: ArrayLike | None,
    recorded: Array,
    gains: Array | None = None,
) -> LoopStart:
    """The same for the lanes of a batch: parameters (B, p), all others (B,), memory (B, m).

    Recorded signals are (s,) or (s, B), gains of the law (B, g) where each lane has its own.
    """
    lanes = len(parameters)
    first = np.broadcast_to(reference, lanes)
    position = _by_lane(first if start is None else start, lanes, "start", "position")
    still = np.zeros(lanes)
    moving = _by_lane(still if velocity is None else velocity, lanes, "start velocity", "velocity")
    remembered = _remembered(axis, memory, lanes)
    if remembered is None and law_of(axis).balanced:
        signals = [np.broadcast_to(values, lanes) for values in recorded]
        measured = measured_positions(position, noise, resolution)
        each = zip(parameters, position, moving, first, measured, *signals, strict=True)
        owners = axes_by_gains(axis, gains, lanes)
        pairs = zip(owners, each, strict=True)
        remembered = np.array([balanced_memory(own, *lane) for own, lane in pairs])
    return LoopStart(position=position, velocity=moving, memory=remembered)


def law_of(axis: GeneratedAxis) -> ControlLaw:
    """The control law of an axis that is known to have one."""
    law = axis.axis.control
    assert law is not None  # noqa: S101  # whoever asks has refused an axis without one
    return law


def _by_lane(values: ArrayLike, lanes: int, what: str, kind: str) -> Array:
    numbers = real_array(values, f"the {what}")
    if numbers.shape != (lanes,) or not np.all(np.isfinite(numbers)):
        raise UsageError(
            f"the {what} has the shape {numbers.shape}; give one {kind} a lane, all finite.",
            code="batch-start",
        )
    return np.ascontiguousarray(numbers)


def _remembered(axis: GeneratedAxis, memory: ArrayLike | None, lanes: int | None) -> Array | None:
    """What is given of the memory, (m,) or (B, m)."""
    if memory is None:
        return None
    law = law_of(axis)
    response = axis.axis.response
    drive = () if response is None else response.remembered
    names = [*(each.name for each in law.memory), *law.delay_line, *drive]
    shape = (len(names),) if lanes is None else (lanes, len(names))
    values = np.ascontiguousarray(real_array(memory, "the memory"))
    if values.shape != shape or not np.all(np.isfinite(values)):
        raise UsageError(
            f"the memory has the shape {values.shape}; give {shape} finite numbers: "
            f"{', '.join(names) or 'the law remembers nothing'}.",
            code="loop-memory",
        )
    return values


def balanced_memory(
    axis: GeneratedAxis,
    parameters: Array,
    position: float,
    velocity: float,
    reference: float,
    measured: float,
    *recorded: float,
) -> Array:
    """What the drive remembers when its control holds an axis where it starts, (m,)."""
    force, control = axis.functions["inverse_dynamics"], axis.functions["drive_control"]
    held = force(position, velocity, 0.0, np.sign(velocity), *recorded, parameters)
    state = axis.functions["control_start"](reference, measured, *recorded).full().ravel()
    wanted = float(control(held, position, velocity, *recorded))
    response, path = axis.axis.response, axis.axis.drive.path
    count = len(state) - (0 if response is None else len(response.remembered))
    signals = (reference, measured, velocity, *recorded)
    law = balance(axis, state[:count], signals, path.command(wanted))
    if response is None:
        return law
    # The drive has what comes of the law's command, which may be rounded or limited.
    command = float(_computed(axis)[0](*signals, law))
    acting = path.end(command)
    made = float(axis.functions["drive_force"](acting, position, velocity, *recorded))
    last = [command] * path.is_limited
    forces = np.full(len(response.forces), acting if response.holds_control else made)
    forces[len(forces) - response.keeps_force :] = made
    return np.concatenate([law, last, forces])


def balance(axis: GeneratedAxis, state: Array, signals: tuple[float, ...], control: float) -> Array:
    """Change the memories that start in balance, by the least, so that the law gives a control.

    Parameters
    ----------
    axis : GeneratedAxis
    state : (m,) array
        What the drive remembers otherwise.
    signals : tuple of float
        Reference, measured position and velocity, and recorded signals.
    control : float
        In the drive's unit.

    Returns
    -------
    (m,) array
        As near as the law comes to it.
    """
    law = law_of(axis)
    free, count = list(law.balanced), len(law.memory)
    computed, slopes = _computed(axis)
    state = state.copy()
    for _ in range(_STEPS):
        off = control - float(computed(*signals, state))
        if abs(off) <= _CLOSE * abs(control):
            break
        along = slopes(*signals, state).full().ravel()[free]
        size = float(along @ along)
        if not 0 < size < math.inf:
            break
        state[free] += off / size * along
    if law.delay:
        state[count:] = float(computed(*signals, state))
    return state


@lru_cache(maxsize=32)
def _computed(axis: GeneratedAxis) -> tuple[Any, Any]:
    """The control that the law computes, whatever its delay, and its slopes by the state."""
    law, function = law_of(axis), axis.functions["control_law"]
    names = function.name_in()
    if not law.delay:
        output, row = "control", 0
    else:
        output, row = "next_state", len(law.memory)
    pair = function.factory("computed", names, [output, f"jac:{output}:state"])
    return (lambda *arguments: pair(*arguments)[0][row]), (
        lambda *arguments: pair(*arguments)[1][row, :]
    )
