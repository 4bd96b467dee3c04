"""Where simulated loops start: as they are told, or in balance where their law says so."""

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.support.arrays import Array

from .loop_inputs import LoopInputs, axis_of, law_of
from .simulated_signals import measured_positions

_STEPS = 20  # of Newton's method; a law that is linear in its memory takes one
_CLOSE = 1e-14  # of the control


def loop_start(axis: GeneratedAxis, parameters: Array, inputs: LoopInputs) -> LoopStart:
    """Where one loop with parameters (p,) starts: in balance where its law says so.

    Then the drive remembers what it does when its control holds the axis there.
    """
    start, noise = inputs.start, inputs.noise
    if start.memory is not None or not law_of(axis).balanced:
        return start
    off = 0.0 if noise is None else float(noise[0])
    place, speed = float(start.position), float(start.velocity)
    measured = float(measured_positions(place, off, inputs.resolution))
    recorded = tuple(map(float, inputs.first_signals))
    read = (float(inputs.reference[0]), measured, speed, *recorded)
    force, control = axis.functions["inverse_dynamics"], axis.functions["drive_control"]
    needed = force(place, speed, 0.0, np.sign(speed), *recorded, parameters)
    wanted = float(control(needed, place, speed, *recorded))
    state = axis.functions["control_start"](*read[:2], *recorded).full().ravel()
    response, path = axis.axis.response, axis.axis.drive.path
    count = len(state) - (0 if response is None else len(response.remembered))
    law = _balance(axis, state[:count], read, path.command(wanted))
    if response is None:
        return replace(start, memory=law)
    # The drive has what comes of the law's command, which may be rounded or limited.
    command = float(_computed(axis)[0](*read, law))
    acting = path.end(command)
    actual = float(axis.functions["drive_force"](acting, place, speed, *recorded))
    last = [command] * path.is_limited
    forces = np.full(len(response.forces), acting if response.holds_control else actual)
    forces[len(forces) - response.keeps_force :] = actual
    return replace(start, memory=np.concatenate([law, last, forces]))


def lane_starts(axis: GeneratedAxis, parameters: Array, inputs: LoopInputs) -> LoopStart:
    """The same of lanes with parameters (B, p)."""
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
    every = replace(inputs, start=starts, log=None)
    alone = zip(map(every.lanes, range(lanes)), parameters, strict=True)
    memories = [loop_start(axis_of(axis, lane), theta, lane).memory for lane, theta in alone]
    return replace(starts, memory=np.array(memories))


def _balance(
    axis: GeneratedAxis, state: Array, signals: tuple[float, ...], control: float
) -> Array:
    """Change the memories (m,) that start in balance, by the least, for the law to give a control.

    Signals are reference, measured position and velocity, and recorded ones; it is as near as the
    law comes to it.
    """
    law = law_of(axis)
    free, count = list(law.balanced), len(law.memory)
    computed, slopes = _computed(axis)
    state = state.copy()
    for _ in range(_STEPS):
        residual = control - float(computed(*signals, state))
        if abs(residual) <= _CLOSE * abs(control):
            break
        gradient = slopes(*signals, state).full().ravel()[free]
        size = float(gradient @ gradient)
        if not 0 < size < math.inf:
            break
        state[free] += residual / size * gradient
    if law.delay:
        state[count:] = float(computed(*signals, state))
    return state


@lru_cache(maxsize=32)
def _computed(axis: GeneratedAxis) -> tuple[Any, Any]:
    """The control that the law computes, whatever its delay, and its slopes by the state."""
    law, function = law_of(axis), axis.functions["control_law"]
    names = function.name_in()
    output, row = ("next_state", len(law.memory)) if law.delay else ("control", 0)
    pair = function.factory("computed", names, [output, f"jac:{output}:state"])
    return (lambda *arguments: pair(*arguments)[0][row]), (
        lambda *arguments: pair(*arguments)[1][row, :]
    )
