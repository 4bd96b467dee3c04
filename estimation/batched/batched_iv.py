"""Lanes from their rows to estimates; see `axisid.estimation.methods.instrumental`.

Instrumental variables and least squares are by normal equations that are refined. Columns are
scaled to unit norm; the equations of the residuals are solved once more, which leaves the digits
that a factorisation has as long as the columns are not nearly dependent. Lanes of which that is not
so are told, and solved elsewhere. Whoever calls silences NumPy of what is not finite.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.native import LaneLibrary
from axisid.estimation.estimates import COVARIANCES
from axisid.estimation.estimation_problem import SignalRanges, shown_up_to
from axisid.estimation.methods import StepControl
from axisid.estimation.regression import Equations, Hac, InverseForm, Solution, most_lags
from axisid.estimation.signals import (
    Prefilter,
    RowTimes,
    Signals,
    drive_force,
    remaining_information,
    searches_friction,
    takes_robust_loss,
)
from axisid.estimation.thresholds import (
    CONVERGED,
    FEW_SCORES,
    MAX_SIMULATION_ERROR,
    MIN_DISTANCE_FROM_NOISE,
    MIN_INFORMATION_LEFT,
    MIN_MOVING_SPEED,
)
from axisid.support.arrays import Array

from .block import Chosen, LaneBlock, LaneLoops

_MOST_CONDITION = 1e6  # of the scaled products: digits are lost beyond


@dataclass(frozen=True, slots=True, kw_only=True)
class LaneSolutions:
    """Solutions of lanes.

    Attributes
    ----------
    theta : (L, p) array
    residuals : (n, L) array
    mixing : (L, p, p) array
        ``(Z'X)^-1``.
    power : (L,) array
        Of the residuals.
    sound : (L,) array of bool
        Where the products are well conditioned.
    """

    theta: Array
    residuals: Array
    mixing: Array
    power: Array
    sound: NDArray[np.bool_]


def products(library: LaneLibrary, one: Array, other: Array) -> Array:
    """``sum a_t b_t'`` of columns (n, p, L) and (n, q, L), (L, p, q), each lane by itself."""
    return library.products(one, other).transpose(2, 0, 1)


def row_counts(rows: NDArray[np.bool_] | None, shape: tuple[int, ...]) -> Array:
    """How many rows each lane has, (L,)."""
    return np.full(shape[1], float(shape[0])) if rows is None else rows.sum(axis=0).astype(float)


def fitted(regressor: Array, theta: Array) -> Array:
    """``X theta`` of lanes, (n, L), for parameters (L, p)."""
    every = range(theta.shape[1])
    return np.asarray(sum(regressor[:, i] * theta[:, i] for i in every))


def solved(
    library: LaneLibrary, left: Array, regressor: Array, instruments: Array
) -> LaneSolutions:
    """``(Z'X)^-1 Z'y`` of lanes; least squares where the instruments are the regressor.

    Parameters
    ----------
    library : LaneLibrary
    left : (n, L) array
    regressor, instruments : (n, p, L) array
    """
    together = products(library, instruments, regressor)
    aside = products(library, instruments, left[:, None])[:, :, 0]
    by, scale = norms(library, instruments), norms(library, regressor)
    scaled = together / by[:, :, None] / scale[:, None, :]
    finite = np.isfinite(scaled).all(axis=(1, 2)) & np.isfinite(aside).all(axis=1)
    scaled[~finite] = np.eye(scaled.shape[1])
    sound = finite & (np.linalg.cond(scaled) < _MOST_CONDITION)
    scaled[~sound] = np.eye(scaled.shape[1])
    mixing = np.linalg.inv(scaled) / scale[:, :, None] / by[:, None, :]
    theta = _applied(mixing, aside)
    residuals = left - fitted(regressor, theta)
    step = products(library, instruments, residuals[:, None])[:, :, 0]
    theta = theta + _applied(mixing, step)
    residuals = left - fitted(regressor, theta)
    return LaneSolutions(
        theta=theta,
        residuals=residuals,
        mixing=mixing,
        power=products(library, residuals[:, None], residuals[:, None])[:, 0, 0],
        sound=sound,
    )


def inverse_products(library: LaneLibrary, columns: Array) -> Array:
    """``(Z'Z)^-1`` of columns (n, p, L), (L, p, p); of no meaning where there is none."""
    raw = products(library, columns, columns)
    scale = np.sqrt(np.diagonal(raw, axis1=1, axis2=2))
    scaled = raw / scale[:, :, None] / scale[:, None, :]
    scaled[~np.isfinite(scaled).all(axis=(1, 2))] = np.eye(scaled.shape[1])
    return np.asarray(np.linalg.pinv(scaled) / scale[:, :, None] / scale[:, None, :])


def _applied(matrices: Array, vectors: Array) -> Array:
    return np.asarray((matrices * vectors[:, None, :]).sum(axis=2))


def norms(library: LaneLibrary, columns: Array) -> Array:
    """Of columns (n, p, L), (L, p)."""
    return np.asarray(np.sqrt(library.lagged(columns, 0)[0].T))


_MOST = 8  # steps of lanes; what takes more is identified alone
_CLEARLY = 0.5  # of what a record may hide: lanes nearer to that are looked at alone
_ROUNDING = float(np.finfo(float).eps)


@dataclass(frozen=True, slots=True, kw_only=True)
class LaneFits(LaneSolutions):
    """Where lanes ended; what is not `sound` is to be identified alone.

    Attributes
    ----------
    rows : (n, L) array of bool or None
        Which there are.
    instruments : (n, p, L) array
    iterations : (L,) array of int
    """

    rows: Chosen | None
    instruments: Array
    iterations: NDArray[np.int64]


def fitted_lanes(block: LaneBlock, asked: Prefilter) -> LaneFits:
    """Lanes from their samples to where the instruments' iteration ends."""
    excluded = _near_reversals(block, asked)
    shown = np.ones(len(block.lanes), dtype=bool)
    if excluded is not None:
        _, _, loops, follows, shown = _first_fit(block, excluded, block.rows_of(excluded))
        again = block.turns(block.filtered(loops.position))
        # Where the loop does not follow, the record's own reversals stay.
        excluded = np.where(follows & excluded.any(axis=0), again, excluded)
    rows = block.rows_of(excluded)
    measured, theta, loops, follows, clear = _first_fit(block, excluded, rows)
    return _iterated(block, measured, excluded, rows, theta, follows & clear & shown, loops)


def _first_fit(
    block: LaneBlock, excluded: Chosen | None, rows: Chosen | None
) -> tuple[Equations, Array, LaneLoops, Chosen, Chosen]:
    """Least squares of lanes.

    Returns
    -------
    measured : Equations
    theta : (L, p) array
    loops : LaneLoops
        Simulated with it.
    follows : (L,) array of bool
        Which loops move as the records do.
    shown : (L,) array of bool
        Which lanes show every parameter by far.
    """
    measured = block.rows(excluded, rows)
    left = measured.left - measured.intercept
    found = solved(block.library, left, measured.regressor, measured.regressor)
    every = np.ones(len(block.lanes), dtype=bool)
    loops = block.loops(found.theta, every, excluded, rows)
    off = measured.left - (fitted(loops.Z, found.theta) + loops.intercept)
    error = 100 * (np.linalg.norm(off, axis=0) / np.linalg.norm(measured.left, axis=0))
    follows = loops.well & found.sound & (error < MAX_SIMULATION_ERROR.value)
    return measured, found.theta, loops, follows, _clearly_shown(block, measured, rows, found)


def _near_reversals(block: LaneBlock, asked: Prefilter) -> Chosen | None:
    """Samples near reversals and rests that lanes leave out, (N, L); None where no lane does."""
    axis = block.axis
    if asked.reversals == "keep" or not (asked.reversals or axis.has_direction):
        return None
    near = block.turns(block.motion)
    if asked.reversals is None and not searches_friction(axis):
        # But for lanes that would hardly show a parameter.
        slow = MIN_MOVING_SPEED.value * np.abs(block.motion[1]).max(axis=0)
        pairs = block.library.information(block.motion, block.template.sampling.kept, near, slow)
        moving, left = (each.transpose(2, 0, 1) for each in pairs)
        counts = takes_robust_loss(axis)
        remaining = [
            remaining_information(counts, *lane) for lane in zip(moving, left, strict=True)
        ]
        near &= ~(np.array(remaining) < MIN_INFORMATION_LEFT.value)
    return near if near.any() else None


def _clearly_shown(
    block: LaneBlock, measured: Equations, rows: NDArray[np.bool_] | None, first: LaneSolutions
) -> NDArray[np.bool_]:
    """Which lanes show every parameter by far, (L,), from least squares of their rows.

    What a record may hide follows from its force and motion, which are those of the first lane in
    all but noise.
    """
    columns = (*block.motion, block.lanes.control)
    q, dq, ddq, control = (np.ascontiguousarray(each[:, 0]) for each in columns)
    force = drive_force(block.axis, control, q, dq)
    signals = Signals(position=q, velocity=dq, acceleration=ddq, force=force, direction=np.sign(dq))
    reach = SignalRanges.of(
        [(signals, InverseForm(block.axis).equations(signals), block.template.sampling.kept)]
    )
    if reach is None:
        return np.zeros(len(block.lanes), dtype=bool)
    most: Array = shown_up_to(block.axis, reach)
    sizes = norms(block.library, measured.regressor)
    freedom = row_counts(rows, measured.left.shape) - sizes.shape[1]
    noise = np.maximum(np.sqrt(first.power / freedom), _ROUNDING * reach.force)
    needed = MIN_DISTANCE_FROM_NOISE.value * noise[:, None] / sizes
    return np.asarray((needed < _CLEARLY * most).all(axis=1) & (freedom > 0))


def _iterated(
    block: LaneBlock,
    measured: Equations,
    excluded: Chosen | None,
    rows: Chosen | None,
    physical: Array,
    active: Chosen,
    loops: LaneLoops,
) -> LaneFits:
    """Iterate lanes from least squares (L, p), whose loops are known, until they stand still."""
    n, p, lanes = measured.regressor.shape
    net = measured.left - measured.intercept
    end = LaneFits(  # its arrays are filled in as lanes end
        theta=np.full((lanes, p), np.nan),
        residuals=np.zeros((n, lanes)),
        mixing=np.zeros((lanes, p, p)),
        power=np.zeros(lanes),
        sound=np.zeros(lanes, dtype=bool),
        rows=rows,
        instruments=np.zeros((n, p, lanes)),
        iterations=np.zeros(lanes, dtype=np.int64),
    )
    paces, counts = [StepControl() for _ in range(lanes)], row_counts(rows, net.shape)
    physical, size = physical.copy(), np.full(lanes, np.inf)
    active = active.copy()
    for step in range(1, _MOST + 2):
        active &= loops.well
        at = np.flatnonzero(active)
        done = size[at] <= CONVERGED.value
        if done.any():
            end.sound[at[done]], end.iterations[at[done]] = True, step - 1
            active[at[done]] = False
        if not active.any() or step > _MOST:
            break
        going = at[~done]
        left, regressor = (
            np.ascontiguousarray(each[..., going]) for each in (net, measured.regressor)
        )
        Z = np.ascontiguousarray(loops.Z[..., np.searchsorted(loops.lanes, going)])
        found = solved(block.library, left, regressor, Z)
        inverse = inverse_products(block.library, Z)
        sigma = found.power / (counts[going] - 1)
        deviations = np.sqrt(sigma[:, None] * np.diagonal(inverse, axis1=1, axis2=2))
        end.theta[going], end.residuals[:, going] = found.theta, found.residuals
        end.mixing[going] = found.mixing
        end.instruments[:, :, going] = Z
        end.power[going] = found.power
        for i, lane in enumerate(going):
            size[lane], _ = paces[lane].step(physical[lane], found.theta[i], deviations[i])
            found.sound[i] &= paces[lane].share == 1.0
        physical[going] = found.theta
        active[going[~found.sound]] = False
        if active.any():
            loops = block.loops(physical, active, excluded, rows)
    return end


def lane_numbers(block: LaneBlock, fits: LaneFits, lags: int | None) -> Array:
    """Values, deviations and their degrees of freedom, (L, 1 + 2 c, p), of lanes that ended well.

    Of no meaning for the others.
    """
    (rows, k), shape = fits.instruments.shape[:2], fits.theta.shape
    n, model = row_counts(fits.rows, fits.residuals.shape)[:, None], Hac(lags)
    inverse = inverse_products(block.library, fits.instruments)
    # Each column a sum of all instruments, by the matrices of the lanes.
    own = [sum(fits.instruments[:, j] * fits.mixing[:, i, j] for j in range(k)) for i in range(k)]
    scores = np.stack(own, axis=1) * fits.residuals[:, None]
    most = (most_lags(rows) if lags is None else lags) + 2
    lagged = block.library.lagged(scores, min(most, rows - 1))
    variances = {
        "iid": fits.power[:, None] / (n - 1) * np.diagonal(inverse, axis1=1, axis2=2),
        "robust": n / (n - k) * lagged[0].T,
        "hac": np.full(shape, np.nan),
    }
    freedom = {name: np.broadcast_to(n - k, shape).copy() for name in variances}
    for lane in map(int, np.flatnonzero(fits.sound)):
        sums = lagged[:, :, lane, None] * np.eye(k)
        applied = model.of_scores(lambda at: sums[: at + 1], (int(n[lane, 0]), k))  # noqa: B023
        if lags is None and applied.freedom.min() < FEW_SCORES.value:
            applied = model.applied(_lane_solution(block, fits, lane, inverse[lane]))
        variances["hac"][lane], freedom["hac"][lane] = np.diag(applied.matrix), applied.freedom
    deviations = [np.sqrt(np.maximum(variances[name], 0.0)) for name in COVARIANCES]
    return np.stack([fits.theta, *deviations, *(freedom[name] for name in COVARIANCES)], axis=1)


def _lane_solution(block: LaneBlock, fits: LaneFits, lane: int, inverse: Array) -> Solution:
    """A lane's solution as if it were alone; `inverse` are ``(Z'Z)^-1``."""
    own = slice(None) if fits.rows is None else fits.rows[:, lane]
    places = block.template.sampling.rows.astype(np.int64)[own]
    return Solution(
        theta=fits.theta[lane],
        residuals=np.ascontiguousarray(fits.residuals[own, lane]),
        inverse_factor=np.asarray(np.linalg.cholesky(inverse), dtype=np.float64),
        influence=fits.instruments[own, :, lane] @ fits.mixing[lane].T,
        neighbours=RowTimes(places // block.template.prefilter.decimate),
    )
