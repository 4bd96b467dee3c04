"""Steps of the position that no body makes: lost samples, and an encoder that stood still.

A body with inertia moves by nearly as much in one step of time as in the one before. Where a single
step is larger or smaller than both of its neighbours, by more than twice what the steps change
anywhere else, something other than the motion has happened: samples are missing that the times do
not show, or the recorded position stood still and then caught up.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from axisid.estimation.records import Record, wild_steps
from axisid.estimation.verdict_checks import Check
from axisid.modeling.declaration import Axis

SUDDEN_STEPS = "sudden steps"
_FEWEST_HELD = 2  # steps of 0 before a sudden one, from which the encoder stood still


@dataclass(frozen=True, slots=True)
class SuddenStep:
    """A step of a position, between one sample and the next.

    Attributes
    ----------
    place : int
        The sample before it.
    size : float
        By how much the position moves, m or rad.
    held : int
        How many steps of 0 stand directly before it, where the position moved before them.
    is_asked : bool
        Whether the reference makes such a step at the same place.
    """

    place: int
    size: float
    held: int
    is_asked: bool


def sudden_steps(record: Record) -> list[SuddenStep]:
    """The sudden steps of a recorded position, but for those to or from a masked sample."""
    steps = [step for start, stop in record.spans for step in _steps_of(record, start, stop)]
    return [step for step in steps if not _is_masked(record, step.place)]


def _is_masked(record: Record, place: int) -> bool:
    """Whether the sample before a step, or the one after it, is masked."""
    return any(start - 1 <= place < stop for start, stop in record.masked)


def _steps_of(record: Record, start: int, stop: int) -> Iterator[SuddenStep]:
    """Those of a piece without gaps."""
    position = record.position[start:stop]
    moved = np.diff(position)
    asked: set[int] = set()
    if record.reference is not None:
        asked = set(map(int, wild_steps(record.reference[start:stop])))
    for place in map(int, wild_steps(position)):
        before = np.flatnonzero(moved[:place])
        held = place - 1 - int(before[-1]) if len(before) else 0
        yield SuddenStep(start + place, float(moved[place]), held, place in asked)


def sudden_steps_check(axis: Axis, record: Record) -> Check | None:
    """Whether the recorded position moves as a body does.

    None for a record whose position was integrated from its velocity.
    """
    if record.integrated:
        return None
    found = sudden_steps(record)
    return Check(
        name=SUDDEN_STEPS,
        status="fail" if found else "pass",
        figure=float(len(found)),
        threshold=0.0,
        source="steps unlike both of their neighbours, by twice what the steps change elsewhere",
        meaning=_meaning(axis, record, found)
        if found
        else "no single step of the position stands out",
    )


def _meaning(axis: Axis, record: Record, found: Sequence[SuddenStep]) -> str:
    first = max(found, key=_size)
    others = f" (one of {len(found)} such steps)" if len(found) > 1 else ""
    text = (
        f"the position moves by {first.size:.3g} {axis.coordinate.unit} in one step, "
        f"{record.time[first.place]:.6g} s into the log{others}, which no body does. "
    )
    if first.is_asked:
        text += "The reference does the same: samples are missing there, or are there twice. "
    elif first.held >= _FEWEST_HELD:
        text += f"It stood still for {first.held} samples before: the encoder was stuck. "
    else:
        text += "Samples are missing there, or the encoder lost counts. "
    return text + "Leave these places out with windows, or mend the recorder"


def _size(step: SuddenStep) -> float:
    return abs(step.size)
