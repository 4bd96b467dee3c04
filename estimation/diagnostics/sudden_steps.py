"""Sudden steps of the recorded position: lost samples, repeated samples, and a stuck encoder.

A step is the change of the position from one sample to the next. A body with inertia moves in one
sample period by nearly as much as in the period before. A step is sudden if it is larger, or
smaller, than both neighbouring steps by more than twice the largest second difference of the
position elsewhere in the record. The position must be in motion before or after the step, because a
short move from rest to rest can fall into one sample period.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.estimation.findings import Finding
from axisid.estimation.records import Record, wild_steps
from axisid.estimation.verdict_checks import Check
from axisid.support.arrays import Array, mask_of, runs

SUDDEN_STEPS = "sudden steps"
_WINDOW = 10  # steps before or after a sudden step, which show motion or rest
_LEAST_SURPLUS = 3  # by which the steps of a motion in one direction outnumber those in the other
# size of a step relative to the missed motion, up to which a stuck encoder catches up
_STUCK = 2.0
_WHOLE_RANGE = 0.9  # of the range of recorded positions, from which a step back is a new turn

#: Most likely cause of a sudden step.
Cause = Literal[
    "new turn", "repeated sample", "stuck encoder", "lost samples", "lost samples or counts"
]


@dataclass(frozen=True, slots=True)
class SuddenStep:
    """A sudden step of a position, between one sample and the next.

    Attributes
    ----------
    place : int
        Index of the sample before the step.
    size : float
        Change of the position in the step, m or rad.
    motion : float
        Mean of the steps after this step, or, at rest there, of the steps before it, m or rad.
    neighbour : float
        Size of the smaller of the two neighbouring steps, m or rad.
    held : int
        Number of steps of 0 directly before this step.
    is_asked : bool
        Whether the reference has a sudden step at the same sample.
    range : float
        Difference of the largest and the smallest recorded position, m or rad.
    """

    place: int
    size: float
    motion: float
    neighbour: float
    held: int
    is_asked: bool
    range: float

    @property
    def is_new_turn(self) -> bool:
        """True if the position jumps back by its whole range, as an angle within one turn does."""
        return self.size * self.motion < 0 and abs(self.size) >= _WHOLE_RANGE * self.range

    @property
    def is_repeat(self) -> bool:
        """True if the step is smaller than both neighbouring steps: a sample is repeated."""
        return abs(self.size) < self.neighbour

    @property
    def is_release(self) -> bool:
        """True if the position stood still and then catches up: the encoder was stuck."""
        missed = (self.held + 1) * abs(self.motion)
        return self.held > 0 and abs(self.size) <= _STUCK * missed

    @property
    def cause(self) -> Cause:
        """Most likely cause of the step."""
        if self.is_new_turn:
            return "new turn"
        if self.is_repeat:
            return "repeated sample"
        if self.is_asked:
            return "lost samples"
        return "stuck encoder" if self.is_release else "lost samples or counts"


@dataclass(frozen=True, slots=True, kw_only=True)
class SuddenSteps(Finding):
    """The number of sudden steps of a position, and the largest of them.

    Attributes
    ----------
    number : int
        Number of sudden steps.
    size : float or None
        Change of the position in the largest step, in `unit`; None without a step.
    unit : str
        Unit of the position.
    seconds : float or None
        Time of the largest step in the log; None without a step.
    cause : str or None
        Most likely cause of the largest step, see `SuddenStep.cause`; None without a step.
    held : int
        Sample periods directly before the largest step in which the position stood still.
    is_in_reference : bool
        Whether the reference has a sudden step at the same sample.
    """

    number: int
    unit: str
    size: float | None = None
    seconds: float | None = None
    cause: Cause | None = None
    held: int = 0
    is_in_reference: bool = False


def sudden_steps(record: Record) -> list[SuddenStep]:
    """Return the sudden steps of a recorded position between samples that are not masked.

    A step counts only if the position is in motion in the steps after it, or before it.
    """
    # Samples before a sudden step of the reference.
    spans = _unmasked_spans(record)
    asked: set[int] = set()
    if record.reference is not None:
        asked = set(wild_steps(record.reference, spans).tolist())
    moved = np.diff(record.position)
    # Index of the last step before each sample that is not 0; -1 if there is none.
    moving = np.where(moved != 0, np.arange(len(moved)), -1)
    last_moving = np.concatenate([[-1], np.maximum.accumulate(moving)])
    # Bounds of the pieces, and range of their positions.
    starts, stops = np.array(spans).T
    positions = np.concatenate([record.position[start:stop] for start, stop in spans])
    position_range = float(np.ptp(positions))
    found = []
    for place in wild_steps(record.position, spans).tolist():
        piece = int(np.searchsorted(starts, place, side="right")) - 1
        begin, end = int(starts[piece]), int(stops[piece]) - 1
        before = _mean_motion(moved[max(place - _WINDOW, begin) : place])
        after = _mean_motion(moved[place + 1 : min(place + 1 + _WINDOW, end)])
        motion = after or before
        if not motion:
            continue
        step = SuddenStep(
            place=place,
            size=float(moved[place]),
            motion=motion,
            neighbour=float(min(abs(moved[place - 1]), abs(moved[place + 1]))),
            held=place - 1 - max(int(last_moving[place]), begin - 1),
            is_asked=place in asked,
            range=position_range,
        )
        found.append(step)
    return found


def _unmasked_spans(record: Record) -> list[tuple[int, int]]:
    """Return the pieces of a record between gaps and masked samples.

    A piece is the pair of the index of its first sample and the index after its last sample. If
    all samples are masked, the pieces are those between gaps.
    """
    kept = ~mask_of(record.masked, len(record))
    pieces = [piece for start, stop in record.spans for piece in runs(kept[start:stop], start)]
    return pieces or list(record.spans)


def _mean_motion(steps: Array) -> float:
    """Return the mean of some steps of the position, m or rad; 0 unless most have one direction."""
    surplus = abs(float(np.sign(steps).sum()))
    if surplus < _LEAST_SURPLUS:
        return 0.0
    return float(steps.mean())


def sudden_steps_check(axis: GeneratedAxis, record: Record) -> Check | None:
    """Return the check that the recorded position has no sudden step.

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
        source="number of sudden steps of the recorded position. A step is sudden if it differs "
        "from its neighbouring steps by more than twice the largest second difference of the "
        "position elsewhere in the record",
        finding=_finding_of(found, record, axis.coordinate.unit),
    )


def _finding_of(found: list[SuddenStep], record: Record, unit: str) -> SuddenSteps:
    """Return the finding of sudden steps, with the largest of them."""
    if not found:
        return SuddenSteps(number=0, unit=unit)
    largest = max(found, key=_size)
    return SuddenSteps(
        number=len(found),
        unit=unit,
        size=largest.size,
        seconds=float(record.time[largest.place]),
        cause=largest.cause,
        held=largest.held,
        is_in_reference=largest.is_asked,
    )


def _size(step: SuddenStep) -> float:
    """Return the absolute change of the position in a step, m or rad."""
    return abs(step.size)
