"""`identify` of many records of one reference, side by side."""

from dataclasses import replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis, as_generated
from axisid.estimation.identification import identify
from axisid.estimation.signals import FilteredRecord, Information, Prefilter, searches_friction
from axisid.estimation.thresholds.estimates import MAX_SIMULATION_ERROR
from axisid.estimation.thresholds.signals import MIN_INFORMATION_LEFT, MIN_MOVING_SPEED
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array
from axisid.support.errors import AxisidError

from .block import Block, Chosen
from .columns import measured_columns
from .deviations import lane_deviations
from .filter_bias import lane_bias
from .iteration import LaneFits, iterated, loops_of, simulated_left, unexplained
from .lanes import ALONE, FAILED, SIDE_BY_SIDE, LaneEstimates, RecordLanes
from .regression import solved

_BLOCK = 32  # lanes side by side


def identify_lanes(
    axis: Axis | GeneratedAxis,
    lanes: RecordLanes,
    method: str = "idm-iv",
    prefilter: Prefilter | None = None,
    *,
    covariance: str = "hac",
    lags: int | None = None,
) -> LaneEstimates:
    generated = as_generated(axis)
    asked = Prefilter() if prefilter is None else prefilter
    size, p = len(lanes), len(generated.parameters)
    found = {
        name: np.full((size, p), np.nan) for name in ("values", "deviations", "bias", "freedom")
    }
    iterations, how, errors = np.zeros(size, dtype=np.int64), [SIDE_BY_SIDE] * size, {}
    for first in range(0, size, _BLOCK):
        part = lanes.part(slice(first, first + _BLOCK))
        block = _block(generated, part, asked)
        well = np.zeros(len(part), dtype=bool)
        if block is not None:
            fits = _fitted(block, asked)
            spread = lane_deviations(block, fits, lags)
            bias = lane_bias(block, fits, spread.deviations[covariance])
            well = fits.well & bias.well & block.starts[1]
            to = first + np.flatnonzero(well)
            found["values"][to], found["deviations"][to] = fits.theta[well], spread.deviations[covariance][well]
            found["bias"][to], found["freedom"][to] = bias.bias[well], spread.freedom[covariance][well]
            iterations[to] = fits.iterations[well]
        for lane in np.flatnonzero(~well):
            to = first + int(lane)
            how[to] = ALONE
            try:
                result = identify(
                    generated, part.record(int(lane)), asked, [method], covariance=covariance, lags=lags
                )[method]
                found["values"][to] = result.physical
                found["deviations"][to] = np.sqrt(np.diag(result.covariance))
                if result.filter_bias is not None:
                    found["bias"][to] = result.filter_bias
                found["freedom"][to] = result.freedom[covariance]
                iterations[to] = max(len(result.iterates) - 1, 0)
            except AxisidError as error:
                how[to], errors[to] = FAILED, str(error)
    return LaneEstimates(
        values=found["values"],
        deviations=found["deviations"],
        filter_bias=found["bias"],
        freedom=found["freedom"],
        iterations=iterations,
        how=tuple(how),
        errors=errors,
    )


def _block(axis: GeneratedAxis, part: RecordLanes, asked: Prefilter) -> Block | None:
    kept = FilteredRecord.bind(axis, part.record(0), replace(asked, reversals="keep"))
    return Block(axis=axis, lanes=part, template=kept)


def _fitted(block: Block, asked: Prefilter) -> LaneFits:
    excluded = _left_out(block, asked)
    if excluded is not None:
        rows = block.rows_of(excluded)
        measured, physical, loops, follows = _least_squares(block, excluded, rows)
        again = block.turns(block.velocity(loops.position))
        # Where the loop does not follow, the record's own reversals stay.
        excluded = np.where(follows & excluded.any(axis=0), again, excluded)
    rows = block.rows_of(excluded)
    measured, physical, loops, follows = _least_squares(block, excluded, rows)
    return iterated(block, measured, excluded, rows, physical, follows, loops)


def _least_squares(block: Block, excluded: Chosen | None, rows: Chosen | None):
    measured = block.rows(block.measured, excluded, rows)
    first = solved(block.library, measured.left, measured.regressor, measured.regressor)
    every = np.ones(len(block.lanes), dtype=bool)
    loops = loops_of(block, first.theta, every, excluded, rows)
    error = unexplained(measured.whole, simulated_left(loops, first.theta))
    follows = loops.well & first.sound & (error < MAX_SIMULATION_ERROR.value)
    return measured, first.theta, loops, follows


def _left_out(block: Block, asked: Prefilter) -> Chosen | None:
    """Samples near reversals that lanes leave out, (N, L); None where no lane does."""
    axis = block.axis
    if asked.reversals == "keep" or not (asked.reversals or axis.has_direction):
        return None
    signals = block.measured
    velocity = signals.motion[1]
    near = block.turns(velocity)
    if asked.reversals is None and not searches_friction(axis):
        columns = measured_columns(axis, signals, 0.0)
        kept = block.template.kept
        speed = np.abs(velocity)
        moving = kept[:, None] & (speed > MIN_MOVING_SPEED.value * speed.max(axis=0))
        left = kept[:, None] & ~near
        for lane in range(near.shape[1]):
            own = np.ascontiguousarray(columns[:, :-2, lane])
            found = Information(axis)
            found.add_rows(own[moving[:, lane]], own[left[:, lane]])
            if found.remaining < MIN_INFORMATION_LEFT.value:
                near[:, lane] = False
    return near if near.any() else None
