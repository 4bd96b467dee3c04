"""Columns of lanes sample by sample, (N, c, L), where no compiled code makes their rows at once."""

from dataclasses import dataclass

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.signals import drive_force
from axisid.support.arrays import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class LaneSignals:
    """Lanes as they are measured.

    Attributes
    ----------
    motion : tuple of (N, L) array
        Filtered position, velocity and acceleration.
    control : (N, L) array
    """

    motion: tuple[Array, Array, Array]
    control: Array


def measured_columns(axis: GeneratedAxis, s: LaneSignals, delay: float) -> Array:
    """Regressor, known part and force, the force so many samples earlier, (N, p + 2, L)."""
    q, dq, _ = s.motion
    made = drive_force(axis, np.ravel(s.control), np.ravel(q), np.ravel(dq))
    force = made.reshape(q.shape)
    if delay:
        force = (1 - delay) * force + delay * earlier(force)
    return np.concatenate([motion_rows(axis, (*s.motion, np.sign(dq))), force[:, None]], axis=1)


def loop_columns(
    axis: GeneratedAxis, signals: tuple[Array, ...], before: Array | None, physical: Array
) -> Array:
    """Regressor and known part of simulated loops, (N, p + 1, L).

    Parameters
    ----------
    axis : GeneratedAxis
    signals : tuple of (N, L) array
        Position, velocity, acceleration, force and direction.
    before : (N, L) array or None
        Directions just before the samples, where rows are the mean of just before and just after.
    physical : (L, p) array
    """
    q, dq, ddq, force, direction = signals
    after = motion_rows(axis, (q, dq, ddq, direction))
    if before is None:
        return after
    sets = np.broadcast_to(physical, (len(q), *physical.shape)).reshape(q.size, -1)
    motion = (np.ravel(each) for each in (q, dq, earlier(force), before))
    (acceleration,) = axis.evaluate("direct_dynamics", *motion, sets)
    return (after + motion_rows(axis, (q, dq, acceleration.reshape(q.shape), before))) / 2


def earlier(values: Array) -> Array:
    """Values of the sample before, (N, L)."""
    return np.concatenate([values[:1], values[:-1]])


def motion_rows(axis: GeneratedAxis, motion: tuple[Array, ...]) -> Array:
    """Regressor and known part of a motion and its direction, (N, L) each: (N, p + 1, L)."""
    row, known = axis.evaluate("idm_regressor", *(np.ravel(each) for each in motion))
    shape = motion[0].shape
    every = np.concatenate([row, known], axis=1).reshape(*shape, -1)
    return np.ascontiguousarray(every.transpose(0, 2, 1))
