"""Rows of the regression as the simulated loop has them: instruments, and the model's left side."""

from collections.abc import Sequence

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.estimation.choices import OPEN_LOOP_FIT
from axisid.estimation.law_replay import (
    loop_starts,
    two_clocks,
)
from axisid.estimation.records import (
    Record,
    law_clock,
)
from axisid.estimation.signals import (
    FilteredRecord,
    recorded_signals,
)
from axisid.estimation.simulation import (
    LoopInputs,
    Simulation,
    StepBudget,
    no_control_law,
    signals_about,
    simulate_loop,
)
from axisid.support.arrays import Array
from axisid.support.errors import AxisidError, DataError, ModelError, refuse

from .inverse_and_direct import Equations, Form


class LoopDataError(DataError):
    """The record does not serve to simulate the loop."""


_WITHOUT = (
    " Least squares does without, and so does a fit of the position under the "
    f"recorded control: {OPEN_LOOP_FIT}."
)


def lacking_loop(axis: GeneratedAxis, record: Record) -> AxisidError | None:
    """Why there is no closed loop to simulate: the axis has no law, or the record no reference."""
    if axis.axis.control is None:
        return lacking_law(axis)
    return (
        None
        if record.commanded is not None
        else LoopDataError(
            f"{record.provenance.source} has no reference column, from which the closed loop "
            f"is simulated; name it with columns reference=NAME.{_WITHOUT}",
            code="missing-column",
        )
    )


def lacking_law(axis: GeneratedAxis) -> ModelError:
    """The error of an axis whose records' loop cannot be simulated, with what does without."""
    error = no_control_law(axis.axis.name)
    return ModelError(f"{error}{_WITHOUT}", code=error.code)


def loop_reference(axis: GeneratedAxis, record: Record) -> Array:
    """Reference of a loop that was both declared and recorded, (N,); anything less is refused.

    A test signal that was added to it is in it.

    Raises
    ------
    ModelError
        The axis has no control law.
    LoopDataError
        The record has no reference, or another period than the law, which nobody confirms.
    """
    law, reference = axis.axis.control, record.commanded
    if law is None or reference is None:
        raise lacking_loop(axis, record) or lacking_law(axis)
    clock = law_clock(law, record)
    refuse(
        LoopDataError,
        (clock.ratio is None and clock.doubt, clock.doubt),
        (
            clock.ratio is None,
            f"the record was resampled every {record.period:.6g} s, the control law of axis "
            f"{axis.axis.name!r} runs every {law.period:.6g} s; resample at that, or leave it out",
        ),
        (
            clock.ratio != 1 and not (axis.axis.response is None and axis.axis.drive.path.is_plain),
            f"the record is sampled every {record.period:.6g} s, the control law of axis "
            f"{axis.axis.name!r} runs every {law.period:.6g} s, and its drive has a "
            f"{' and '.join(axis.axis.of_law_samples)}: such a loop is simulated at the law's "
            "samples alone; record at the law's period, or ask for least squares",
        ),
        code="loop-period",
    )
    return reference


def simulated_loops(
    axis: GeneratedAxis,
    record: Record,
    physical: Array,
    *,
    resolution: float = 0.0,
    away: float = 0.0,
    position_noise: Array | None = None,
    disturbance: Array | None = None,
    budget: StepBudget | None = None,
    starts: Sequence[LoopStart] | None = None,
) -> tuple[Simulation, ...]:
    """The loop of a record, simulated with physical parameters (p,): once for each segment.

    Each begins as its segment does, see `loop_starts`, unless starts are given. With a resolution
    it has an encoder of such steps, which measures, and is commanded, positions that are `away`
    from those of the axis; and what its law measures has `position_noise`, (N,), if there is any; a
    `disturbance`, (N,), in the drive's unit, acts beside the control. A budget is that of a search.

    Raises
    ------
    ModelError, LoopDataError
        As in `loop_reference`.
    EstimationError
        The loop cannot be simulated with these parameters.
    """
    reference, added = loop_reference(axis, record), record.added_control
    if disturbance is not None:
        added = disturbance if added is None else added + disturbance
    noise = np.full(len(record), away) if away and position_noise is None else position_noise
    signals = recorded_signals(axis, record.provenance.source, record.signals)
    begins = loop_starts(axis, record, away) if starts is None else starts
    loops = []
    for (first, last), start in zip(record.spans, begins, strict=True):
        inputs = LoopInputs(
            reference=reference[first:last] + away,
            period=record.period,
            start=start,
            noise=None if noise is None else noise[first:last],
            injected=None if added is None else added[first:last],
            signals=tuple(values[first:last] for values in signals),
            resolution=resolution,
        ).at_law(axis, two_clocks(axis, record, (first, last)))
        loops.append(simulate_loop(axis, physical, inputs, budget=budget))
    return tuple(loops)


def simulated_position(loops: Sequence[Simulation]) -> Array:
    """Position of the loops, one after the other, (N,)."""
    return np.concatenate([loop.position for loop in loops])


def simulated_rows(
    form: Form, loops: Sequence[Simulation], physical: Array, data: FilteredRecord
) -> Equations:
    """The rows of simulated loops, reduced like the measured ones."""
    pieces = [loop_equations(form, loop, physical, data.prefilter.hold) for loop in loops]
    return Equations.stacked(pieces).reduced(data)


def loop_equations(form: Form, loop: Simulation, physical: Array, hold: str | None) -> Equations:
    """The equations of a simulated loop, sample by sample, as a hold pairs force and motion.

    With `zoh`, the rows just before and just after a sample are averaged, as the measured force is.
    """
    at = form.at(physical)
    if hold != "zoh":
        return at.equations(loop.signals)
    after, earlier = map(at.equations, signals_about(form.axis, physical, loop))
    return Equations(
        left=(after.left + earlier.left) / 2,
        intercept=(after.intercept + earlier.intercept) / 2,
        regressor=(after.regressor + earlier.regressor) / 2,
    )
