"""Jumps of a position that are left, of a log read whole or block by block."""

import math

import numpy as np

from axisid.estimation.tables import Samples
from axisid.estimation.thresholds.records import MAX_STEP_BESIDE_JUMP, MAX_TURN_DEVIATION, MIN_JUMP
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array
from axisid.support.errors import DataError
from axisid.support.remedy import Note, Remedy, Setting

from .wrapping import IN_DEGREES, OTHER_MODULUS, Modulus, Places, long_steps

_TURN = 2 * math.pi


class Jumps:
    """Steps of more than half the position's range, with rest or slow motion around them.

    What half the range is shows at the end only; until then it keeps the steps of more than half
    of the range so far.
    """

    def __init__(self) -> None:
        self.least, self.most = math.inf, -math.inf
        self.last = np.empty(0)  # sample
        self.open = np.zeros(1)  # the last step whose neighbours are known, and the one after it
        self.steps = 0  # whose neighbours are known
        self.places = np.empty(0, dtype=np.int64)
        self.sizes = np.empty(0)
        self.middles: list[float] = []  # median steps of the blocks

    def add(self, position: Array, gaps: Places | None = None) -> None:
        """Take the next samples; steps that are gaps in a log read whole are none."""
        if not len(position):
            return
        self.least = min(self.least, float(position.min()))
        self.most = max(self.most, float(position.max()))
        steps = np.abs(np.diff(np.concatenate([self.last, position])))
        if gaps is not None:
            steps[gaps] = 0.0
        self.last = position[-1:].copy()
        if len(steps):
            self.middles.append(float(np.median(steps)))
            self._decide(steps)

    def _decide(self, steps: Array) -> None:
        """Keep what may be a jump of the steps whose neighbours on both sides are there."""
        queue = np.concatenate([self.open, steps])
        inner, around = queue[1:-1], np.maximum(queue[:-2], queue[2:])
        large = np.flatnonzero(inner > MIN_JUMP.value * (self.most - self.least))
        large = large[around[large] < MAX_STEP_BESIDE_JUMP.value * inner[large]]
        places = np.concatenate([self.places, self.steps + large])
        sizes = np.concatenate([self.sizes, inner[large]])
        kept = sizes > MIN_JUMP.value * (self.most - self.least)
        self.places, self.sizes = places[kept], sizes[kept]
        self.steps += len(inner)
        self.open = queue[-2:].copy()

    def found(self) -> tuple[Places, Array]:
        """The jumps, once all samples were taken: samples before them, and their sizes."""
        self._decide(np.zeros(1))
        middle = np.median(self.middles) if self.middles else 0.0
        quiet = self.sizes * MAX_STEP_BESIDE_JUMP.value > middle
        return self.places[quiet], self.sizes[quiet]


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
    jumps = Jumps()
    jumps.add(position.values, long_steps(position, gap))
    return jump_note(source, jumps, axis, modulus)


def jump_note(
    source: str, jumps: Jumps, axis: Axis | None, modulus: Modulus | None = None
) -> Note | None:
    """The same of jumps that were looked for block by block."""
    places, sizes = jumps.found()
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
        if turns and abs(size / turn - 1) < MAX_TURN_DEVIATION.value:
            raise DataError(
                f"{source}: {found}, as one that starts again after a turn does; it looks "
                "wrapped: ",
                Remedy.of("add ", more, IN_DEGREES, "."),
                code="wrapped",
            )
    given = Remedy.of("give what it is wrapped by (", Setting("wrap"), ")")
    return Note(f"{found}: if it starts again there, ", given)
