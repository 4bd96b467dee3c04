"""The signals that a regressor is made of: motion, force, and what else was recorded.

Recorded signals are no part of what is differentiated, so that they stand in the rows as the force
does: as they were recorded. Products of them and the motion are made sample by sample, and both
sides of the rows then take the same decimation filter. What is held changes at a sample: its mean
about the sample belongs to the acceleration there.
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

    `direction` is the friction direction: the sign of the velocity, and between -1 and 1 for an
    axis that sticks. `recorded` are the signals that the axis declares, in its order.
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
    """Force that the drive makes of a control, (N,), by the motion and the signals beside it."""
    return axis.evaluate("drive_force", control, position, velocity, *recorded)[0][:, 0]


def hold_mean(values: Array, starts: Sequence[int], delay: float = 0.5) -> Array:
    """The mean of what is held just before and just after each sample, (N,), segment by segment.

    That is half a sample late. Of what is held for less than a sample, only the value at each is
    known: it is taken that much later along a straight line.
    """
    before = np.concatenate([values[:1], values[:-1]])
    before[starts] = values[starts]
    return np.asarray((1 - delay) * values + delay * before, dtype=float)


def recorded_signals(
    axis: GeneratedAxis, source: str, columns: Mapping[str, Array]
) -> tuple[Array, ...]:
    """The signals that an axis declares, in its order, (N,) each.

    Parameters
    ----------
    axis : GeneratedAxis
    source : str
        Of the record, for messages.
    columns : mapping of str to (N,) array
        By role or name.

    Raises
    ------
    DataError
        The record lacks one.
    """
    names = [signal.name for signal in axis.axis.signals]
    if missing := [name for name in names if name not in columns]:
        raise DataError(
            f"{source} has no column for {', '.join(missing)}, which axis {axis.axis.name!r} has "
            "as recorded signals; name it with columns "
            f"{','.join(f'{name}=NAME' for name in missing)}.",
            code="missing-column",
        )
    return tuple(columns[name] for name in names)
