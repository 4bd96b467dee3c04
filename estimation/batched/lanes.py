"""Records side by side, and what is estimated of each."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
                code="lane-shapes",
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
