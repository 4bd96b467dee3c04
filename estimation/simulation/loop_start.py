"""Where a simulated loop starts: its motion, and what its drive remembers."""

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.modeling.declaration import ControlLaw
from axisid.support.arrays import Array
from axisid.support.errors import UsageError
from axisid.support.real_numbers import is_real
from axisid.support.user_values import quoted

from .inputs import LoopInputs
from .lane_arguments import axes_by_gains, checked_array
from .simulated import measured_positions

_STEPS = 20  # of Newton's method; a law that is linear in its memory takes one
_CLOSE = 1e-14  # of the control


def checked_start(
    axis: GeneratedAxis, position: float, velocity: float, memory: ArrayLike | None
) -> LoopStart:
    """Where one simulation is to start, as `simulate` takes it.

    Raises
    ------
    UsageError
        A value is no finite number, or the memory has another length.
    """
    for value, what in ((position, "start"), (velocity, "start velocity")):
        if not (is_real(value) and math.isfinite(value)):
            kind = "position" if what == "start" else "velocity"
            raise UsageError(
                f"the {what} is {quoted(value)}; give a {kind}, or leave it out.",
                code="simulation-start",
            )
    return LoopStart(
        position=float(position),
        velocity=float(velocity),
        memory=_remembered(axis, memory, None),
    )


def checked_starts(
    axis: GeneratedAxis,
    position: ArrayLike,
    velocity: ArrayLike | None,
    memory: ArrayLike | None,
    lanes: int,
) -> LoopStart:
    """The same of the lanes of a batch: (B,), memory (B, m)."""
    moving = np.zeros(lanes) if velocity is None else velocity
    return LoopStart(
        position=np.ascontiguousarray(checked_array(position, "the start", [(lanes,)])),
        velocity=np.ascontiguousarray(checked_array(moving, "the start velocity", [(lanes,)])),
        memory=_remembered(axis, memory, lanes),
    )


def loop_start(axis: GeneratedAxis, parameters: Array, inputs: LoopInputs) -> LoopStart:
    """Where one loop with parameters (p,) starts: in balance where its law says so."""
    start, noise = inputs.start, inputs.noise
    if start.memory is not None or not law_of(axis).balanced:
        return start
    off = 0.0 if noise is None else float(noise[0])
    measured = float(measured_positions(start.position, off, inputs.resolution))
    read = (float(inputs.reference[0]), measured, *map(float, inputs.first_signals))
    motion = float(start.position), float(start.velocity)
    return replace(start, memory=balanced_memory(axis, parameters, *motion, *read))


def lane_starts(
    axis: GeneratedAxis, parameters: Array, inputs: LoopInputs, gains: Array | None
) -> LoopStart:
    """The same of lanes with parameters (B, p), and gains of the law (B, g) if they have own."""
    lanes, start = len(parameters), inputs.start
    memory = start.memory
    if memory is not None:
        memory = np.ascontiguousarray(np.broadcast_to(memory, (lanes, memory.shape[-1])))
    starts = LoopStart(
        position=np.ascontiguousarray(np.broadcast_to(start.position, lanes)),
        velocity=np.ascontiguousarray(np.broadcast_to(start.velocity, lanes)),
        memory=memory,
    )
    if memory is not None or not law_of(axis).balanced:
        return starts
    every, owners = replace(inputs, start=starts, log=None), axes_by_gains(axis, gains, lanes)
    alone = (
        loop_start(own, theta, every.lanes(lane))
        for lane, (own, theta) in enumerate(zip(owners, parameters, strict=True))
    )
    return replace(starts, memory=np.array([each.memory for each in alone]))


def law_of(axis: GeneratedAxis) -> ControlLaw:
    """The control law of an axis that is known to have one."""
    law = axis.axis.control
    assert law is not None  # noqa: S101  # whoever asks has refused an axis without one
    return law


def _remembered(axis: GeneratedAxis, memory: ArrayLike | None, lanes: int | None) -> Array | None:
    """What is given of the memory, (m,) or (B, m)."""
    if memory is None:
        return None
    law = law_of(axis)
    response = axis.axis.response
    drive = () if response is None else response.remembered
    names = [*(each.name for each in law.memory), *law.delay_line, *drive]
    shape = (len(names),) if lanes is None else (lanes, len(names))
    what = f"the memory ({', '.join(names) or 'the law remembers nothing'})"
    return np.ascontiguousarray(checked_array(memory, what, [shape]))


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
