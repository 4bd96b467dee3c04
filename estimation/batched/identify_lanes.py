"""`identify` of many records of one reference, side by side."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis, as_generated
from axisid.estimation.batched.rows import (
    ALONE,
    FAILED,
    SIDE_BY_SIDE,
    Block,
    LaneEstimates,
    RecordLanes,
)
from axisid.estimation.estimates import COVARIANCES
from axisid.estimation.identification import identify
from axisid.estimation.signals import FilteredRecord, Prefilter
from axisid.modeling.declaration import Axis
from axisid.support.errors import AxisidError

from .deviations import lane_deviations
from .first_fit import fitted_lanes
from .served import METHOD, is_served

_BLOCK = 32  # lanes side by side: those that are simulated together


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
    asked = Prefilter() if prefilter is None else prefilter
    found = _FoundLanes(generated, len(lanes))
    served = is_served(generated, lanes, method, settings)
    for first in range(0, len(lanes), _BLOCK):
        part = lanes.part(slice(first, first + _BLOCK))
        well = np.zeros(len(part), dtype=bool)
        if served:
            block = _block(generated, part, asked)
            if block is not None:
                with np.errstate(all="ignore"):  # what is not finite goes alone, and is told there
                    well = found.add_block(first, block, asked, lags)
        for lane in map(int, np.flatnonzero(~well)):
            chosen = {"lags": lags, "bootstrap": 0, **settings}
            found.add_alone(first + lane, part, lane, method, asked, chosen)
    return found.estimates


def _block(axis: GeneratedAxis, part: RecordLanes, asked: Prefilter) -> Block | None:
    """Lanes behind a filter; None where it does not serve the first, whom it is told alone."""
    try:
        template = FilteredRecord.bind(axis, part.record(0), replace(asked, reversals="keep"))
    except AxisidError:
        return None
    return Block(axis=axis, lanes=part, template=template)


class _FoundLanes:
    """Estimates as they come."""

    def __init__(self, axis: GeneratedAxis, lanes: int) -> None:
        shape = lanes, len(axis.parameters)
        self._axis = axis
        self._errors: dict[int, str] = {}
        self._how = [SIDE_BY_SIDE] * lanes
        self._made = LaneEstimates(
            values=np.full(shape, np.nan),
            deviations={name: np.full(shape, np.nan) for name in COVARIANCES},
            freedom={name: np.full(shape, np.nan) for name in COVARIANCES},
            iterations=np.zeros(lanes, dtype=np.int64),
            how=(),
            errors={},
        )

    @property
    def estimates(self) -> LaneEstimates:
        """All of them."""
        return replace(self._made, how=tuple(self._how), errors=self._errors)

    def add_block(
        self, first: int, block: Block, asked: Prefilter, lags: int | None
    ) -> NDArray[np.bool_]:
        """Identify a block side by side; returns which of its lanes went well, (L,)."""
        fits = fitted_lanes(block, asked)
        spread = lane_deviations(block, fits, lags)
        well = fits.well & block.starts[1]
        lanes, made = first + np.flatnonzero(well), self._made
        made.values[lanes] = fits.theta[well]
        made.iterations[lanes] = fits.iterations[well]
        for name in COVARIANCES:
            made.deviations[name][lanes] = spread.deviations[name][well]
            made.freedom[name][lanes] = spread.freedom[name][well]
        return well

    def add_alone(
        self,
        to: int,
        part: RecordLanes,
        lane: int,
        method: str,
        asked: Prefilter,
        settings: Mapping[str, Any],
    ) -> None:
        """Identify one lane as a record of its own."""
        self._how[to], made = ALONE, self._made
        try:
            result = identify(self._axis, part.record(lane), asked, [method], **settings)[method]
            made.values[to] = result.physical
            made.iterations[to] = max(len(result.iterates) - 1, 0)
            for name, matrix in result.covariances.items():
                made.deviations[name][to] = np.sqrt(np.maximum(np.diag(matrix), 0.0))
                made.freedom[name][to] = result.freedom[name]
        except AxisidError as error:
            self._how[to], self._errors[to] = FAILED, str(error)
