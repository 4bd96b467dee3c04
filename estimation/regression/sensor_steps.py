"""The steps that the sensors of a record round to."""

from dataclasses import dataclass

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.loops import KeptByRecord
from axisid.estimation.records import Record, quantum_of
from axisid.estimation.thresholds import MIN_STEP_DIFFERENCES

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
        velocity = 0.0 if record.velocity is None else quantum_of(record.velocity, fewest)
        if record.velocity is not None:
            # A noise of that size averages the steps out.
            changing = np.abs(np.diff(record.velocity)) > velocity / 2
            velocity *= bool(np.mean(changing) <= _MAX_DITHERED_SHARE)
        known[fewest] = SensorSteps(
            position=0.0 if record.integrated else quantum_of(record.position, fewest),
            velocity=velocity,
        )
    return known[fewest]
