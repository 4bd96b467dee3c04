"""A simulated closed loop, and its signals as regressors and logs have them."""

from dataclasses import dataclass, replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.signals import Signals, acting_along, drive_force, through_path
from axisid.modeling.declaration import Response
from axisid.support.arrays import Array, Exact

from .recorded import before


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
    law = axis.axis.control
    if law is not None and law.continuous:
        return simulation.signals, simulation.signals
    after, force = simulation.signals, simulation.force
    if not axis.axis.holds_force:
        force = mean_force(axis, simulation)
        after = _under(axis, parameters, simulation.signals, force)
    held = simulation.held
    if held is None:
        held = force_before(axis, simulation, force)
    earlier = replace(
        simulation.signals,
        direction=simulation.direction_before,
        recorded=before(axis, simulation.recorded),
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


def force_before(axis: GeneratedAxis, simulation: Simulation, mean: Array) -> Array:
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
