"""Whether the steps of a logged position, which its law did not measure, move least squares."""

import numpy as np

from axisid.estimation.checks import Check, passed
from axisid.estimation.estimates import Estimate
from axisid.estimation.problems import moved_by_rounding, position_step
from axisid.estimation.signals import FilteredRecord
from axisid.estimation.thresholds import MAX_UNSEEN_BIAS, MIN_STEPS_OF_TRAVEL, NEGLIGIBLE_BIAS
from axisid.support.errors import AxisidError
from axisid.support.missing import Missing


def coarse_positions(data: FilteredRecord, ls: Estimate) -> Check | Missing | None:
    """What the steps move least squares by; None where there are none, or it is known already.

    A control that answers to the steps has them in its loop, which tells by itself what they do.
    """
    step = position_step(data.record)
    if not step or ls.loop_rows is not None or ls.is_direct or ls.filter_bias is not None:
        return None
    try:
        moved = moved_by_rounding(ls.form, data, step, ls.physical)
    except AxisidError as error:
        return Missing.of(error.note)
    values = ls.parameters
    shifts = {
        name: (float(by), abs(float(by)) / value.deviation)
        for (name, value), by in zip(values.items(), moved, strict=True)
        if value.deviation > 0
    }
    worst = max((shift for _, shift in shifts.values()), default=0.0)
    listed = ", ".join(
        f"{name} by about {by:+.2g} {values[name].unit}"
        for name, (by, shift) in shifts.items()
        if shift > MAX_UNSEEN_BIAS.value
    )
    unit = ls.form.axis.axis.coordinate.unit
    few = float(np.ptp(data.record.position)) / step < MIN_STEPS_OF_TRAVEL.value
    good = worst <= MAX_UNSEEN_BIAS.value and not few
    large = few or any(
        shift > MAX_UNSEEN_BIAS.value and abs(by) > NEGLIGIBLE_BIAS.value * abs(values[name].value)
        for name, (by, shift) in shifts.items()
    )
    return Check(
        name="coarse positions",
        status=passed(good, matters=large),
        figure=worst,
        threshold=MAX_UNSEEN_BIAS.value,
        source="what as much noise again as the steps of the position make moves least squares "
        "by, in deviations; asked where no control answers to them, and no reference makes "
        "instruments; up to 1 % of the value that is a note",
        meaning=f"the steps of the logged position, {step:.3g} {unit}, move no parameter by more "
        "than half a deviation"
        if good
        else f"the steps of the logged position, {step:.3g} {unit}, which the control does not "
        f"answer to, move least squares{f', {listed}' * bool(listed)}"
        + few
        * f"; there are fewer than {MIN_STEPS_OF_TRAVEL.value:g} in the whole motion, so that "
        "they may move it by more than can be reckoned"
        + "; its intervals miss for it: log the position as finely as the drive measures it, "
        "record the reference, from which instruments are made, or lower the cut-off",
    )
