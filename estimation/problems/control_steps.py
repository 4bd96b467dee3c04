"""The steps that a recorded control, or force, is rounded to."""

from dataclasses import dataclass

import numpy as np

from axisid.estimation.loops import KeptByRecord
from axisid.estimation.records import Record, quantum_of
from axisid.estimation.thresholds import MIN_STEP_DIFFERENCES

# steps in the whole range; half of one is then 0.05 %: measured on a quiet axis, 64 steps moved a
# viscous friction by 2.3 %, four deviations, 256 by a quarter of one
_MAX_CONTROL_STEPS = 1024

_KNOWN: KeptByRecord[str, float] = KeptByRecord()


@dataclass(frozen=True, slots=True)
class ControlSteps:
    """Which column the force is made of, and what it is rounded to; 0 where that is no matter."""

    role: str
    size: float

    @classmethod
    def of(cls, record: Record) -> "ControlSteps":
        """Of a record's force, or else its control."""
        role = "control" if record.force is None else "force"
        values = getattr(record, role)
        if values is None:
            return cls(role, 0.0)
        known = _KNOWN.of(record)
        if role not in known:
            known[role] = quantum_of(values, int(MIN_STEP_DIFFERENCES.value))
        step = known[role]
        few = float(np.ptp(values)) < _MAX_CONTROL_STEPS * step
        return cls(role, step if few else 0.0)
