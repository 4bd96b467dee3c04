"""The steps that the sensors of a record round to."""

from dataclasses import dataclass

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.loops import KeptByRecord
from axisid.estimation.records import Record, quantum_of
from axisid.estimation.thresholds import MIN_STEP_DIFFERENCES
from axisid.support.arrays import Array

# of the samples change a rounded velocity; at a constant speed noise of half a step changes as
# many, and averages the steps
_MAX_DITHERED_SHARE = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorSteps:
    """What the recorded motion is rounded to, SI; 0 where nothing is known of it.

    Attributes
    ----------
    position : float
        In the loop too.
    velocity : float
        Of a measured one whose noise does not average its steps.
    """

    position: float = 0.0
    velocity: float = 0.0


_KNOWN: KeptByRecord[int, SensorSteps] = KeptByRecord()


def sensor_steps(axis: GeneratedAxis, record: Record) -> SensorSteps:
    """The steps of a record's sensors."""
    law = axis.axis.control
    if law is None or law.continuous:
        return SensorSteps()
    known, fewest = _KNOWN.of(record), int(MIN_STEP_DIFFERENCES.value)
    if fewest not in known:
        known[fewest] = SensorSteps(
            position=0.0 if record.integrated else quantum_of(record.position, fewest),
            velocity=0.0 if record.velocity is None else _undithered_step(record.velocity, fewest),
        )
    return known[fewest]


def _undithered_step(values: Array, fewest: int) -> float:
    """What values are rounded to, unless their noise is of that size: then that averages out."""
    step = quantum_of(values, fewest)
    changing = np.abs(np.diff(values)) > step / 2
    return 0.0 if np.mean(changing) > _MAX_DITHERED_SHARE else step
