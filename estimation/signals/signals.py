"""Signals of the regressor: motion, force and recorded signals, sample by sample.

Recorded signals are not differentiated, so they are not low-passed, as the force is not. Products
with the motion are computed sample by sample, and both sides of the rows then pass the same
decimation filter. A held signal changes at a sample: the mean of its values before and after the
sample belongs to the acceleration at the sample.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.support.arrays import Array, Exact
from axisid.support.errors import DataError
from axisid.support.settings import setting

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

    It is ``(1 - d) x_k + d x_(k-1)`` within segments. With the delay d = 0.5 it is the mean of two
    held values, which is half a sample late. With a smaller d it is a linear interpolation that is
    d samples late, for a value that is held for less than a sample.

    Parameters
    ----------
    values : (N,) array
        Held values at the samples.
    starts : sequence of int
        First samples of the segments.
    delay : float
        Delay d, in samples.
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
        The record has no column for a signal.
    """
    names = [signal.name for signal in axis.signals]
    if missing := [name for name in names if name not in columns]:
        raise DataError(
            f"{source} has no column for {', '.join(missing)}, but axis {axis.name!r} declares "
            f"{'this recorded signal' if len(missing) == 1 else 'these recorded signals'}. Set "
            f"{setting('columns', dict.fromkeys(missing, 'NAME'))}.",
            code="missing-column",
        )
    return tuple(columns[name] for name in names)
