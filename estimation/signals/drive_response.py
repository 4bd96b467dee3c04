"""What a drive makes of commands, before they act and after, and what of that its log has.

What acts of a command is told by the drive's `CommandPath`. Commands are held, so that with a lag
the force between two samples is known exactly: it goes to that of a command by an exponential, and
a delay that is no whole samples changes the command in between.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.modeling.declaration import CommandPath, ControlLaw, Response
from axisid.support.arrays import Array

from .signals import Motion, drive_force


class Acting(NamedTuple):
    """The force that a drive makes, (N,) each.

    Attributes
    ----------
    at_samples : array
        Just after each sample.
    mean : array
        From each sample to the next.
    """

    at_samples: Array
    mean: Array


def through_path(path: CommandPath, commands: Array, period: float) -> Array:
    """The controls that act of commands within the limit, (N,); the first one acted before them.

    Parameters
    ----------
    path : CommandPath
    commands : (N,) array
        Of one stretch.
    period : float
        For which each is held, s.
    """
    acting, most = commands, path.rate_limit * period

    def follow(now: float, command: float) -> float:
        step = command - now
        return command if abs(step) <= most else now + math.copysign(most, step)

    if path.is_limited and len(commands):
        acting = np.array([*accumulate(commands.tolist(), follow)])
    if path.quantisation:
        acting = np.floor(acting * (1 / path.quantisation) + 0.5) * path.quantisation
    if path.deadband:
        acting = acting - np.clip(acting, -path.deadband, path.deadband)
    return acting


def acting_control(
    axis: GeneratedAxis, control: Array, starts: Sequence[int], period: float
) -> Array:
    """The control that acts of a recorded one, before a delay and a lag, (N,).

    Parameters
    ----------
    axis : GeneratedAxis
    control : (N,) array
    starts : sequence of int
        First samples of the stretches.
    period : float
        Of the record, s.
    """
    drive = axis.drive
    if drive.path.is_plain or drive.logs_what_acts:  # what acts is what was recorded
        return control
    pieces = np.split(control, list(starts)[1:])
    return np.concatenate([through_path(drive.path, piece, period) for piece in pieces])


def lagged_force(
    forces: Array, response: Response, *, logged: str = "command", start: float | None = None
) -> Acting:
    """What becomes of the forces of held commands, (N,), of one stretch.

    Parameters
    ----------
    forces : (N,) array
        That the drive makes of the recorded commands at once.
    response : Response
    logged : str
        Whether those are the ``command`` or what is ``applied`` after the delay.
    start : float, optional
        Force at the first sample; that of the first command by default, as before it.
    """
    at = np.arange(len(forces)) + (0 if logged == "command" else response.late)
    delayed = (np.clip(at - late, 0, len(at) - 1) for late in (response.late, response.whole))
    first, then = (forces[places] for places in delayed)
    share = response.share
    if not response.lag:
        return Acting(at_samples=first, mean=share * first + (1 - share) * then)
    parts = response.period * share, response.period * (1 - share)
    stays = [np.exp(-span / response.lag) for span in parts]
    begin = float(first[0]) if start is None else start
    # Of a sample: goes to `first`, then to `then`.
    added = (1 - stays[0]) * stays[1] * first + (1 - stays[1]) * then
    at_samples = _recursion(stays[0] * stays[1], added, begin)
    between = first + (at_samples - first) * stays[0]
    transient = (at_samples - first) * (1 - stays[0]) + (between - then) * (1 - stays[1])
    return Acting(
        at_samples=at_samples,
        mean=share * first + (1 - share) * then + response.lag / response.period * transient,
    )


def _recursion(factor: float, added: Array, start: float) -> Array:
    """``x[k+1] = factor * x[k] + added[k]`` from a start, (N,)."""
    from scipy.signal import lfilter

    later, _ = lfilter([1.0], [1.0, -factor], added[:-1], zi=[factor * start])
    return np.concatenate([[start], later])


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveReplay:
    """A drive along a recorded motion, for rows that pair the two as a hold does.

    Attributes
    ----------
    axis : GeneratedAxis
    starts : sequence of int
        First samples of the stretches.
    period : float
        Of the record, s.
    held : bool
        Whether the recorded control is held from a sample to the next; of a log that is slower than
        its law it is known at the samples only, and taken to run straight between them.
    delay : float
        Samples by which the hold takes the force earlier.
    mean : bool
        Whether it takes that from each sample to the next, of what is held.
    """

    axis: GeneratedAxis
    starts: Sequence[int]
    period: float
    held: bool
    delay: float
    mean: bool

    def acting(self, forces: Array) -> Array:
        """What acts of what the recorded control would make at once, (N,)."""
        drive = self.axis.drive
        if not (drive.lag or drive.delay) or drive.logged == "current":
            return forces
        pieces, response = np.split(forces, list(self.starts)[1:]), drive.response(self.period)
        if not self.held:
            return np.concatenate([_running_along(p, response, drive.logged) for p in pieces])
        responses = [lagged_force(piece, response, logged=drive.logged) for piece in pieces]
        return np.concatenate([each.mean if self.mean else each.at_samples for each in responses])

    def force(
        self,
        control: Array,
        motion: Motion,
        recorded: Sequence[Array] = (),
        *,
        by_gain: bool = False,
    ) -> Array:
        """The force of a recorded control beside a motion, (N,).

        Or how it changes with the logarithm of the drive's gain.
        """
        of_axis = self.axis.force_by_gain if by_gain else partial(drive_force, self.axis)
        make = partial(of_axis, recorded=recorded)
        position, velocity, acceleration = motion
        if not self.axis.drives_by_motion:
            return self.acting(make(control, position, velocity))
        # The hold takes the force earlier, and what of it is the motion's belongs to the sample.
        lagging = self.axis.drive.lag > 0
        ahead = self.period * (self.held / 2 if lagging else self.delay)
        position = position + ahead * (velocity + ahead / 2 * acceleration)
        velocity = velocity + ahead * acceleration
        if lagging:
            return self.acting(make(control, position, velocity))
        return make(self.acting(control), position, velocity)


def _running_along(forces: Array, response: Response, logged: str) -> Array:
    """What becomes of forces that run straight from sample to sample, at the samples, (N,)."""
    delay = response.whole + response.share if logged == "command" else 0.0
    samples = np.arange(float(len(forces)))
    x = np.interp(samples - delay, samples, forces)
    if not response.lag:
        return x
    stays = float(np.exp(-response.period / response.lag))
    late = response.lag / response.period * np.diff(x, append=x[-1])
    later = np.append(x[1:], x[-1])
    added = later - late - stays * (x - late)
    return _recursion(stays, added, float(x[0]))


def as_logged(axis: GeneratedAxis, values: Array) -> Array:
    """What a law gives, or its terms, where the records of its axis have the control.

    Parameters
    ----------
    axis : GeneratedAxis
    values : (N,) or (N, k) array
        Sample by sample, of one stretch.
    """
    drive, response = axis.drive, axis.response
    if response is None or not drive.logs_what_acts:
        return values
    if drive.logged == "current":
        columns = values.reshape(len(values), -1).T
        seen = [lagged_force(column, response).at_samples for column in columns]
        return np.stack(seen, axis=1).reshape(values.shape) if seen else values
    return values[np.maximum(np.arange(len(values)) - response.late, 0)]


def commands_as_logged(axis: GeneratedAxis, commands: Array, *, steps: bool = True) -> Array:
    """The same of commands, (N,), also behind the drive's limit and path where the log has that.

    Without `steps` they are not rounded to those of the drive, which have no slope.
    """
    law = axis.control
    if law is not None and hides_command(axis):
        limit, path = axis.drive.limit, axis.drive.path
        path = path if steps else replace(path, quantisation=0.0)
        commands = through_path(path, np.clip(commands, -limit, limit), law.period)
    return as_logged(axis, commands)


def hides_command(axis: GeneratedAxis) -> bool:
    """Whether different commands may be one in the log: it has what the drive makes of them."""
    return axis.drive.logs_what_acts and not axis.drive.path.is_plain


def limit_in_log(axis: GeneratedAxis) -> float:
    """What the record has of a command at the drive's limit, but for what a rate leaves of it."""
    drive = axis.drive
    return drive.path.end(drive.limit) if drive.logs_what_acts else drive.limit


def control_delay_in_log(axis: GeneratedAxis, law: ControlLaw) -> int:
    """Samples by which the control of a law is later in the log of an axis than it gives it."""
    response, applied = axis.response, axis.drive.logged == "applied"
    return law.delay + (response.late if response is not None and applied else 0)
