"""The five signals a regressor is made of, measured or simulated."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.records import Record
from axisid.support.arrays import Array
from axisid.support.errors import DataError

from .prefilter import Prefilter


@dataclass(frozen=True, slots=True, kw_only=True)
class Signals:
    """Motion and force sample by sample, each (N,), SI.

    `direction` is the friction direction: the sign of the velocity, and between -1 and 1 for an
    axis that sticks.
    """

    position: Array
    velocity: Array
    acceleration: Array
    force: Array
    direction: Array


def drive_force(axis: GeneratedAxis, record: Record) -> Array:
    """Force of the record, (N,): measured, or the drive's gain times the control."""
    return force_of(axis, record.provenance.source, record.force, record.control)


def force_of(axis: GeneratedAxis, source: str, force: Array | None, control: Array | None) -> Array:
    """The force column of a log if there is one, else the drive's gain times the control, (N,)."""
    if force is not None:
        return force
    if control is None:
        raise DataError(
            f"{source} has neither a force nor a control column; name one with --columns "
            "force=NAME or control=NAME."
        )
    return axis.axis.drive.gain * control


def filtered_signals(
    prefilter: Prefilter, position: Array, force: Array, period: float, starts: Sequence[int]
) -> Signals:
    """Filtered motion beside the force, both (N,); the segments begin at `starts`."""
    return beside_force(prefilter.motion(position, period), force, starts, hold=prefilter.hold)


def beside_force(
    motion: tuple[Array, Array, Array], force: Array, starts: Sequence[int], *, hold: str | None
) -> Signals:
    """A filtered motion beside the force as the hold pairs them; see `filtered_signals`."""
    q, velocity, acceleration = motion
    if hold == "zoh":
        before = np.concatenate([force[:1], force[:-1]])
        before[starts] = force[starts]
        force = (force + before) / 2
    return Signals(
        position=q,
        velocity=velocity,
        acceleration=acceleration,
        force=force,
        direction=np.sign(velocity),
    )
