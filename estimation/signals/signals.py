"""Signals of the regressor: motion, force and recorded signals, sample by sample.

Recorded signals are not differentiated, so that they enter the rows unfiltered, as the force does.
Products with the motion are computed sample by sample, and both sides of the rows then pass the
same decimation filter. A held signal changes at a sample: its mean about the sample belongs to the
acceleration there.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.support.arrays import Array, Exact
from axisid.support.errors import DataError

#: Position, velocity and acceleration, each (N,), SI.
Motion = tuple[Array, Array, Array]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Signals(Exact):
    """Motion and force sample by sample, each (N,), SI.

    `direction` is the friction direction: the sign of the velocity, or between -1 and 1 while the
    axis sticks. `recorded` has the recorded signals in the order of the axis's declaration.
    """

    position: Array
    velocity: Array
    acceleration: Array
    force: Array
    direction: Array
    recorded: tuple[Array, ...] = ()


def drive_force(
    axis: GeneratedAxis,
    control: Array,
    position: Array,
    velocity: Array,
    recorded: Sequence[Array] = (),
) -> Array:
    """Return the drive's force for a control, a motion and recorded signals, (N,)."""
    return axis.evaluate("drive_force", control, position, velocity, *recorded)[0][:, 0]


def hold_mean(values: Array, starts: Sequence[int], delay: float = 0.5) -> Array:
    """Return the mean of the held values just before and just after each sample, (N,).

    It is ``(1 - d) x_k + d x_(k-1)`` with the delay d, within segments. The mean is half a sample
    late. A value that is held for less than a sample is interpolated linearly, d samples late.

    Parameters
    ----------
    values : (N,) array
        Held values at the samples.
    starts : sequence of int
        First samples of the segments.
    delay : float
        d, samples.
    """
    before = np.concatenate([values[:1], values[:-1]])
    before[starts] = values[starts]
    return np.asarray((1 - delay) * values + delay * before, dtype=float)


def recorded_signals(
    axis: GeneratedAxis, source: str, columns: Mapping[str, Array]
) -> tuple[Array, ...]:
    """Return the recorded signals in the order of the axis's declaration, (N,) each.

    Parameters
    ----------
    axis : GeneratedAxis
    source : str
        Name of the record, for messages.
    columns : mapping of str to (N,) array
        Columns by role or name.

    Raises
    ------
    DataError
        The record lacks one.
    """
    names = [signal.name for signal in axis.signals]
    if missing := [name for name in names if name not in columns]:
        raise DataError(
            f"{source} has no column for {', '.join(missing)}, which axis {axis.name!r} has "
            "as recorded signals; name it with columns "
            f"{','.join(f'{name}=NAME' for name in missing)}.",
            code="missing-column",
        )
    return tuple(columns[name] for name in names)
