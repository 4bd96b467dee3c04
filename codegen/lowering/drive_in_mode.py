"""What a drive makes of a control in one friction mode, as operations of the loop's programs."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from axisid.modeling.declaration import Response
from axisid.modeling.derivation import AxisModel
from axisid.modeling.quantities import DIRECTION

from .drive import acting_control, drive_force, drive_force_in_mode
from .program import Builder
from .response import later_force


@dataclass(frozen=True, slots=True)
class DriveInMode:
    """A drive in a friction direction, beside the values of the recorded signals."""

    builder: Builder
    model: AxisModel
    direction: tuple[int, ...]
    signals: Sequence[tuple[int]]

    def force(self, control: int, q: int, dq: int) -> int:
        """The force of a control at a position and velocity."""
        directed = self.model.axis.drive.force.has(DIRECTION)
        program = drive_force_in_mode(self.model.axis) if directed else drive_force(self.model)
        mode = (self.direction,) if directed else ()
        (tau,) = self.builder.inline(program, (control,), (q,), (dq,), *mode, *self.signals)["tau"]
        return tau

    def under_held_control(
        self,
        command: int,
        motion: tuple[int, int],
        response: Response,
        remembered: tuple[int, ...],
    ) -> tuple[tuple[int, int], tuple[int, ...]]:
        """Force and control from a sample on, and what the drive remembers at the next."""
        pending = (command, *remembered[:-1])  # the newest first
        acting = pending[-1] if response.share else pending[response.whole]
        tau = self.force(acting, *motion)
        return (tau, acting), (*pending[:-1], tau)

    def halfway(self, motion: tuple[int, int], acceleration: int, period: float) -> tuple[int, int]:
        """Position and velocity half a sample later, of an axis that slides.

        What a drive with a lag makes of the motion is held as the command is: taken there, it is
        as early as late.
        """
        build, half = self.builder.apply, self.builder.constant(period / 2)
        slope = build("mul", acceleration, build("abs", self.direction[0]))  # none at rest
        q, dq = motion
        return build("add", q, build("mul", half, dq)), build("add", dq, build("mul", half, slope))


def acting_from_sample(
    drive: DriveInMode,
    command: int,
    motion: tuple[int, int],
    remembered: tuple[int, ...],
    slope: Callable[[int], int],
) -> tuple[int, tuple[int, ...], tuple[int, ...]]:
    """Force at a sample, what is held from it on, and what the drive remembers at the next.

    `slope` is the acceleration under a force there.
    """
    builder, response = drive.builder, drive.model.axis.response
    acting, last = acting_control(builder, drive.model, command, next(iter(remembered), None))
    if response is None:
        tau = drive.force(acting, *motion)
        return tau, (tau,), ()
    forces = remembered[len(remembered) - len(response.forces) :]
    held: tuple[int, ...]
    if response.holds_control:
        held, following = drive.under_held_control(acting, motion, response, forces)
    else:
        if response.by_motion:
            motion = drive.halfway(motion, slope(forces[-1]), response.period)
        held, following = _driven(builder, response, drive.force(acting, *motion), forces)
    return held[0], held, (*last, *following)


def _driven(
    builder: Builder, response: Response, tau: int, remembered: tuple[int, ...]
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """What is held from a sample on, and what the drive remembers at the next.

    `tau` is the force of the command that is new.
    """
    count = len(remembered) - bool(response.lag)
    pending = (tau, *remembered[:count])  # the newest first
    then = pending[response.whole]
    first = pending[-1] if response.share else then
    if not response.lag:
        return (first,), pending[:-1]
    now = remembered[-1]
    parts = ((first, response.share), (then, 1 - response.share))
    end = now
    for target, share in parts if response.share else parts[1:]:
        span = builder.constant(share * response.period)
        end = later_force(builder, response.lag, (end, target), span)
    return (now, first), (*pending[:-1], end)
