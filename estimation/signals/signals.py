"""The five signals a regressor is made of, measured or simulated."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.support.arrays import Array, Exact
from axisid.support.errors import DataError
from axisid.support.remedy import Remedy, Setting

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


def checked_control(source: str, control: Array | None) -> Array:
    """The control column of a log that has no force column.

    Raises
    ------
    DataError
        There is none.
    """
    if control is None:
        raise DataError(
            f"{source} has neither a force nor a control column; ",
            Remedy.of(
                "name one with ",
                Setting("columns", "force=NAME"),
                " or ",
                Setting("columns", "control=NAME"),
                ".",
            ),
            code="no-force",
        )
    return control


def about_samples(held: Array, starts: Sequence[int], delay: float = 0.5) -> Array:
    """The mean of what is held just before and just after each sample, (N,), segment by segment.

    That is half a sample late. Of what is held for less than a sample, only the value at each is
    known: it is taken that much later along a straight line.
    """
    before = np.concatenate([held[:1], held[:-1]])
    before[starts] = held[starts]
    return np.asarray((1 - delay) * held + delay * before, dtype=float)
