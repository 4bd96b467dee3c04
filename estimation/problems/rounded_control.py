"""What the steps of a recorded control, or force, add to the covariance of an estimate.

A converter of few bits rounds what stands on the left side. At a constant speed the control stays
within a step or two, whichever the noise lets it reach: the error is the same for a whole move, and
comes again with the next one. So neighbouring rows do not show how far it moves an estimate. The
same loops with their own control rounded, with steps that begin elsewhere, tell that.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import cycle

import numpy as np

from axisid.estimation.loops import KeptByRecord
from axisid.estimation.records import Record
from axisid.estimation.records.faults import quantum_of
from axisid.estimation.regression import (
    STEP_SHARES,
    Form,
    Hac,
    InverseForm,
    Solution,
    StepsError,
    answer_to_noise,
    quiet_loops,
    undithered_step,
)
from axisid.estimation.signals import FilteredRecord
from axisid.estimation.thresholds.regression import (
    MAX_CONTROL_STEPS,
    MIN_STEP_DIFFERENCES,
    MIN_STEPS_SCATTER,
    MIN_STEPS_SHIFT,
)
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array
from axisid.support.errors import DataError, ModelError

from .filter_bias import noise_free_record
from .noisy_loop import record_as_measured
from .problem import Problem
from .solver import Solver

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

    def told(self, axis: Axis) -> str:
        """In words."""
        unit = axis.drive.unit if self.role == "control" else axis.coordinate.force_unit
        return f"steps of {self.size:.3g} {unit} of the recorded {self.role}"

    def rounded(self, data: FilteredRecord, share: float) -> FilteredRecord:
        """A record whose column is rounded so, the steps `share` of one away from whole ones."""
        values = getattr(data.record, self.role)
        return _with_column(
            data, self.role, (np.round(values / self.size + share) - share) * self.size
        )


def control_error(
    form: Form, problem: Problem, physical: Array, solver: Solver, deviations: Array
) -> StepsError | None:
    """What the steps of the records' controls do to an estimate, deviations (k,) of its own.

    None where no record has any, they are no matter, or neighbouring rows show what they do; nor
    where the loops' own control moves in such steps, as that of a drive does which applies them.

    Raises
    ------
    ModelError, DataError, EstimationError
        A loop cannot be simulated.
    """
    steps = [ControlSteps.of(data.record) for data in problem.data]
    if not any(step.size for step in steps):
        return None
    exact = [
        cycle(_unrounded(data, form.own(physical, i), step.role))
        for i, (data, step) in enumerate(zip(problem.data, steps, strict=True))
    ]
    moved: list[Array] = []
    shown: list[Array] = []
    for share in STEP_SHARES:
        before = [next(each) for each in exact]
        if any(map(_moves_in_steps, before, steps)):
            return None
        after = [
            step.rounded(data, share) if step.size else data
            for data, step in zip(before, steps, strict=True)
        ]
        by, seen = _moved(form, problem, solver, before, after)
        moved.append(by)
        shown.append(seen)
        if np.all(np.abs(moved[0]) <= MIN_STEPS_SHIFT.value * deviations):
            return None
    return _beyond(np.array(moved), np.mean(shown, axis=0))


def _unrounded(data: FilteredRecord, physical: Array, role: str) -> Iterator[FilteredRecord]:
    """The record as its loops have it, with its noise, which decides what steps are reached.

    A loop that follows the recorded control has its steps: there the column is the fitted force's.
    """
    if data.record.reference is None:
        yield _with_column(data, role, _fitted(data, physical, role))
        return
    drawn = False
    for record in record_as_measured(data, physical):
        drawn = True
        yield record
    if not drawn:
        yield noise_free_record(data, quiet_loops(data, physical))


def _with_column(data: FilteredRecord, role: str, values: Array) -> FilteredRecord:
    record = data.record
    force = role == "force"
    other = replace(record, force=values) if force else replace(record, control=values)
    return replace(data, record=other)


def _fitted(data: FilteredRecord, physical: Array, role: str) -> Array:
    """The force of the measured motion, (N,), or its control with the law's answer to noise.

    Without a sampled law that answer is not known, and noise that moves the control by a step from
    sample to sample is taken to average the steps.
    """
    form, drive = InverseForm(data.axis).at(physical), data.axis.axis.drive
    rows = form.equations(data.signals)
    force = rows.intercept + rows.regressor @ form.regressed(physical)
    is_known = drive.is_gain and not drive.quantisation  # whose own steps are no error
    gain = float(drive.gain) if is_known else 0.0
    if not gain:
        raise DataError("a control that is not the force over a gain is not known without a loop.")
    column = force / gain if role == "control" else force
    try:
        answer = answer_to_noise(data)
    except (ModelError, DataError):
        if not undithered_step(getattr(data.record, role), int(MIN_STEP_DIFFERENCES.value)):
            raise
        return np.asarray(column, dtype=float)
    return np.asarray(column + answer * (1.0 if role == "control" else gain), dtype=float)


def _moves_in_steps(data: FilteredRecord, steps: ControlSteps) -> bool:
    """Whether a simulated column has such steps by itself."""
    values = getattr(data.record, steps.role)
    return bool(steps.size) and quantum_of(values, int(MIN_STEP_DIFFERENCES.value)) > 0


def _moved(
    form: Form,
    problem: Problem,
    solver: Solver,
    before: Sequence[FilteredRecord],
    after: Sequence[FilteredRecord],
) -> tuple[Array, Array]:
    """What one record less another moves an estimate by, (k,), and what its rows show of that."""
    one, other = (
        solver(form, problem.reduced(form, [data.signals for data in each]))
        for each in (before, after)
    )
    apart: Solution = replace(
        other, residuals=other.residuals - one.residuals, neighbours=problem.neighbours
    )
    return other.theta - one.theta, Hac().matrix(apart)


def _beyond(moved: Array, shown: Array) -> StepsError | None:
    """The covariance that rows do not show, of what was moved, (m, k)."""
    square, seen = np.mean(moved**2, axis=0), np.diag(shown)
    ratio = np.divide(square, seen, out=np.ones_like(seen), where=seen > 0)
    hidden = np.where(ratio > MIN_STEPS_SCATTER.value, np.sqrt(np.maximum(ratio - 1, 0.0)), 0.0)
    if not hidden.any():
        return None
    return StepsError(
        bias=np.zeros(len(seen)), missing=np.outer(hidden, hidden) * shown, loops=len(moved)
    )
