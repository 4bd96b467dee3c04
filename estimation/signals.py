"""The five signals a regressor is made of, measured or simulated."""

from dataclasses import dataclass, replace

import numpy as np

from axisid.codegen import GeneratedAxis

from .arrays import Array
from .errors import DataError
from .prefilter import Prefilter
from .record import Record


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
    if record.force is not None:
        return record.force
    if record.control is None:
        raise DataError(
            f"{record.provenance.source} has neither a force nor a control column; name one with "
            "--columns force=NAME or control=NAME."
        )
    return axis.axis.drive.gain * record.control


def settled(prefilter: Prefilter, axis: GeneratedAxis, record: Record) -> Prefilter:
    """The prefilter with its hold chosen, if it leaves that to the record."""
    if prefilter.hold is not None:
        return prefilter
    law = axis.axis.control
    held = record.force is None and not (law is not None and law.continuous)
    return replace(prefilter, hold="zoh" if held else "raw")


def measured_signals(axis: GeneratedAxis, record: Record, prefilter: Prefilter) -> Signals:
    """Filtered motion beside the force, aligned as the prefilter says."""
    prefilter.check(len(record), record.period)
    position, velocity, acceleration = prefilter.motion(record.position, record.period)
    force = drive_force(axis, record)
    if settled(prefilter, axis, record).hold == "zoh":
        force = (force + np.concatenate([force[:1], force[:-1]])) / 2
    return Signals(
        position=position,
        velocity=velocity,
        acceleration=acceleration,
        force=force,
        direction=np.sign(velocity),
    )
