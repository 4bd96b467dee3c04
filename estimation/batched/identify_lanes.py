"""`identify` of many records of one reference, side by side."""

from dataclasses import replace
from typing import Any

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis, as_generated
from axisid.estimation.estimates import COVARIANCES
from axisid.estimation.identification import identify
from axisid.estimation.records import is_same_period
from axisid.estimation.regression import CovarianceEstimate, Hac, Solution, most_lags
from axisid.estimation.signals import FilteredRecord, Prefilter, RowTimes
from axisid.estimation.thresholds import FEW_SCORES
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array
from axisid.support.errors import AxisidError

from .block import ALONE, FAILED, SIDE_BY_SIDE, Block, LaneEstimates, RecordLanes
from .iteration import LaneFits, combined, fitted_lanes, inverse_products

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
        block = _block(generated, part, asked) if served else None
        well = np.zeros(len(part), dtype=bool)
        if block is not None:
            with np.errstate(all="ignore"):  # what is not finite goes alone, and is told there
                fits = fitted_lanes(block, asked)
                made = _lane_numbers(block, fits, lags)
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


def _block(axis: GeneratedAxis, part: RecordLanes, asked: Prefilter) -> Block | None:
    """Lanes behind a filter; None where it does not serve the first, whom it is told alone."""
    try:
        template = FilteredRecord.bind(axis, part.record(0), replace(asked, reversals="keep"))
    except AxisidError:
        return None
    return Block(axis=axis, lanes=part, template=template)


def _lane_numbers(block: Block, fits: LaneFits, lags: int | None) -> Array:
    """Values, deviations and their degrees of freedom, (L, 1 + 2 c, p), of lanes that ended well.

    Of no meaning for the others.
    """
    (rows, k), shape = fits.instruments.shape[:2], fits.theta.shape
    n, model = fits.counts[:, None], Hac(lags)
    inverse = inverse_products(block.library, fits.instruments)
    scores = combined(fits.instruments, fits.mixing) * fits.residuals[:, None]
    most = (most_lags(rows) if lags is None else lags) + 2
    lagged = block.library.lagged(scores, min(most, rows - 1))
    variances = {
        "iid": fits.power[:, None] / (n - 1) * np.diagonal(inverse, axis1=1, axis2=2),
        "robust": n / (n - k) * lagged[0].T,
        "hac": np.full(shape, np.nan),
    }
    freedom = {name: np.broadcast_to(n - k, shape).copy() for name in variances}
    for lane in map(int, np.flatnonzero(fits.sound)):
        applied = _by_products(model, lagged[:, :, lane], int(n[lane, 0]))
        if lags is None and applied.freedom.min() < FEW_SCORES.value:
            applied = model.applied(_lane_solution(block, fits, lane, inverse[lane]))
        variances["hac"][lane], freedom["hac"][lane] = np.diag(applied.matrix), applied.freedom
    deviations = [np.sqrt(np.maximum(variances[name], 0.0)) for name in COVARIANCES]
    return np.stack([fits.theta, *deviations, *(freedom[name] for name in COVARIANCES)], axis=1)


def _by_products(model: Hac, lagged: Array, rows: int) -> CovarianceEstimate:
    k = lagged.shape[1]
    products = lagged[:, :, None] * np.eye(k)
    return model.of_scores(lambda lags: products[: lags + 1], (rows, k))


def _lane_solution(block: Block, fits: LaneFits, lane: int, inverse: Array) -> Solution:
    """A lane's solution as if it were alone; `inverse` are ``(Z'Z)^-1``."""
    own = slice(None) if fits.rows is None else fits.rows[:, lane]
    places = block.template.row_numbers.astype(np.int64)[own]
    return Solution(
        theta=fits.theta[lane],
        residuals=np.ascontiguousarray(fits.residuals[own, lane]),
        inverse_factor=np.asarray(np.linalg.cholesky(inverse), dtype=np.float64),
        influence=fits.instruments[own, :, lane] @ fits.mixing[lane].T,
        neighbours=RowTimes.of(places, block.template.prefilter.decimate),
    )
