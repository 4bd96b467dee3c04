"""`identify` of many records of one reference, side by side."""

from dataclasses import replace
from typing import Any

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis, as_generated
from axisid.estimation.estimates import COVARIANCES, covariance_of
from axisid.estimation.identification import identify
from axisid.estimation.records import is_same_period
from axisid.estimation.signals import FilteredRecord, Prefilter
from axisid.modeling.declaration import Axis
from axisid.support.errors import AxisidError

from .batched_iv import LaneFits, fitted_lanes
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
    shape = len(lanes), len(generated.parameters)
    values, iterations = np.full(shape, np.nan), np.zeros(len(lanes), dtype=np.int64)
    deviations, freedom = ({name: np.full(shape, np.nan) for name in COVARIANCES} for _ in range(2))
    how, errors = [SIDE_BY_SIDE] * len(lanes), dict[int, str]()
    covariances = [covariance_of(name, lags) for name in COVARIANCES]
    served = not (settings or lanes.resolution) and is_served(generated, lanes.period, method)
    for first in range(0, len(lanes), _BLOCK):
        part = lanes.part(slice(first, first + _BLOCK))
        fits = _block_fits(generated, part, asked) if served else {}
        for place, lane in enumerate(range(first, first + len(part))):
            try:
                if place in fits:
                    solution, steps = fits[place]
                    with np.errstate(all="ignore"):
                        applied = [covariance.applied(solution) for covariance in covariances]
                    spread = [(each.matrix, each.freedom) for each in applied]
                    values[lane], iterations[lane] = solution.theta, steps
                else:
                    how[lane], chosen = ALONE, {"lags": lags, "bootstrap": 0, **settings}
                    result = identify(generated, part.record(place), asked, [method], **chosen)
                    found = result[method]
                    spread = [
                        (found.covariances[name], found.freedom[name]) for name in COVARIANCES
                    ]
                    values[lane] = found.physical
                    iterations[lane] = max(len(found.iterates) - 1, 0)
            except AxisidError as error:
                how[lane], errors[lane] = FAILED, str(error)
                continue
            for name, (matrix, of_one) in zip(COVARIANCES, spread, strict=True):
                deviations[name][lane] = np.sqrt(np.maximum(np.diag(matrix), 0.0))
                freedom[name][lane] = of_one
    return LaneEstimates(
        values=values,
        deviations=deviations,
        freedom=freedom,
        iterations=iterations,
        how=tuple(how),
        errors=errors,
    )


def _block_fits(axis: GeneratedAxis, lanes: RecordLanes, asked: Prefilter) -> LaneFits:
    """Fits of the lanes of a block side by side, but for those that go alone."""
    try:
        keep = replace(asked, reversals="keep")
        template = FilteredRecord.bind(axis, lanes.record(0), keep)
    except AxisidError:
        return {}  # they are told why where they go alone
    with np.errstate(all="ignore"):  # what is not finite goes alone too
        return fitted_lanes(LaneBlock(axis=axis, lanes=lanes, template=template), asked)
