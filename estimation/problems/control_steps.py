"""The steps that a recorded control, or force, is rounded to."""

from dataclasses import dataclass, replace

import numpy as np

from axisid.estimation.loops import KeptByRecord
from axisid.estimation.records import Record
from axisid.estimation.records.faults import quantum_of
from axisid.estimation.signals import FilteredRecord
from axisid.estimation.thresholds.regression import MAX_CONTROL_STEPS, MIN_STEP_DIFFERENCES

_KNOWN: KeptByRecord[str, float] = KeptByRecord()


@dataclass(frozen=True, slots=True)
class ControlSteps:
    """Which column the force is made of, and what it is rounded to; 0 where that is no matter."""

    role: str
    size: float

    @classmethod
    def of(cls, record: Record) -> "ControlSteps":
        """Of a record's force, or else its control."""
        role = cls.role_of(record, 0.0).role
        values = getattr(record, role)
        if values is None:
            return cls(role, 0.0)
        known = _KNOWN.of(record)
        if role not in known:
            known[role] = quantum_of(values, int(MIN_STEP_DIFFERENCES.value))
        step = known[role]
        few = float(np.ptp(values)) < MAX_CONTROL_STEPS.value * step
        return cls(role, step if few else 0.0)

    @classmethod
    def role_of(cls, record: Record, size: float) -> "ControlSteps":
        """Steps of a size, of the column that a record's force is made of."""
        return cls("control" if record.force is None else "force", size)

    def rounded(self, data: FilteredRecord, share: float) -> FilteredRecord:
        """A record whose column is rounded so, the steps `share` of one away from whole ones."""
        values = getattr(data.record, self.role)
        column = (np.round(values / self.size + share) - share) * self.size
        record = (
            replace(data.record, force=column)
            if self.role == "force"
            else replace(data.record, control=column)
        )
        return replace(data, record=record)
