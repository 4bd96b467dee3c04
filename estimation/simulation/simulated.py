"""A simulated closed loop: where it starts, and its signals as regressors and logs have them."""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.estimation.signals import Signals, acting_along, drive_force, through_path
from axisid.modeling.declaration import Response
from axisid.support.arrays import Array, Exact

from .inputs import LoopInputs, axis_of, law_of


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Simulation(Exact):
    """A simulated closed loop, at the reference's samples, (N,) each, SI.

    Force, acceleration and friction direction are those just after the control was updated at the
    sample; with position and velocity they satisfy the model row by row.

    Attributes
    ----------
    time, position, velocity, acceleration, force : array
    control : array
        In the drive's unit.
    direction : array
        Friction direction: +1 or -1 while sliding, between them while stuck.
    direction_before : array
        The same just before the sample, under what was held until then.
    measured_position : array
        With the noise and the encoder resolution that were given.
    held : array or None
        Force just before each sample, where the law runs at a clock of its own; None where it is
        that of the sample before.
    recorded : tuple of array
        The recorded signals that the axis declares, in its order.
    """

    time: Array
    position: Array
    velocity: Array
    acceleration: Array
    force: Array
    control: Array
    direction: Array
    direction_before: Array
    measured_position: Array
    held: Array | None = None
    recorded: tuple[Array, ...] = ()

    @property
    def mode(self) -> Array:
        """+1 and -1 while sliding, 0 while stuck (at rest, and nothing to move it)."""
        stuck = (self.velocity == 0) & (self.acceleration == 0)
        return np.where(stuck, 0.0, self.direction)

    @property
    def signals(self) -> Signals:
        """What a regressor is made of, just after each sample."""
        return Signals(
            position=self.position,
            velocity=self.velocity,
            acceleration=self.acceleration,
            force=self.force,
            direction=self.direction,
            recorded=self.recorded,
        )


def measured_positions(
    position: Array | float, noise: Array | float | None, resolution: float
) -> Array:
    """Positions with their noise, as an encoder of a resolution has them; 0 for none."""
    measured = np.asarray(position if noise is None else position + noise)
    return np.floor(measured / resolution + 0.5) * resolution if resolution > 0 else measured


def signals_about(
    axis: GeneratedAxis, parameters: Array, simulation: Simulation
) -> tuple[Signals, Signals]:
    """Signals just after each sample and just before: the same motion under the force of each side.

    They satisfy the model row by row. A force that changes between samples stands by its mean over
    the period on each side. At the first sample, and for a continuous law, both are those after it.
    """
    if law_of(axis).continuous:
        return simulation.signals, simulation.signals
    after, force = simulation.signals, simulation.force
    if not axis.axis.holds_force:
        force = mean_force(axis, simulation)
        after = _under(axis, parameters, simulation.signals, force)
    held = simulation.held
    if held is None:
        held = _force_before(axis, simulation, force)
    earlier = replace(
        simulation.signals,
        direction=simulation.direction_before,
        recorded=tuple(
            _one_later(values) if declared.is_held else values
            for declared, values in zip(axis.axis.signals, simulation.recorded, strict=True)
        ),
    )
    return after, _under(axis, parameters, earlier, held)


def _under(axis: GeneratedAxis, parameters: Array, signals: Signals, force: Array) -> Signals:
    """The same motion under another force."""
    motion = (signals.position, signals.velocity, force, signals.direction)
    (acceleration,) = axis.evaluate("direct_dynamics", *motion, *signals.recorded, parameters)
    return replace(signals, force=force, acceleration=acceleration[:, 0])


def mean_force(axis: GeneratedAxis, simulation: Simulation) -> Array:
    """The drive's force in the mean from each sample of a simulation to the next, (N,).

    Where it follows the motion, that of the mean control along the motion at the sample.
    """
    response, s = axis.axis.response, simulation
    if response is None:
        return s.force
    if response.holds_control:
        motion = s.position, s.velocity, s.direction
        mean = acting_along(_acting(axis, s, response), response).mean
        return axis.force_in_mode(mean, *motion, s.recorded)
    position, velocity = s.position, s.velocity
    if response.by_motion:
        half = response.period / 2
        position, velocity = position + half * velocity, velocity + half * s.acceleration
    made = drive_force(axis, _acting(axis, s, response), position, velocity, s.recorded)
    return acting_along(made, response, start=float(s.force[0])).mean


def _force_before(axis: GeneratedAxis, simulation: Simulation, mean: Array) -> Array:
    """The force just before each sample, (N,), from that in the mean after it."""
    response, s = axis.axis.response, simulation
    if response is None or not response.holds_control:
        return _one_later(mean)
    motion = s.position, s.velocity, s.direction_before
    control = acting_along(_acting(axis, s, response), response).mean
    return axis.force_in_mode(_one_later(control), *motion, s.recorded)


def logged_control(axis: GeneratedAxis, simulation: Simulation) -> Array:
    """The control of a simulation where the axis's records have it, (N,)."""
    drive, response, law = axis.axis.drive, axis.axis.response, axis.axis.control
    if law is None or not drive.logs_what_acts:
        return simulation.control
    if drive.logged == "current":
        motion = (simulation.force, simulation.position, simulation.velocity)
        return axis.evaluate("drive_control", *motion, *simulation.recorded)[0][:, 0]
    late = 0 if response is None else response.late
    control = through_path(drive.path, simulation.control, law.period)
    return np.concatenate([np.repeat(control[:1], late), control])[: len(control)]


def _acting(axis: GeneratedAxis, simulation: Simulation, response: Response) -> Array:
    """The controls as the drive lets them act, before its delay and lag, (N,)."""
    return through_path(axis.axis.drive.path, simulation.control, response.period)


def _one_later(values: Array) -> Array:
    return np.concatenate([values[:1], values[:-1]])


_STEPS = 20  # of Newton's method; a law that is linear in its memory takes one
_CLOSE = 1e-14  # of the control


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
    found = [loop_start(axis_of(axis, own), theta, own).memory for own, theta in alone]
    return replace(starts, memory=np.array(found))


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
    law = _balance(axis, state[:count], signals, path.command(wanted))
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
