"""Records side by side, and what is estimated of each."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.estimation.loops import (
    START_SAMPLES,
    at_rest_misses,
    below_limit,
    first_velocities,
    law_memory,
    loop_starts,
)
from axisid.estimation.records import Record
from axisid.support.arrays import Array, Exact
from axisid.support.errors import UsageError

#: How a lane was identified: among others, or as `identify` does it alone.
SIDE_BY_SIDE, ALONE, FAILED = "side by side", "alone", "failed"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecordLanes(Exact):
    """Records of one reference, one a lane, SI.

    Attributes
    ----------
    reference : (N,) array
    position, control : (N, B) array
        Measured, in contiguous memory.
    period : float
        That of the control law, s.
    resolution : float
        Of the encoder; lanes that have one are identified one by one.

    Raises
    ------
    UsageError
        The shapes do not belong together.
    """

    reference: Array
    position: Array
    control: Array
    period: float
    resolution: float = 0.0

    def __post_init__(self) -> None:
        shape = np.shape(self.position)
        if len(shape) != 2 or np.shape(self.control) != shape or len(self.reference) != shape[0]:
            raise UsageError(
                f"the reference has the shape {np.shape(self.reference)}, positions {shape}, "
                f"controls {np.shape(self.control)}; give (N,), (N, B) and (N, B).",
                code="simulation-input",
            )

    def __len__(self) -> int:
        return int(self.position.shape[1])

    def record(self, lane: int) -> Record:
        """One lane as a record."""
        return Record(
            time=self.period * np.arange(float(len(self.reference))),
            position=self.position[:, lane],
            reference=self.reference,
            control=self.control[:, lane],
            sample_period=self.period,
        )

    def part(self, lanes: slice) -> "RecordLanes":
        """Some of the lanes."""
        return RecordLanes(
            reference=self.reference,
            position=np.ascontiguousarray(self.position[:, lanes]),
            control=np.ascontiguousarray(self.control[:, lanes]),
            period=self.period,
            resolution=self.resolution,
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LaneEstimates(Exact):
    """Estimates by one method, one a lane; NaN where there is none.

    Attributes
    ----------
    values : (B, p) array
        Physical parameters, SI.
    deviations : mapping of str to (B, p) array
        By name of `COVARIANCES`.
    freedom : mapping of str to (B, p) array
        Their degrees of freedom.
    iterations : (B,) array of int
    how : tuple of str
        Of each lane: ``side by side``, ``alone`` or ``failed``.
    errors : mapping of int to str
        Why, of lanes that failed.
    """

    values: Array
    deviations: Mapping[str, Array]
    freedom: Mapping[str, Array]
    iterations: NDArray[np.int64]
    how: tuple[str, ...]
    errors: Mapping[int, str]


def lane_starts(
    axis: GeneratedAxis,
    reference: Array,
    position: Array,
    control: Array,
    period: float,
    record: Callable[[int], Record],
) -> tuple[LoopStart, NDArray[np.bool_]]:
    """Starts as `loop_starts` has them of each, and of which lanes that is so.

    Lanes begin with what the law declares for an axis at rest; those whose first controls say
    otherwise are the others.

    Parameters
    ----------
    axis : GeneratedAxis
        With a sampled law, whose drive acts at once.
    reference : (N,) array
    position, control : (N, L) array
    period : float
        s
    record : callable
        Gives a lane as a record.
    """
    velocity = first_velocities(position, period)
    start = LoopStart(position=position[0].copy(), velocity=velocity, memory=None)
    rests = np.ones(len(velocity), dtype=bool)
    law = axis.axis.control
    if law is None or not law_memory(axis):
        return start, rests
    if law.balanced or law.takes_velocity:
        found = [loop_starts(axis, record(lane))[0].memory for lane in range(len(velocity))]
        return start, np.array([memory is None for memory in found])
    first = control[:START_SAMPLES]
    off = first - _at_rest(axis, reference, position, len(first))
    power = np.mean(control**2, axis=0)
    return start, np.asarray(~at_rest_misses(off, below_limit(axis, first), power))


def _at_rest(axis: GeneratedAxis, reference: Array, position: Array, samples: int) -> Array:
    """The first controls of the law of an axis that rested before, (samples, L)."""
    lanes = position.shape[1]
    commanded = np.broadcast_to(reference[:samples, None], (samples, lanes)).copy()
    (state,) = axis.evaluate("control_start", commanded[0], position[0])
    made = np.empty((samples, lanes))
    for k in range(samples):
        read = (commanded[k], position[k], np.zeros(lanes))
        control, state = axis.evaluate("control_law", *read, state)
        made[k] = control[:, 0]
    return made
