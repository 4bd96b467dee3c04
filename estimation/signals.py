"""The five signals a regressor is made of, measured or simulated."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from axisid.codegen import GeneratedAxis

from .arrays import Array
from .errors import DataError
from .prefilter import Prefilter
from .record import Record

#: Share of the samples near reversals from which they are kept unless told otherwise.
MOST_SILENT = 0.6  # of the samples; a motion that only reverses has nothing else to show


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
    """The prefilter for a record: its segments and masked rows, and its hold if that is open."""
    fitted = replace(
        prefilter,
        hold=chosen_hold(prefilter, axis, measured=record.force is not None),
        segments=record.segments,
        masked=record.masked,
        silent=(),
    )
    if prefilter.reversals == "keep" or not (prefilter.reversals or axis.has_direction):
        return replace(fitted, reversals="keep")
    fitted.check(len(record), record.period)
    silent = fitted.near_reversals(record.position, record.period)
    taken = sum(stop - start for start, stop in silent)
    if prefilter.reversals is None and axis.is_linear and taken > MOST_SILENT * len(record):
        return replace(fitted, reversals="keep")
    return replace(fitted, reversals="leave-out", silent=silent)


def chosen_hold(
    prefilter: Prefilter, axis: GeneratedAxis, *, measured: bool
) -> Literal["raw", "zoh"]:
    """The hold of the prefilter, or what suits a force that is measured or commanded."""
    law = axis.axis.control
    held = not measured and not (law is not None and law.continuous)
    return prefilter.hold or ("zoh" if held else "raw")


def measured_signals(axis: GeneratedAxis, record: Record, prefilter: Prefilter) -> Signals:
    """Filtered motion beside the force, aligned as the prefilter says."""
    prefilter = settled(prefilter, axis, record)
    prefilter.check(len(record), record.period)
    starts = [start for start, _ in record.spans]
    force = drive_force(axis, record)
    return filtered_signals(prefilter, record.position, force, record.period, starts)


def filtered_signals(
    prefilter: Prefilter, position: Array, force: Array, period: float, starts: Sequence[int]
) -> Signals:
    """Filtered motion beside the force, both (N,); the segments begin at `starts`."""
    q, velocity, acceleration = prefilter.motion(position, period)
    if prefilter.hold == "zoh":
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
