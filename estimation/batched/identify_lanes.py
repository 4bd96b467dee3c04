"""`identify` of many records of one reference, side by side."""

from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis, as_generated
from axisid.estimation.estimates import COVARIANCES
from axisid.estimation.identification import identify
from axisid.estimation.records import is_same_period
from axisid.estimation.signals import FilteredRecord, Prefilter
from axisid.modeling.declaration import Axis
from axisid.support.errors import AxisidError

from .batched_iv import fitted_lanes, lane_numbers
from .block import ALONE, FAILED, SIDE_BY_SIDE, LaneBlock, LaneEstimates, RecordLanes

#: The method of which lanes go side by side.
METHOD = "idm-iv"
_BLOCK = 32  # lanes side by side: those that are simulated together


def is_served(axis: GeneratedAxis, period: float, method: str) -> bool:
    """Whether lanes of an axis go side by side, of a period in s; else they go one by one.

    That is instruments of a linear model whose drive acts at once, of a law that is evaluated at
    the samples, where there is a compiler.
    """
    declared = axis.axis
    law, drive = declared.control, declared.drive
    return (
        method == METHOD
        and axis.is_linear
        and not (axis.unidentifiable or declared.signals or declared.drives_by_motion)
        and axis.declared.drive.estimated is None
        and declared.response is None
        and drive.path.is_plain
        and not drive.logs_what_acts
        and law is not None
        and not law.continuous
        and is_same_period(period, law.period)
        and axis.native.lanes is not None
    )


def identify_lanes(
    axis: Axis | GeneratedAxis,
    lanes: RecordLanes,
    method: str = METHOD,
    prefilter: Prefilter | None = None,
    *,
    lags: int | None = None,
    **settings: Any,
) -> LaneEstimates:
    """Identify records of one reference by one method, side by side.

    Each lane is what `identify` makes of its record without twins, but for rounding: it is
    filtered, simulated and solved beside others in compiled code. What cannot go so is identified
    alone: an axis of another kind, an encoder's steps, a lane that takes another course than most.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
    lanes : RecordLanes
    method : str
        Of `METHODS`; ``idm-iv`` goes side by side.
    prefilter : Prefilter, optional
        As `identify` takes it.
    lags : int, optional
        As `identify` takes them.
    **settings
        What else `identify` takes; with any of them lanes are identified alone.

    Returns
    -------
    LaneEstimates

    Raises
    ------
    UsageError
        The prefilter is none.
    """
    generated = as_generated(axis)
    asked = Prefilter.given(prefilter)
    # Of each lane values, then deviations and their degrees of freedom by covariance.
    numbers = np.full((len(lanes), 1 + 2 * len(COVARIANCES), len(generated.parameters)), np.nan)
    iterations = np.zeros(len(lanes), dtype=np.int64)
    how, errors = [SIDE_BY_SIDE] * len(lanes), dict[int, str]()
    served = not (settings or lanes.resolution) and is_served(generated, lanes.period, method)
    for first in range(0, len(lanes), _BLOCK):
        part = lanes.part(slice(first, first + _BLOCK))
        well = np.zeros(len(part), dtype=bool)
        template = None
        with suppress(AxisidError):  # what it refuses goes alone, and is told there
            keep = replace(asked, reversals="keep")
            template = FilteredRecord.bind(generated, part.record(0), keep) if served else None
        if template is not None:
            block = LaneBlock(axis=generated, lanes=part, template=template)
            with np.errstate(all="ignore"):  # what is not finite goes alone too
                fits = fitted_lanes(block, asked)
                made = lane_numbers(block, fits, lags)
            well = fits.sound & block.starts[1]
            beside = first + np.flatnonzero(well)
            numbers[beside], iterations[beside] = made[well], fits.iterations[well]
        for lane in map(int, first + np.flatnonzero(~well)):
            how[lane], chosen = ALONE, {"lags": lags, "bootstrap": 0, **settings}
            try:
                alone = identify(generated, lanes.record(lane), asked, [method], **chosen)[method]
                variances = [np.diag(alone.covariances[name]) for name in COVARIANCES]
                freedom = [alone.freedom[name] for name in COVARIANCES]
                deviations = np.sqrt(np.maximum(variances, 0.0))
                numbers[lane] = [alone.physical, *deviations, *freedom]
                iterations[lane] = max(len(alone.iterates) - 1, 0)
            except AxisidError as error:
                how[lane], errors[lane] = FAILED, str(error)
    values, *rest = np.ascontiguousarray(numbers.transpose(1, 0, 2))
    return LaneEstimates(
        values=values,
        deviations=dict(zip(COVARIANCES, rest, strict=False)),
        freedom=dict(zip(COVARIANCES, rest[len(COVARIANCES) :], strict=True)),
        iterations=iterations,
        how=tuple(how),
        errors=errors,
    )
