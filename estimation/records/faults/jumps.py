"""Jumps of a position that are left."""

import math

import numpy as np

from axisid.estimation.tables import Samples
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array
from axisid.support.errors import DataError
from axisid.support.remedy import Note, Remedy, Setting

from .wrapping import IN_DEGREES, OTHER_MODULUS, Modulus, Places, long_steps

_MIN_JUMP = 0.5  # of the position's range; a larger step may be a jump
_MAX_STEP_BESIDE_JUMP = 0.1  # of a jump, for the steps beside it and the median one
_MAX_TURN_DEVIATION = 0.05  # of a whole turn: the axis moves on during a jump

_TURN = 2 * math.pi


def _jumps(position: Array, gaps: Places) -> tuple[Places, Array]:
    """Samples before steps of more than half the range, and their sizes, with slow motion around.

    Steps over gaps are none.
    """
    steps = np.abs(np.diff(position))
    steps[gaps] = 0.0
    beside = np.pad(steps, 1)
    large = np.flatnonzero(steps > _MIN_JUMP * np.ptp(position))
    middle = np.median(steps) if len(steps) else 0.0
    slow = np.maximum(np.maximum(beside[:-2], beside[2:])[large], middle)
    places = large[slow < _MAX_STEP_BESIDE_JUMP * steps[large]]
    return places, steps[places]


def remaining_jumps_note(
    source: str, position: Samples, axis: Axis | None, gap: float, modulus: Modulus | None = None
) -> Note | None:
    """What is said of jumps in a position, from one sample to the next; None if there are none.

    Parameters
    ----------
    source : str
        File name, for messages.
    position : Samples
        SI.
    axis : Axis or None
        Its coordinate says whether it turns.
    gap : float
        A longer step of time is a gap, in median steps.
    modulus : Modulus, optional
        That was asked for.

    Raises
    ------
    DataError
        The jumps are whole turns, or there are jumps though a modulus was given.
    """
    places, sizes = _jumps(position.values, long_steps(position, gap))
    if not len(places):
        return None
    size = float(np.median(sizes))
    times = f" ({len(places)} such jumps)" if len(places) > 1 else ""
    unit = axis.coordinate.unit if axis is not None else "(m or rad)"
    found = f"the position jumps by {size:.4g} {unit} before data row {places[0] + 2}{times}"
    if modulus is not None:
        raise DataError(
            f"{source}: {found}, which the modulus {modulus} does not undo; ",
            Remedy.of("give the one it is wrapped by, with its unit, as in ", IN_DEGREES, "."),
            code=OTHER_MODULUS,
        )
    turns = axis is None or axis.coordinate.unit == "rad"
    in_degrees = Remedy.of(Setting("columns", "position=NAME:deg"), " and ")
    for turn, more in ((_TURN, None), (360.0, in_degrees)):
        if turns and abs(size / turn - 1) < _MAX_TURN_DEVIATION:
            raise DataError(
                f"{source}: {found}, as one that starts again after a turn does; it looks "
                "wrapped: ",
                Remedy.of("add ", more, IN_DEGREES, "."),
                code="wrapped",
            )
    given = Remedy.of("give what it is wrapped by (", Setting("wrap"), ")")
    return Note(f"{found}: if it starts again there, ", given)
