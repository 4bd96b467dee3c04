"""Signals of a simulated closed loop for regressors and logs, and its initial state."""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.estimation.signals import (
    Signals,
    commands_as_logged,
    drive_force,
    lagged_force,
    through_path,
)
from axisid.support.arrays import Array

from .loop_inputs import LoopInputs, axis_of, law_of


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Simulation(Signals):
    """Signals of a simulated closed loop at the reference's samples, (N,) each, SI.

    Position, velocity, acceleration, force, friction direction (+1 or -1 while sliding, between
    them while stuck) and recorded signals are those just after the update of the control at the
    sample, and satisfy the model in each row.

    Attributes
    ----------
    time : array
        Times of the samples, s.
    control : array
        In the drive's unit.
    direction_before : array
        Friction direction just before the sample, under the previous control.
    measured_position : array
        Position with the given noise and encoder resolution.
    held : array or None
        Force just before each sample if the law and the log have different periods; None if it is
        the force of the sample before.
    """

    time: Array
    control: Array
    direction_before: Array
    measured_position: Array
    held: Array | None = None

    @property
    def mode(self) -> Array:
        """Friction mode: +1 and -1 while sliding, 0 while stuck (no velocity or acceleration)."""
        stuck = (self.velocity == 0) & (self.acceleration == 0)
        return np.where(stuck, 0.0, self.direction)

    @property
    def signals(self) -> Signals:
        """Signals of the regressor just after each sample."""
        return self


def measured_positions(
    position: Array | float, noise: Array | float | None, resolution: float
) -> Array:
    """Return positions plus noise, rounded to the encoder resolution.

    Without noise if `noise` is None; not rounded if the resolution is 0.
    """
    measured = np.asarray(position if noise is None else position + noise)
    return np.floor(measured / resolution + 0.5) * resolution if resolution > 0 else measured


def signals_about(
    axis: GeneratedAxis, parameters: Array, simulation: Simulation
) -> tuple[Signals, Signals]:
    """Return the signals just after and just before each sample.

    Both have the motion of the simulation, with the force and the acceleration just after or just
    before the sample, and satisfy the model in each row. A force that changes between samples is
    represented by its mean over the period after or before the sample. At the first sample, and for
    a continuous law, both are the signals after the sample.
    """
    if law_of(axis).continuous:
        return simulation.signals, simulation.signals
    after, (mean, before) = simulation.signals, forces_about(axis, simulation)
    if not axis.holds_force:
        after = _with_force(axis, parameters, after, mean)
    earlier = replace(
        simulation.signals,
        direction=simulation.direction_before,
        recorded=tuple(
            _one_later(values) if declared.is_held else values
            for declared, values in zip(axis.signals, simulation.recorded, strict=True)
        ),
    )
    force = before if simulation.held is None else simulation.held
    return after, _with_force(axis, parameters, earlier, force)


def _with_force(axis: GeneratedAxis, parameters: Array, signals: Signals, force: Array) -> Signals:
    """Return the signals with another force, and the acceleration that it causes."""
    motion = (signals.position, signals.velocity, force, signals.direction)
    (acceleration,) = axis.evaluate("direct_dynamics", *motion, *signals.recorded, parameters)
    return replace(signals, force=force, acceleration=acceleration[:, 0])


def forces_about(axis: GeneratedAxis, simulation: Simulation) -> tuple[Array, Array]:
    """Return the mean force from each sample to the next, and the force just before each sample.

    The shape is (N,) each. For a drive that holds its control and whose force depends on the
    motion, the mean force is that of the mean control, with the motion at the sample; the force
    before a sample is that of the mean control since the sample before, with the motion at the
    sample itself.
    """
    response, s = axis.response, simulation
    if response is None:
        return s.force, _one_later(s.force)
    acting = through_path(axis.drive.path, s.control, response.period)
    # The drive filters its control, and the force follows the motion.
    if response.holds_control:
        control = lagged_force(acting, response).mean
        sides = ((control, s.direction), (_one_later(control), s.direction_before))
        mean, before = (
            axis.force_in_mode(each, s.position, s.velocity, direction, s.recorded)
            for each, direction in sides
        )
        return mean, before
    # The drive filters its force; a force by the motion is that in the middle of the period.
    position, velocity = s.position, s.velocity
    if response.by_motion:
        half = response.period / 2
        position, velocity = position + half * velocity, velocity + half * s.acceleration
    force = drive_force(axis, acting, position, velocity, s.recorded)
    mean = lagged_force(force, response, start=float(s.force[0])).mean
    return mean, _one_later(s.force if axis.holds_force else mean)


