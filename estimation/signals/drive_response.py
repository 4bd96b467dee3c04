"""Response of a drive to commands: rounding, rate limit, dead band, delay and lag; and its log.

The drive's `CommandPath` gives the acting control for a command. Commands are held, so that with a
lag the force between two samples is known exactly: it approaches the force of the command
exponentially, and a delay of a fraction of a sample changes the command between samples.
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
    """Force of a drive, (N,) each.

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
    """Return the acting controls for commands within the limit, (N,).

    They pass the rate limit, the rounding and the dead band; the first command acted before the
    stretch.

    Parameters
    ----------
    path : CommandPath
    commands : (N,) array
        Commands of one stretch.
    period : float
        Time for which each command is held, s.
    """
    acting, most = commands, path.rate_limit * period

    def follow(now: float, command: float) -> float:
        """Return the next value of a rate-limited control, which follows a command."""
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
    """Return the acting control for a recorded control, before delay and lag, (N,).

    Parameters
    ----------
    axis : GeneratedAxis
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

    With the lag T, the force approaches that of the command as ``exp(-t/T)``. The delay changes the
    command within a sample, from that of a sample before to that of the next one.

    Parameters
    ----------
    forces : (N,) array
        Forces of the recorded commands without delay and lag.
    response : Response
    logged : str
        ``command`` if commands were recorded, ``applied`` if they were recorded after the delay.
    start : float, optional
        Force at the first sample; by default that of the first command.
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
    # Within a sample, the force approaches `first`, then `then`.
    added = (1 - stays[0]) * stays[1] * first + (1 - stays[1]) * then
    at_samples = _recursion(stays[0] * stays[1], added, begin)
    between = first + (at_samples - first) * stays[0]
    transient = (at_samples - first) * (1 - stays[0]) + (between - then) * (1 - stays[1])
    return Acting(
        at_samples=at_samples,
        mean=share * first + (1 - share) * then + response.lag / response.period * transient,
    )


def _recursion(factor: float, added: Array, start: float) -> Array:
    """Return ``x[k+1] = factor * x[k] + added[k]`` from a start value, (N,)."""
    from scipy.signal import lfilter

    later, _ = lfilter([1.0], [1.0, -factor], added[:-1], zi=[factor * start])
    return np.concatenate([[start], later])


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveReplay:
    """Force of a drive along a recorded motion, aligned for the rows by a hold.

    Attributes
    ----------
    axis : GeneratedAxis
    starts : sequence of int
        First samples of the stretches.
    period : float
        Sampling period of the record, s.
    held : bool
        True if the recorded control is held from a sample to the next; in a log that is slower than
        its law the control is known only at the samples and interpolated linearly.
    delay : float
        Samples by which the hold uses the force earlier.
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
        """Return forces without delay and lag, (N,), as they act after delay and lag, (N,)."""
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

        If `by_gain`, return its derivative by the logarithm of the drive's gain.
        """
        of_axis = self.axis.force_by_gain if by_gain else partial(drive_force, self.axis)
        make = partial(of_axis, recorded=recorded)
        position, velocity, acceleration = motion
        if not self.axis.drives_by_motion:
            return self.acting(make(control, position, velocity))
        # The hold uses the force earlier, but its part due to the motion belongs to the sample.
        lagging = self.axis.drive.lag > 0
        ahead = self.period * (self.held / 2 if lagging else self.delay)
        position = position + ahead * (velocity + ahead / 2 * acceleration)
        velocity = velocity + ahead * acceleration
        if lagging:
            return self.acting(make(control, position, velocity))
        return make(self.acting(control), position, velocity)


def _lagged_linear(forces: Array, response: Response, logged: str) -> Array:
    """Return the force after delay and lag at the samples, (N,).

    The forces without delay and lag, (N,), are interpolated linearly between the samples. `logged`
    is as in `lagged_force`.
    """
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
    """Return the control of a law, or its terms, as the records of the axis log the control.

    A record may log the control before the drive, after its delay, or after its lag.

    Parameters
    ----------
    axis : GeneratedAxis
    values : (N,) or (N, k) array
        Values of the law at the samples of one stretch.
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
    """Return commands, (N,), as the axis's records log the control; see `as_logged`.

    If the log has the acting control, the commands also pass the drive's limit and command path.
    Without `steps` they are not rounded, as rounded values have no derivative.
    """
    law = axis.control
    if law is not None and hides_command(axis):
        limit, path = axis.drive.limit, axis.drive.path
        path = path if steps else replace(path, quantisation=0.0)
        commands = through_path(path, np.clip(commands, -limit, limit), law.period)
    return as_logged(axis, commands)


def hides_command(axis: GeneratedAxis) -> bool:
    """Return True if different commands may have one logged value.

    The log has the acting control behind a command path that rounds, limits or has a dead band.
    """
    return axis.drive.logs_what_acts and not axis.drive.path.is_plain


def limit_in_log(axis: GeneratedAxis) -> float:
    """Return the logged control for a command at the drive's limit, without a rate limit."""
    drive = axis.drive
    return drive.path.end(drive.limit) if drive.logs_what_acts else drive.limit


def control_delay_in_log(axis: GeneratedAxis, law: ControlLaw) -> int:
    """Return the delay in samples from the evaluation of a law to its control in the log."""
    response, applied = axis.response, axis.drive.logged == "applied"
    return law.delay + (response.late if response is not None and applied else 0)
