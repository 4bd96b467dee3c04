"""`identify` of many records of one reference, side by side."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis, as_generated
from axisid.estimation.estimates import COVARIANCES, covariance_of
from axisid.estimation.identification import identify
from axisid.estimation.regression import Covariance, Hac, Solution, most_lags
from axisid.estimation.signals import (
    FilteredRecord,
    Information,
    Neighbours,
    Prefilter,
    losses_count,
    searches_friction,
)
from axisid.estimation.thresholds import (
    FEW_SCORES,
    MAX_SIMULATION_ERROR,
    MIN_INFORMATION_LEFT,
    MIN_MOVING_SPEED,
)
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array
from axisid.support.errors import AxisidError

from .block import Block, Chosen, LaneRows
from .iteration import LaneFits, Loops, iterated, loops_of, unexplained
from .lanes import ALONE, FAILED, SIDE_BY_SIDE, LaneEstimates, RecordLanes
from .regression import combined, fitted, inverse_products, lagged_products, solved
from .served import METHOD, clearly_shown, is_served

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
        fits = _fitted_lanes(block, asked)
        deviations, freedom = _lane_deviations(block, fits, lags)
        well = fits.well & block.starts[1]
        lanes, made = first + np.flatnonzero(well), self._made
        made.values[lanes] = fits.theta[well]
        made.iterations[lanes] = fits.iterations[well]
        for name in COVARIANCES:
            made.deviations[name][lanes] = deviations[name][well]
            made.freedom[name][lanes] = freedom[name][well]
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


def _lane_deviations(
    block: Block, fits: LaneFits, lags: int | None
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Deviations of lanes that ended well and their degrees of freedom, (L, p) each by covariance.

    Not a number for the others.
    """
    names, shape = tuple(COVARIANCES), fits.theta.shape
    deviations, degrees = ({name: np.full(shape, np.nan) for name in names} for _ in range(2))
    inverse = inverse_products(block.library, fits.instruments)
    scores = combined(fits.instruments, fits.mixing) * fits.residuals[:, None]
    lagged = _lagged(block, scores, lags)
    models = {name: covariance_of(name, lags) for name in names}
    for lane in map(int, np.flatnonzero(fits.well)):
        n, k = fits.counts[lane], shape[1]
        by_name = {
            "iid": (fits.power[lane] / (n - 1) * np.diagonal(inverse[lane]), n - k),
            "robust": (n / (n - k) * lagged[0, :, lane], n - k),
            "hac": _hac(models["hac"], lagged[:, :, lane], int(n)),
        }
        for name, (variances, freedom) in by_name.items():
            degrees[name][lane] = freedom
            if name == "hac" and lags is None and np.min(freedom) < FEW_SCORES.value:
                applied = models[name].applied(_lane_solution(block, fits, lane, inverse[lane]))
                of_few, degrees[name][lane] = np.diag(applied.matrix), applied.freedom
            else:
                of_few = variances
            deviations[name][lane] = np.sqrt(np.maximum(of_few, 0.0))
    return deviations, degrees


def _lagged(block: Block, scores: Array, lags: int | None) -> Array:
    """Products of scores (n, p, L) at as many lags as a covariance may look at."""
    most = (most_lags(len(scores)) if lags is None else lags) + 2
    return lagged_products(block.library, scores, min(most, len(scores) - 1))


def _hac(model: Covariance, lagged: Array, rows: int) -> tuple[Array, Array]:
    """Variances and degrees of freedom by a lane's scores, products (lags + 1, p) of each alone."""
    assert isinstance(model, Hac)  # noqa: S101
    k = lagged.shape[1]
    alone = lagged[:, :, None] * np.eye(k)
    found = model.long_run(lambda lags: alone[: lags + 1], rows)
    variances = rows / (rows - k) * np.diag(found.covariance)
    return variances, np.minimum(found.freedom, rows - k)


def _lane_solution(block: Block, fits: LaneFits, lane: int, inverse: Array | None) -> Solution:
    """A lane's solution as if it were alone; `inverse` are ``(Z'Z)^-1`` where they are known."""
    own = slice(None) if fits.rows is None else fits.rows[:, lane]
    places = block.template.row_numbers.astype(np.int64)[own]
    instruments = fits.instruments[own, :, lane]
    if inverse is None:
        inverse = np.asarray(np.linalg.inv(instruments.T @ instruments))
    return Solution(
        theta=fits.theta[lane],
        residuals=np.ascontiguousarray(fits.residuals[own, lane]),
        inverse_factor=np.asarray(np.linalg.cholesky(inverse), dtype=np.float64),
        influence=instruments @ fits.mixing[lane].T,
        neighbours=Neighbours.of(places, block.template.prefilter.decimate),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _FirstFit:
    """Least squares of lanes.

    Attributes
    ----------
    measured : LaneRows
    theta : (L, p) array
    loops : Loops
        Simulated with it.
    follows : (L,) array of bool
        Which loops move as the records do.
    shown : (L,) array of bool
        Which lanes show every parameter by far.
    """

    measured: LaneRows
    theta: Array
    loops: Loops
    follows: Chosen
    shown: Chosen


def _fitted_lanes(block: Block, asked: Prefilter) -> LaneFits:
    """Lanes from their samples to where the instruments' iteration ends."""
    excluded = _near_reversals(block, asked)
    shown = np.ones(len(block.lanes), dtype=bool)
    if excluded is not None:
        first = _first_fit(block, excluded, block.rows_of(excluded))
        again = block.turns(block.velocity(first.loops.position))
        # Where the loop does not follow, the record's own reversals stay.
        excluded = np.where(first.follows & excluded.any(axis=0), again, excluded)
        shown = first.shown
    rows = block.rows_of(excluded)
    first = _first_fit(block, excluded, rows)
    active = first.follows & first.shown & shown
    return iterated(block, first.measured, excluded, rows, first.theta, active, first.loops)


def _first_fit(block: Block, excluded: Chosen | None, rows: Chosen | None) -> _FirstFit:
    """Least squares of all lanes, with the samples and rows that they have."""
    measured = block.rows(block.measured, excluded, rows)
    found = solved(block.library, measured.left, measured.regressor, measured.regressor)
    every = np.ones(len(block.lanes), dtype=bool)
    loops = loops_of(block, found.theta, every, excluded, rows)
    error = unexplained(measured.whole, fitted(loops.Z, found.theta) + loops.intercept)
    return _FirstFit(
        measured=measured,
        theta=found.theta,
        loops=loops,
        follows=loops.well & found.sound & (error < MAX_SIMULATION_ERROR.value),
        shown=clearly_shown(block, measured, rows, found),
    )


def _near_reversals(block: Block, asked: Prefilter) -> Chosen | None:
    """Samples near reversals and rests that lanes leave out, (N, L); None where no lane does."""
    axis = block.axis
    if asked.reversals == "keep" or not (asked.reversals or axis.has_direction):
        return None
    near = block.turns(block.measured.motion[1])
    if asked.reversals is None and not searches_friction(axis):
        near &= ~_show_too_little(block, near)
    return near if near.any() else None


def _show_too_little(block: Block, near: Chosen) -> Chosen:
    """Which lanes hardly show a parameter without what is near reversals, (L,)."""
    slow = MIN_MOVING_SPEED.value * np.abs(block.measured.motion[1]).max(axis=0)
    moving, left = block.information(near, slow)
    found = np.zeros(near.shape[1], dtype=bool)
    for lane in range(len(found)):
        information = Information(losses_count(block.axis))
        information.add(moving[lane], left[lane])
        found[lane] = information.remaining < MIN_INFORMATION_LEFT.value
    return found
