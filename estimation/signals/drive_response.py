"""Response of a drive to commands, and the control that a log of the drive has.

The command passes the drive's `CommandPath`: rate limit, rounding and dead band. The result is the
acting control, whose force acts after delay and lag. Commands are held from sample to sample, so
that the force between two samples is known exactly: with a lag it approaches the force of the
command exponentially, and a delay of a fraction of a sample changes the command between samples.

A stretch is a series of samples without gaps.
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
    """Force of a drive after delay and lag, (N,) each.

    Attributes
    ----------
    at_samples : array
        Force just after each sample.
    mean : array
        Mean force from each sample to the next.
    """

    at_samples: Array
    mean: Array


def through_path(path: CommandPath, commands: Array, period: float) -> Array:
    """Return the acting control for commands within the drive's limit, (N,).

    The commands pass the rate limit, the rounding and the dead band. The first command is assumed
    to have acted before the stretch already.

    Parameters
    ----------
    path : CommandPath
        Rate limit, rounding and dead band of the drive.
    commands : (N,) array
        Commands of one stretch, in the drive's unit.
    period : float
        Time for which each command is held, s.
    """
    acting, largest_step = commands, path.rate_limit * period

    def follow(control: float, command: float) -> float:
        """Return the next value of a rate-limited control, which follows a command."""
        step = command - control
        if abs(step) <= largest_step:
            return command
        return control + math.copysign(largest_step, step)

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
    """Return the acting control for a recorded control, before delay and lag, (N,).

    Parameters
    ----------
    axis : GeneratedAxis
        Axis with its drive.
    control : (N,) array
        Recorded control, in the drive's unit.
    starts : sequence of int
        First samples of the stretches.
    period : float
        Sampling period of the record, s.
    """
    drive = axis.drive
    if drive.path.is_plain or drive.logs_what_acts:  # the acting control was recorded
        return control
    pieces = np.split(control, list(starts)[1:])
    return np.concatenate([through_path(drive.path, piece, period) for piece in pieces])


def lagged_force(
    forces: Array, response: Response, *, logged: str = "command", start: float | None = None
) -> Acting:
    """Return the force after delay and lag for held commands of one stretch.

    With the lag T, the force approaches the force of the command as ``exp(-t/T)``. The delay
    changes the command within a sample: first an earlier command acts, then the command after it.

    Parameters
    ----------
    forces : (N,) array
        Forces of the recorded commands without delay and lag.
    response : Response
        Delay and lag at the sampling period of the commands.
    logged : str
        ``command`` if commands were recorded, ``applied`` if they were recorded after the delay.
    start : float, optional
        Force at the first sample; by default the force of the first command.
    """
    # Forces of the two commands that act within each sample: `first` during a share of the period,
    # `then` during the rest of it.
    samples = np.arange(len(forces)) + (0 if logged == "command" else response.late)
    last = len(samples) - 1
    first = forces[np.clip(samples - response.late, 0, last)]
    then = forces[np.clip(samples - response.whole, 0, last)]
    share = response.share
    if not response.lag:
        return Acting(at_samples=first, mean=share * first + (1 - share) * then)
    # Share of a deviation that remains after each part of a sample.
    parts = response.period * share, response.period * (1 - share)
    stays = [np.exp(-span / response.lag) for span in parts]
    begin = float(first[0]) if start is None else start
    # Within a sample, the force approaches `first`, then `then`.
    added = (1 - stays[0]) * stays[1] * first + (1 - stays[1]) * then
    at_samples = _recursion(stays[0] * stays[1], added, begin)
    # Force at the change of the command, and the sum of the deviations from the commands in lags.
    between = first + (at_samples - first) * stays[0]
    transient = (at_samples - first) * (1 - stays[0]) + (between - then) * (1 - stays[1])
    return Acting(
        at_samples=at_samples,
        mean=share * first + (1 - share) * then + response.lag / response.period * transient,
    )


def _recursion(factor: float, added: Array, start: float) -> Array:
    """Return x, (N,), with ``x[k+1] = factor * x[k] + added[k]`` and the given start ``x[0]``."""
    from scipy.signal import lfilter

    later, _ = lfilter([1.0], [1.0, -factor], added[:-1], zi=[factor * start])
    return np.concatenate([[start], later])


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveReplay:
    """Drive along a recorded motion, which returns its force for a control.

    The hold of a prefilter determines how the force is aligned with the motion.

    Attributes
    ----------
    axis : GeneratedAxis
        Axis with its drive.
    starts : sequence of int
        First samples of the stretches.
    period : float
        Sampling period of the record, s.
    held : bool
        True if the recorded control is held from a sample to the next. False for a log that is
        slower than its law: the control is then known only at the samples, and is interpolated
        linearly.
    delay : float
        Number of samples by which the force that the hold uses is earlier than the sample.
    mean : bool
        True if the hold uses the mean force from each sample to the next.
    """

    axis: GeneratedAxis
    starts: Sequence[int]
    period: float
    held: bool
    delay: float
    mean: bool

    def acting(self, forces: Array) -> Array:
        """Return the forces after delay and lag, (N,), for forces without delay and lag, (N,).

        They are unchanged if the drive has neither, or if the log has the control after the lag.
        """
        drive = self.axis.drive
        if not (drive.lag or drive.delay) or drive.logged == "current":
            return forces
        pieces, response = np.split(forces, list(self.starts)[1:]), drive.response(self.period)
        if not self.held:
            return np.concatenate([_lagged_linear(p, response, drive.logged) for p in pieces])
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
        """Return the force of a recorded control along a motion, (N,).

        Parameters
        ----------
        control : (N,) array
            Acting control, in the drive's unit.
        motion : tuple of (N,) array
            Position, velocity and acceleration, SI.
        recorded : sequence of (N,) array
            Recorded signals in the order of the axis's declaration.
        by_gain : bool
            True for the derivative of the force by the logarithm of the drive's gain.
        """
        of_axis = self.axis.force_by_gain if by_gain else partial(drive_force, self.axis)
        make = partial(of_axis, recorded=recorded)
        position, velocity, acceleration = motion
        if not self.axis.drives_by_motion:
            return self.acting(make(control, position, velocity))
        # The hold uses an earlier force, but its part due to the motion belongs to the sample: the
        # motion is moved ahead.
        lagging = self.axis.drive.lag > 0
        ahead = self.period * (self.held / 2 if lagging else self.delay)
        position = position + ahead * (velocity + ahead / 2 * acceleration)
        velocity = velocity + ahead * acceleration
        if lagging:
            return self.acting(make(control, position, velocity))
        return make(self.acting(control), position, velocity)


def _lagged_linear(forces: Array, response: Response, logged: str) -> Array:
    """Return the force after delay and lag at the samples, (N,).

    The forces without delay and lag, (N,), are interpolated linearly between the samples.
    `response` and `logged` are as in `lagged_force`.
    """
    delay = response.whole + response.share if logged == "command" else 0.0
    samples = np.arange(float(len(forces)))
    delayed = np.interp(samples - delay, samples, forces)
    if not response.lag:
        return delayed
    # A ramp is followed at a distance of lag times slope; a deviation from it decays exponentially.
    stays = float(np.exp(-response.period / response.lag))
    distance = response.lag / response.period * np.diff(delayed, append=delayed[-1])
    following = np.append(delayed[1:], delayed[-1])
    added = following - distance - stays * (delayed - distance)
    return _recursion(stays, added, float(delayed[0]))


def as_logged(axis: GeneratedAxis, values: Array) -> Array:
    """Return the control of a law, or terms of it, as the logs of the axis have the control.

    A log may have the control before the drive, after its delay, or after its lag. The result has
    the shape of the values.

    Parameters
    ----------
    axis : GeneratedAxis
        Axis whose drive declares what its logs have.
    values : (N,) or (N, k) array
        Control of the law, or terms of it, at the samples of one stretch.
    """
    drive, response = axis.drive, axis.response
    if response is None or not drive.logs_what_acts:
        return values
    if drive.logged == "current":
        columns = values.reshape(len(values), -1).T
        lagged = [lagged_force(column, response).at_samples for column in columns]
        return np.stack(lagged, axis=1).reshape(values.shape) if lagged else values
    return values[np.maximum(np.arange(len(values)) - response.late, 0)]


def commands_as_logged(axis: GeneratedAxis, commands: Array, *, steps: bool = True) -> Array:
    """Return the control that the logs of an axis have for commands of its law, (N,).

    If the log has the acting control, the commands pass the drive's limit and command path. The
    result is then delayed as in `as_logged`.

    Parameters
    ----------
    axis : GeneratedAxis
    commands : (N,) array
        Commands of the law at the samples of one stretch, in the drive's unit.
    steps : bool
        False for commands that are not rounded, as rounded values have no derivative.
    """
    law = axis.control
    if law is not None and hides_command(axis):
        limit, path = axis.drive.limit, axis.drive.path
        path = path if steps else replace(path, quantisation=0.0)
        commands = through_path(path, np.clip(commands, -limit, limit), law.period)
    return as_logged(axis, commands)


def hides_command(axis: GeneratedAxis) -> bool:
    """Return True if different commands may have the same value in the log.

    The log then has the acting control, after a command path that rounds, limits the rate or has a
    dead band.
    """
    return axis.drive.logs_what_acts and not axis.drive.path.is_plain


def limit_in_log(axis: GeneratedAxis) -> float:
    """Return the control in the log for a command at the drive's limit, in the drive's unit.

    A rate limit is not considered.
    """
    drive = axis.drive
    return drive.path.end(drive.limit) if drive.logs_what_acts else drive.limit


def control_delay_in_log(axis: GeneratedAxis, law: ControlLaw) -> int:
    """Return the delay in samples from the evaluation of a law to its control in the log."""
    response, applied = axis.response, axis.drive.logged == "applied"
    return law.delay + (response.late if response is not None and applied else 0)
