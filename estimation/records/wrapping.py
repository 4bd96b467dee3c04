"""Numbers that start again after a modulus: their jumps undone on request.

A position goes on over it, turn after turn; others lost their sign: -1 is the modulus less 1.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.tables import Repair, Samples
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array
from axisid.support.errors import DataError

from .clocks import long_steps

_MAX_WRAPPED_SPAN = 1.001  # moduli that a wrapped position spans, with noise
# times the largest second difference elsewhere: more than a right modulus leaves at seams
_MAX_SEAM_BEND = 5.0
_MIN_SEAM_BEND = 1e-4  # moduli, up to which a second difference at the seams is rounding

Places = NDArray[np.intp]

#: A modulus of a turn.
_IN_DEGREES = 'wrap = "360:deg" in run.toml'

_MIN_JUMP = 0.5  # of the position's range; a larger step may be a jump
_MAX_STEP_BESIDE_JUMP = 0.1  # of a jump, for the steps beside it and the median one
_MAX_TURN_DEVIATION = 0.05  # of a whole turn: the axis moves on during a jump

_TURN = 2 * math.pi


@dataclass(frozen=True, slots=True, kw_only=True)
class Modulus:
    """What a position starts again after.

    Attributes
    ----------
    si : float
    factor : float
        To SI, of the unit in which it was given.
    unit : str
    """

    si: float
    factor: float
    unit: str

    def __str__(self) -> str:
        return self.written(self.si)

    def written(self, size: float) -> str:
        """A distance, SI, in the unit in which the modulus was given."""
        return f"{size / self.factor:.6g} {self.unit}"


def undone(values: Array, modulus: float) -> tuple[Array, Places]:
    """Values without their jumps by whole moduli, and the steps in which they were.

    Parameters
    ----------
    values : (N,) array
        In the unit of `modulus`.
    modulus : float

    Returns
    -------
    (N,) array, (n,) array of int
    """
    turns = np.round(np.diff(values) / modulus)
    unwrapped = values - modulus * np.concatenate([[0.0], np.cumsum(turns)])
    return unwrapped, np.flatnonzero(turns)


def unwrapped(
    source: str, samples: Mapping[str, Samples], modulus: Modulus, gap: float
) -> tuple[dict[str, Samples], Repair]:
    """Undo the jumps of position and reference by whole moduli.

    Where there were jumps, the reference begins on the position's turn, unless it spans more than
    the modulus. Where samples are missing, the turns in between are not known: the position is
    taken to have moved by less than half a modulus, and the reference to begin again on the
    position's turn. Without a jump nothing is moved.

    Parameters
    ----------
    source : str
        File name, for messages.
    samples : mapping of str to Samples
        By role, SI, each with its clock.
    modulus : Modulus
    gap : float
        A longer step of time is a gap, in median steps.

    Raises
    ------
    DataError
        The position is not within one modulus, or jumps by something else: it is not wrapped by it.
    """
    if "position" not in samples:
        raise DataError(
            f"{source}: there is no position whose jumps by {modulus} could be undone; name "
            "it with columns position=NAME, or leave wrap out in run.toml.",
            code="wrap",
        )
    repaired, counts = dict(samples), {}
    for role in ("position", "reference"):
        if role not in samples:
            continue
        values, counts[role] = samples[role].values, 0
        if float(np.ptp(values)) <= _MAX_WRAPPED_SPAN * modulus.si:
            unwrapped, places = undone(values, modulus.si)
            if role == "position":  # a reference may well step across its seam
                _check_seams(
                    source, unwrapped, places, long_steps(samples[role].times, gap), modulus
                )
            repaired[role], counts[role] = replace(samples[role], values=unwrapped), len(places)
        elif role == "position":
            raise DataError(
                f"{source}: the position spans {modulus.written(np.ptp(values))}, more than the "
                f"modulus {modulus}, so it is not wrapped by it; give the modulus with its unit, "
                "or leave wrap out in run.toml.",
                code="wrap",
            )
    moved = 0
    # Without a jump nothing says that either is wrapped: no turn is the wrong one then.
    if "reference" in samples and any(counts.values()):
        own_turn = float(np.ptp(samples["reference"].values)) > _MAX_WRAPPED_SPAN * modulus.si
        repaired["reference"], moved = _beside(repaired, modulus.si, gap, own_turn=own_turn)
    counted = ", ".join(f"{role} {count}" for role, count in counts.items())
    text = f"jumps by the modulus {modulus} undone: {counted}"
    if gaps := len(long_steps(samples["position"].times, gap)):
        across = "a gap" if gaps == 1 else f"each of {gaps} gaps"
        text += f"; across {across} the motion is taken to be less than half of it"
    text += f"; pieces of the reference moved by whole moduli: {moved}" * bool(moved)
    return repaired, Repair(kind="wrap", count=sum(counts.values()) + moved, text=text)


def signed(
    source: str, samples: Mapping[str, Samples], role: str, modulus: Modulus
) -> tuple[dict[str, Samples], Repair]:
    """Take numbers of half a modulus and more as negative ones that were written without a sign.

    Raises
    ------
    DataError
        There is no such column, or it has numbers beyond the modulus.
    """
    if role not in samples:
        raise DataError(
            f"{source}: there is no {role} from which the modulus {modulus} could be taken; name a "
            f"column that is read ({', '.join(name for name in samples if name != 'time')}).",
            code="wrap",
        )
    values = samples[role].values
    if float(np.abs(values).max()) > modulus.si:
        raise DataError(
            f"{source}: the {role} reaches {modulus.written(np.abs(values).max())}, more than the "
            f"modulus {modulus}; give the modulus in the column's unit, or leave it.",
            code="wrap",
        )
    beyond = values >= modulus.si / 2
    made = replace(samples[role], values=np.where(beyond, values - modulus.si, values))
    count = int(np.count_nonzero(beyond))
    text = f"{role} of half the modulus {modulus} and more taken as negative: {count}"
    return {**samples, role: made}, Repair(kind="wrap", count=count, text=text)


def _beside(
    samples: Mapping[str, Samples], modulus: float, gap: float, *, own_turn: bool
) -> tuple[Samples, int]:
    """The reference, moved by whole moduli to where the position is, and how many pieces moved.

    It is moved at its start, unless it has a turn of its own there, and after each gap.
    """
    position, reference = samples["position"], samples["reference"]
    clock, own = position.times, reference.times
    after = np.searchsorted(own, clock[long_steps(position.times, gap) + 1])
    starts = np.unique(np.concatenate([[0], after, long_steps(reference.times, gap) + 1]))
    starts = starts[starts < len(own)]
    beside = np.minimum(np.searchsorted(clock, own[starts]), len(clock) - 1)
    turns = np.round((position.values[beside] - reference.values[starts]) / modulus)
    if own_turn:
        turns[0] = 0.0
    stops = np.append(starts[1:], len(own))
    moved = replace(reference, values=reference.values + modulus * np.repeat(turns, stops - starts))
    return moved, int(np.count_nonzero(turns))


def _check_seams(
    source: str, unwrapped: Array, places: Places, gaps: Places, modulus: Modulus
) -> None:
    """Refuse a modulus that leaves a jump where it undid one.

    There the motion then bends more than anywhere else: its step is not the mean of its neighbours.
    """
    steps = np.diff(unwrapped)
    bends = np.abs(steps[1:-1] - (steps[:-2] + steps[2:]) / 2)
    special = np.zeros(len(steps), dtype=bool)
    special[places] = special[gaps] = True
    steady = ~(special[:-2] | special[2:])
    seams = np.setdiff1d(places, gaps)
    at_seams = bends[steady & np.isin(np.arange(1, len(steps) - 1), seams)]
    elsewhere = bends[steady & ~special[1:-1]]
    if not len(at_seams) or not len(elsewhere):
        return
    left = float(np.median(at_seams))
    if left > max(_MAX_SEAM_BEND * float(elsewhere.max()), _MIN_SEAM_BEND * modulus.si):
        raise DataError(
            f"{source}: the position still jumps by {modulus.written(left)} where the modulus "
            f"{modulus} was taken out, as before data row {seams[0] + 2}; give the modulus "
            f"that it is wrapped by, with its unit, as in {_IN_DEGREES}.",
            code="wrap",
        )


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
    source: str, position: Samples, axis: Axis | None, gap: float, modulus: Modulus | None
) -> str | None:
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
    modulus : Modulus
        That was asked for.

    Raises
    ------
    DataError
        The jumps are whole turns, or there are jumps though a modulus was given.
    """
    places, sizes = _jumps(position.values, long_steps(position.times, gap))
    if not len(places):
        return None
    size = float(np.median(sizes))
    times = f" ({len(places)} such jumps)" if len(places) > 1 else ""
    unit = axis.coordinate.unit if axis is not None else "(m or rad)"
    found = f"the position jumps by {size:.4g} {unit} before data row {places[0] + 2}{times}"
    if modulus is not None:
        raise DataError(
            f"{source}: {found}, which the modulus {modulus} does not undo; give the one it "
            f"is wrapped by, with its unit, as in {_IN_DEGREES}.",
            code="wrap",
        )
    turns = axis is None or axis.coordinate.unit == "rad"
    in_degrees = "columns position=NAME:deg and "
    for turn, more in ((_TURN, None), (360.0, in_degrees)):
        if turns and abs(size / turn - 1) < _MAX_TURN_DEVIATION:
            raise DataError(
                f"{source}: {found}, as one that starts again after a turn does; it looks "
                f"wrapped: add {more}{_IN_DEGREES}.",
                code="wrap",
            )
    given = "give what it is wrapped by (wrap in run.toml)"
    return f"{found}: if it starts again there, {given}"
