"""Sudden steps of the recorded position: lost samples, repeated samples, and a stuck encoder.

A body with inertia moves in one sample period by nearly as much as in the period before. A step is
sudden if it is larger or smaller than both neighbouring steps, and the difference is more than
twice the largest change between steps elsewhere in the record. The position must be in motion
directly before or after it, because a short move from rest to rest can fall into one sample period.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from axisid.estimation.records import Record, wild_steps
from axisid.estimation.verdict_checks import Check
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array, mask_of

SUDDEN_STEPS = "sudden steps"
_FEWEST_HELD = 2  # steps of 0 before a sudden step, from which the encoder was stuck
_IN_MOTION = 3  # steps in one direction, next to each other, by which the position is in motion


@dataclass(frozen=True, slots=True)
class SuddenStep:
    """A sudden step of a position, between one sample and the next.

    Attributes
    ----------
    place : int
        The sample before the step.
    size : float
        Change of the position in the step, m or rad.
    neighbour : float
        Change of the position in a neighbouring step that belongs to the motion, m or rad.
    held : int
        Number of steps of 0 directly before it.
    is_asked : bool
        Whether the reference makes a sudden step at the same place.
    """

    place: int
    size: float
    neighbour: float
    held: int
    is_asked: bool

    @property
    def is_against_motion(self) -> bool:
        """Whether the position jumps back, against the direction of its motion."""
        return self.size * self.neighbour < 0

    @property
    def is_repeat(self) -> bool:
        """Whether the step is smaller than the motion, as where a sample is recorded twice."""
        return abs(self.size) < abs(self.neighbour)


def sudden_steps(record: Record) -> list[SuddenStep]:
    """Return the sudden steps of a recorded position, except those next to a masked sample."""
    masked = mask_of(record.masked, len(record))
    steps = [step for start, stop in record.spans for step in _steps_of(record, start, stop)]
    return [step for step in steps if not masked[step.place : step.place + 2].any()]


def _steps_of(record: Record, start: int, stop: int) -> Iterator[SuddenStep]:
    """Yield the sudden steps of a piece without gaps."""
    position = record.position[start:stop]
    moved = np.diff(position)
    asked: set[int] = set()
    if record.reference is not None:
        asked = set(wild_steps(record.reference[start:stop]).tolist())
    for place in wild_steps(position).tolist():
        moving = np.flatnonzero(moved[:place])
        held = place - 1 - int(moving[-1]) if len(moving) else 0
        before = _motion(moved[max(place - _IN_MOTION, 0) : place][::-1])
        after = _motion(moved[place + 1 : place + 1 + _IN_MOTION])
        neighbour = after or before
        if neighbour:
            yield SuddenStep(start + place, float(moved[place]), neighbour, held, place in asked)


def _motion(steps: Array) -> float:
    """Return the first of some steps if all have one direction; 0 if the position rests."""
    in_one_direction = np.all(steps > 0) or np.all(steps < 0)
    if len(steps) < _IN_MOTION or not in_one_direction:
        return 0.0
    return float(steps[0])


def sudden_steps_check(axis: Axis, record: Record) -> Check | None:
    """Check that the recorded position has no sudden step.

    None for a record whose position was integrated from its velocity.
    """
    if record.integrated:
        return None
    found = sudden_steps(record)
    meaning = "no single step of the position stands out"
    if found:
        meaning = _meaning(axis, record, found)
    return Check(
        name=SUDDEN_STEPS,
        status="fail" if found else "pass",
        figure=float(len(found)),
        threshold=0.0,
        source="steps unlike both neighbours, by twice the largest change between steps elsewhere",
        meaning=meaning,
    )


def _meaning(axis: Axis, record: Record, found: list[SuddenStep]) -> str:
    largest = max(found, key=_size)
    others = ""
    if len(found) > 1:
        others = f" (one of {len(found)} such steps)"
    return (
        f"the position moves by {largest.size:.3g} {axis.coordinate.unit} in one sample period, "
        f"{record.time[largest.place]:.6g} s into the log{others}, unlike the periods before and "
        f"after it. {_cause_and_remedy(largest)}"
    )


def _cause_and_remedy(step: SuddenStep) -> str:
    if step.is_against_motion:
        return (
            "It jumps against its motion, as a position that starts again after a turn, or an "
            "encoder that loses counts. If it starts again, declare its range with wrap, or unwrap "
            "the position first; else mend the encoder"
        )
    mend = "Leave these places out with windows, or mend the recorder"
    if step.is_asked and step.is_repeat:
        return f"The reference does the same: a sample is recorded twice. {mend}"
    if step.is_asked:
        return f"The reference does the same: samples are missing. {mend}"
    if step.held >= _FEWEST_HELD:
        stood = f"The position stood still for {step.held} periods before"
        return f"{stood}: the encoder was stuck. {mend}"
    return f"Samples are missing there, or the encoder lost counts. {mend}"


def _size(step: SuddenStep) -> float:
    return abs(step.size)
