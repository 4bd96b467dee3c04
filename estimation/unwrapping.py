"""Positions that start again after a turn: jumps undone on request, and found unasked."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from axisid.modeling import Axis

from .arrays import Array
from .errors import DataError
from .provenance import Repair
from .table import Samples

Places = NDArray[np.int64]
#: First row, the one after the last, and by how many moduli.
_Move = tuple[int, int, int]

_TURNED = 1.001  # a wrapped position stays within one modulus, but for noise
_BENT = 5.0  # of the largest bend elsewhere: more than the seam of a right modulus leaves
_SHOWN = 3  # pieces that are listed
_SURELY = 1e-4  # of the modulus, below which a bend is rounding
_JUMP = 0.5  # of the position's range
_QUIET = 0.1  # of the jump: steps beside it, and in the middle of all
_TURN = 2 * math.pi
_NEAR = 0.05  # relative; the axis moves on during a jump


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
    straight = values - modulus * np.concatenate([[0.0], np.cumsum(turns)])
    return straight, np.flatnonzero(turns)


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
    repaired, counts = dict(samples), {}
    for role in ("position", "reference"):
        if role not in samples:
            continue
        values, counts[role] = samples[role].values, 0
        if float(np.ptp(values)) <= _TURNED * modulus.si:
            straight, places = undone(values, modulus.si)
            if role == "position":  # a reference may well step across its seam
                _check_seams(source, straight, places, _gaps(samples[role], gap), modulus)
            repaired[role], counts[role] = replace(samples[role], values=straight), len(places)
        elif role == "position":
            raise DataError(
                f"{source}: the position spans {modulus.written(np.ptp(values))}, more than the "
                f"modulus {modulus}, so it is not wrapped by it; give the modulus with "
                "its unit, or leave --wrap out."
            )
    moves: list[_Move] = []
    # Without a jump nothing says that either is wrapped: no turn is the wrong one then.
    if "reference" in samples and any(counts.values()):
        own_turn = float(np.ptp(samples["reference"].values)) > _TURNED * modulus.si
        repaired["reference"], moves = _beside(repaired, modulus.si, gap, own_turn=own_turn)
    told = ", ".join(f"{role} {count}" for role, count in counts.items())
    text = f"jumps by the modulus {modulus} undone: {told}"
    if not any(counts.values()):
        text = f"no jumps by the modulus {modulus} found: {told}"
    if gaps := len(_gaps(samples["position"], gap)):
        across = "a gap" if gaps == 1 else f"each of {gaps} gaps"
        text += f"; across {across} the motion is taken to be less than half of it"
    text += _moves_told(moves)
    return repaired, Repair(kind="wrap", count=sum(counts.values()) + len(moves), text=text)


def _gaps(samples: Samples, longest: float) -> Places:
    """Steps over missing samples."""
    steps = np.diff(_clock(samples))
    return np.flatnonzero(steps > longest * np.median(steps)) if len(steps) else np.zeros(0, int)


def _clock(samples: Samples) -> Array:
    """Times of the samples, or their numbers."""
    if samples.clock is not None:
        return samples.clock
    return np.arange(len(samples.values), dtype=np.float64)


def _beside(
    samples: Mapping[str, Samples], modulus: float, gap: float, *, own_turn: bool
) -> tuple[Samples, list[_Move]]:
    """The reference, moved by whole moduli to where the position is, and the pieces that moved.

    It is moved at its start, unless it has a turn of its own there, and after each gap.
    """
    position, reference = samples["position"], samples["reference"]
    clock, own = _clock(position), _clock(reference)
    after = np.searchsorted(own, clock[_gaps(position, gap) + 1])
    starts = np.unique(np.concatenate([[0], after, _gaps(reference, gap) + 1]))
    starts = starts[starts < len(own)]
    beside = np.minimum(np.searchsorted(clock, own[starts]), len(clock) - 1)
    turns = np.round((position.values[beside] - reference.values[starts]) / modulus)
    if own_turn:
        turns[0] = 0.0
    stops = np.append(starts[1:], len(own))
    moved = replace(reference, values=reference.values + modulus * np.repeat(turns, stops - starts))
    pieces = zip(starts, stops, turns, strict=True)
    return moved, [(int(a), int(b), int(turn)) for a, b, turn in pieces if turn]


def _moves_told(moves: list[_Move]) -> str:
    """What is said of pieces of the reference that were moved; empty for none."""
    if not moves:
        return ""
    shown = [f"{turns:+d} in data rows {a + 1} to {b}" for a, b, turns in moves[:_SHOWN]]
    more = [f"{len(moves) - _SHOWN} more pieces"] if len(moves) > _SHOWN else []
    return f"; reference moved by whole moduli: {', '.join(shown + more)}"


def _check_seams(
    source: str, straight: Array, places: Places, gaps: Places, modulus: Modulus
) -> None:
    """Refuse a modulus that leaves a jump where it undid one.

    There the motion then bends more than anywhere else: its step is not the mean of its neighbours.
    """
    steps = np.diff(straight)
    smooth = np.ones(len(steps), dtype=bool)
    smooth[places] = smooth[gaps] = False
    steady = np.where(smooth, steps, np.nan)
    nowhere = [np.nan]
    beside = np.concatenate([nowhere, steady[:-1]]) + np.concatenate([steady[1:], nowhere])
    bends = steps - beside / 2
    known = np.isfinite(bends)
    seams = np.setdiff1d(places, gaps)
    seams = seams[known[seams]]
    elsewhere = np.abs(bends[known & smooth])
    if not len(seams) or not len(elsewhere):
        return
    left = float(np.median(np.abs(bends[seams])))
    if left > max(_BENT * float(elsewhere.max()), _SURELY * modulus.si):
        raise DataError(
            f"{source}: the position still jumps by {modulus.written(left)} where the modulus "
            f"{modulus} was taken out, as before data row {seams[0] + 2}; give the modulus that it "
            "is wrapped by, with its unit, as in --wrap 360:deg."
        )


def left_jumps(
    source: str,
    position: Samples,
    axis: Axis | None,
    gap: float,
    modulus: Modulus | None = None,
    *,
    before: int = 0,
) -> str:
    """What is said of jumps in a position, from one sample to the next; empty if there are none.

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
    before : int
        Samples before the first, of a log that is read in blocks.

    Raises
    ------
    DataError
        The jumps are whole turns, or there are jumps though a modulus was given.
    """
    jumps = _jumps(position, gap)
    if not len(jumps):
        return ""
    size = float(np.median(np.abs(np.diff(position.values)[jumps])))
    times = f" ({len(jumps)} such jumps)" if len(jumps) > 1 else ""
    unit = axis.coordinate.unit if axis is not None else "(m or rad)"
    found = (
        f"the position jumps by {size:.4g} {unit} before data row {before + jumps[0] + 2}{times}"
    )
    if modulus is not None:
        raise DataError(
            f"{source}: {found}, which the modulus {modulus} does not undo; give the one it is "
            "wrapped by, with its unit, as in --wrap 360:deg."
        )
    turns = axis is None or axis.coordinate.unit == "rad"
    for turn, more in ((_TURN, ""), (360.0, "--columns position=NAME:deg and ")):
        if turns and abs(size / turn - 1) < _NEAR:
            raise DataError(
                f"{source}: {found}, as one that starts again after a turn does; it looks wrapped: "
                f"add {more}--wrap 360:deg."
            )
    return f"{found}: if it starts again there, give what it is wrapped by (--wrap)"


def _jumps(position: Samples, gap: float) -> Places:
    """Steps of more than half the position's range, with rest or slow motion around them."""
    steps = np.abs(np.diff(position.values))
    steps[_gaps(position, gap)] = 0.0
    large = np.flatnonzero(steps > _JUMP * np.ptp(position.values))
    around = np.maximum(np.append(steps[1:], 0.0), np.append(0.0, steps[:-1]))
    quiet = np.maximum(around, np.median(steps) if len(steps) else 0.0)[large]
    return np.asarray(large[quiet < _QUIET * steps[large]])