def logged_control(axis: GeneratedAxis, simulation: Simulation) -> Array:
    """Return the control of a simulation as the axis's records log it, (N,)."""
    if axis.drive.logged == "current":
        motion = (simulation.force, simulation.position, simulation.velocity)
        return axis.evaluate("drive_control", *motion, *simulation.recorded)[0][:, 0]
    return commands_as_logged(axis, simulation.control)


def _one_later(values: Array) -> Array:
    """Return values delayed by one sample; the first value is repeated."""
    return np.concatenate([values[:1], values[:-1]])


_STEPS = 20  # steps of Newton's method; a law that is linear in its memory needs one
_CLOSE = 1e-14  # tolerance relative to the control


def loop_start(axis: GeneratedAxis, parameters: Array, inputs: LoopInputs) -> LoopStart:
    """Return the start of one loop with parameters (p,), in balance if the law declares a balance.

    In balance, the memory of law and drive is such that the control holds the axis at its start.
    The start is unchanged if its memory is given, or if the law does not declare a balance.
    """
    start, noise = inputs.start, inputs.noise
    if start.memory is not None or not law_of(axis).balanced:
        return start
    # The law's inputs at the start.
    off = 0.0 if noise is None else float(noise[0])
    place, speed = float(start.position), float(start.velocity)
    measured = float(measured_positions(place, off, inputs.resolution))
    recorded = tuple(map(float, inputs.first_signals))
    read = (float(inputs.reference[0]), measured, speed, *recorded)
    # Control whose force holds the axis, and the memory of the law that gives it.
    force, control = axis.functions["inverse_dynamics"], axis.functions["drive_control"]
    holding_force = force(place, speed, 0.0, np.sign(speed), *recorded, parameters)
    wanted = float(control(holding_force, place, speed, *recorded))
    state = axis.functions["control_start"](*read[:2], *recorded).full().ravel()
    response, path = axis.response, axis.drive.path
    count = len(state) - (0 if response is None else len(response.remembered))
    law = _balanced_memory(axis, state[:count], read, path.command(wanted))
    if response is None:
        return replace(start, memory=law)
    # Memory of the drive under the command of the law, which the drive may round or limit.
    command = float(_undelayed_control(axis)[0](*read, law))
    acting = path.end(command)
    actual = float(axis.functions["drive_force"](acting, place, speed, *recorded))
    last = [command] * path.is_limited
    forces = np.full(len(response.forces), acting if response.holds_control else actual)
    forces[len(forces) - response.keeps_force :] = actual
    return replace(start, memory=np.concatenate([law, last, forces]))


def lane_starts(axis: GeneratedAxis, parameters: Array, inputs: LoopInputs) -> LoopStart:
    """Return the start of each lane with parameters (B, p), see `loop_start`.

    Position and velocity are (B,), and a memory is (B, m).
    """
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


def _balanced_memory(
    axis: GeneratedAxis, state: Array, signals: tuple[float, ...], control: float
) -> Array:
    """Return the memory of a law, (m,), with which the law gives a wanted control.

    The memory is found by Newton's method from a given memory, with minimum-norm steps in the parts
    that are declared to start in balance. The control is as near to the wanted control as the law
    allows.

    Parameters
    ----------
    axis : GeneratedAxis
    state : (m,) array
        Memory of the law at rest: its declared memory, then its controls that are not yet applied.
    signals : tuple of float
        Reference, measured position, velocity, and recorded signals.
    control : float
        Wanted control, in the drive's unit.
    """
    law = law_of(axis)
    free, count = list(law.balanced), len(law.memory)
    computed, slopes = _undelayed_control(axis)
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
def _undelayed_control(axis: GeneratedAxis) -> tuple[Any, Any]:
    """Return two functions: the undelayed control of the law, and its derivatives by the memory.

    The arguments of both are the signals that the law reads, and its memory. The undelayed control
    of a delayed law is the newest control in its next memory.
    """
    law, function = law_of(axis), axis.functions["control_law"]
    names = function.name_in()
    output, row = ("next_state", len(law.memory)) if law.delay else ("control", 0)
    pair = function.factory("computed", names, [output, f"jac:{output}:state"])
    return (lambda *arguments: pair(*arguments)[0][row]), (
        lambda *arguments: pair(*arguments)[1][row, :]
    )
