"""Batched `identify` of many records of one reference, from their rows to estimates.

A lane is one of these records. Instrumental variables, see
`axisid.estimation.methods.instrumental`, and least squares are solved by refined normal equations.
Columns are scaled to unit norm, and the equations are solved again for the residuals, which gives
the accuracy of a QR factorisation if the columns are not nearly dependent. Lanes with nearly
dependent columns are identified separately, by `identify`. Warnings of NumPy for values that are
not finite are switched off.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis, as_generated
from axisid.codegen.runtime import LaneLibrary
from axisid.estimation.estimates import COVARIANCES, covariance_of
from axisid.estimation.estimation_problem import SignalRanges, detection_limits
from axisid.estimation.identification import identify
from axisid.estimation.methods import StepControl
from axisid.estimation.records import is_same_period
from axisid.estimation.regression import Equations, InverseForm, Solution
from axisid.estimation.signals import (
    FilteredRecord,
    Prefilter,
    RowTimes,
    has_nonlinear_speed_friction,
    is_speed_friction,
    remaining_information,
)
from axisid.estimation.thresholds import (
    CONVERGED,
    MAX_SIMULATION_ERROR,
    MIN_DISTANCE_FROM_NOISE,
    MIN_INFORMATION_LEFT,
    MIN_MOVING_SPEED,
)
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array, BoolArray
from axisid.support.errors import AxisidError
from axisid.support.one_thread import in_one_thread

from .lanes import (
    ALONE,
    FAILED,
    SIDE_BY_SIDE,
    LaneBlock,
    LaneEstimates,
    LaneLoops,
    RecordLanes,
)

#: The method with batched lanes.
METHOD = "idm-iv"
_BLOCK = 32  # lanes that are simulated together
_MOST_CONDITION = 1e6  # condition of the scaled products, beyond which digits are lost
_MOST = 8  # iterations of lanes; a lane that needs more is identified separately
# uncertainty of a parameter relative to its detection limit, above which a lane is identified
# separately
_CLEARLY = 0.5
_ROUNDING = float(np.finfo(float).eps)

#: Solution and number of iterations, by index of the lane in its block.
LaneFits = dict[int, tuple[Solution, int]]


def is_served(axis: GeneratedAxis, period: float, method: str) -> bool:
    """Return True if lanes of an axis with a sampling period in s can be batched.

    This needs instrumental variables as the method, a linear and identifiable model without
    recorded signals, a drive without delay, lag and command path, a law that is evaluated at the
    samples, and a compiler.
    """
    law, drive = axis.control, axis.drive
    return (
        method == METHOD
        and axis.is_linear
        and not (axis.unidentifiable or axis.signals or axis.drives_by_motion)
        and axis.declared.drive.estimated is None
        and axis.response is None
        and drive.path.is_plain
        and not drive.logs_what_acts
        and law is not None
        and not law.continuous
        and is_same_period(period, law.period)
        and axis.native.lanes is not None
    )


@in_one_thread
def identify_lanes(
    axis: Axis | GeneratedAxis,
    lanes: RecordLanes,
    method: str = METHOD,
    prefilter: Prefilter | None = None,
    *,
    lags: int | None = None,
    **settings: Any,
) -> LaneEstimates:
    """Identify records of one reference by one method, in batches.

    The estimate of each lane equals that of `identify` without simulated replicas, except for
    rounding: lanes are filtered, simulated and solved together in compiled code. Lanes are
    identified separately if the axis cannot be batched (`is_served`), or if there are encoder
    steps. A single lane is identified separately if its law does not start with the memory of an
    axis at rest, if its simulated loop does not follow the record, if it does not clearly show each
    parameter, or if its iteration is ill-conditioned or does not converge in a few full steps.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
    lanes : RecordLanes
    method : str
        One of `METHODS`; ``idm-iv`` is batched.
    prefilter : Prefilter, optional
        As in `identify`.
    lags : int, optional
        As in `identify`.
    **settings
        Other arguments of `identify`; with any of them, lanes are identified separately.

    Returns
    -------
    LaneEstimates

    Raises
    ------
    UsageError
        The prefilter is no Prefilter.
    """
    generated = as_generated(axis)
    asked = Prefilter.given(prefilter)
    shape = len(lanes), len(generated.parameters)
    values, iterations = np.full(shape, np.nan), np.zeros(len(lanes), dtype=np.int64)
    deviations, freedom = ({name: np.full(shape, np.nan) for name in COVARIANCES} for _ in range(2))
    how: list[str] = [SIDE_BY_SIDE] * len(lanes)
    errors: dict[int, str] = {}
    covariances = [covariance_of(name, lags) for name in COVARIANCES]
    library = None
    if not (settings or lanes.resolution) and is_served(generated, lanes.period, method):
        library = generated.native.lanes
    for first in range(0, len(lanes), _BLOCK):
        part = lanes.part(slice(first, first + _BLOCK))
        fits: LaneFits = {}
        if library is not None:
            fits = _block_fits(generated, library, part, asked)
        for index in range(len(part)):
            lane = first + index
            try:
                if index in fits:
                    solution, steps = fits[index]
                    with np.errstate(all="ignore"):
                        applied = [covariance.applied(solution) for covariance in covariances]
                    spread = [(each.matrix, each.freedom) for each in applied]
                    values[lane], iterations[lane] = solution.theta, steps
                else:
                    how[lane], chosen = ALONE, {"lags": lags, "bootstrap": 0, **settings}
                    result = identify(
                        generated, part.record(index), asked, [method], **chosen, judge=False
                    )
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


def _block_fits(
    axis: GeneratedAxis, library: LaneLibrary, lanes: RecordLanes, asked: Prefilter
) -> LaneFits:
    """Return the fits of the lanes of a block by their index; the others are missing.

    Missing lanes have to be identified separately. `asked` are the settings of the filter.
    """
    try:
        template = FilteredRecord.bind(axis, lanes.record(0), replace(asked, reversals="keep"))
    except AxisidError:
        return {}  # the separate identification raises the error
    with np.errstate(all="ignore"):  # lanes that are not finite are identified separately
        block = LaneBlock(axis=axis, library=library, lanes=lanes, template=template)
        return fitted_lanes(block, asked)


@dataclass(frozen=True, slots=True, kw_only=True)
class LaneSolutions:
    """Least-squares or instrumental-variables solutions of lanes.

    Attributes
    ----------
    theta : (L, p) array
        Estimated parameters.
    residuals : (n, L) array
        Residuals; 0 for rows that a lane lacks.
    power : (L,) array
        Sums of squared residuals.
    instruments : (n, p, L) array
        Z; the regressor X for least squares.
    mixing, inverse : (L, p, p) arrays
        ``(Z'X)^-1`` and ``(Z'Z)^-1``; not valid for ill-conditioned lanes.
    sound : (L,) array of bool
        True for lanes with well-conditioned products.
    """

    theta: Array
    residuals: Array
    power: Array
    instruments: Array
    mixing: Array
    inverse: Array
    sound: BoolArray

    def alone(self, block: LaneBlock, rows: BoolArray | None, lane: int, place: int) -> Solution:
        """Return the solution of one lane of a block.

        Parameters
        ----------
        block : LaneBlock
        rows : (n, L) array of bool or None
            True for the rows that each lane has; None for all.
        lane : int
            Index of the lane in the block.
        place : int
            Index of the lane among these solutions, which may be of some lanes of the block only.
        """
        own = slice(None) if rows is None else rows[:, lane]
        samples = block.template.sampling.rows.astype(np.int64)[own]
        return Solution(
            theta=self.theta[place],
            residuals=np.ascontiguousarray(self.residuals[own, place]),
            inverse_factor=np.asarray(np.linalg.cholesky(self.inverse[place]), dtype=float),
            influence=self.instruments[own, :, place] @ self.mixing[place].T,
            neighbours=RowTimes(samples // block.template.prefilter.decimate),
        )


def products(library: LaneLibrary, one: Array, other: Array) -> Array:
    """Return ``A'B`` of the columns A (n, p, L) and B (n, q, L) of each lane, (L, p, q)."""
    return library.products(one, other).transpose(2, 0, 1)


def row_counts(rows: BoolArray | None, shape: tuple[int, ...]) -> Array:
    """Return the number of rows of each lane, (L,).

    `rows`, (n, L), is True for rows that a lane has; None for all n rows of the shape (n, L).
    """
    if rows is None:
        return np.full(shape[1], float(shape[0]))
    return np.asarray(rows.sum(axis=0), dtype=float)


def fitted(regressor: Array, theta: Array) -> Array:
    """Return ``X theta`` of lanes, (n, L), for parameters (L, p)."""
    return np.asarray(sum(regressor[:, i] * theta[:, i] for i in range(theta.shape[1])))


def solved(
    library: LaneLibrary, left: Array, regressor: Array, instruments: Array
) -> LaneSolutions:
    """Return the solutions ``(Z'X)^-1 Z'y`` of lanes; least squares if Z is X.

    Parameters
    ----------
    library : LaneLibrary
    left : (n, L) array
        Left sides minus known terms, y.
    regressor, instruments : (n, p, L) array
        X and Z.
    """
    # Products Z'X, Z'y and Z'Z, and the norms of the columns of Z and X.
    zx = products(library, instruments, regressor)
    zy = products(library, instruments, left[:, None])[:, :, 0]
    zz = products(library, instruments, instruments)
    z_norms, x_norms = np.sqrt(np.diagonal(zz, axis1=1, axis2=2)), norms(library, regressor)
    # Lanes that are not finite or ill-conditioned get the identity instead.
    scaled = zx / z_norms[:, :, None] / x_norms[:, None, :]
    finite = np.isfinite(scaled).all(axis=(1, 2)) & np.isfinite(zy).all(axis=1)
    scaled[~finite] = np.eye(scaled.shape[1])
    sound = finite & (np.linalg.cond(scaled) < _MOST_CONDITION)
    scaled[~sound] = np.eye(scaled.shape[1])
    mixing = np.linalg.inv(scaled) / x_norms[:, :, None] / z_norms[:, None, :]
    # Solve the normal equations, and once more for the residuals.
    theta = _applied(mixing, zy)
    residuals = left - fitted(regressor, theta)
    step = products(library, instruments, residuals[:, None])[:, :, 0]
    theta = theta + _applied(mixing, step)
    residuals = left - fitted(regressor, theta)
    scaled_zz = zz / z_norms[:, :, None] / z_norms[:, None, :]
    scaled_zz[~np.isfinite(scaled_zz).all(axis=(1, 2))] = np.eye(scaled_zz.shape[1])
    return LaneSolutions(
        theta=theta,
        residuals=residuals,
        power=products(library, residuals[:, None], residuals[:, None])[:, 0, 0],
        instruments=instruments,
        mixing=mixing,
        inverse=np.linalg.pinv(scaled_zz) / z_norms[:, :, None] / z_norms[:, None, :],
        sound=sound,
    )


def _applied(matrices: Array, vectors: Array) -> Array:
    """Return the product of a matrix (L, p, p) and a vector (L, p) for each lane, (L, p)."""
    return np.asarray((matrices * vectors[:, None, :]).sum(axis=2))


def norms(library: LaneLibrary, columns: Array) -> Array:
    """Return the norm of each column of (n, p, L), by lane, (L, p)."""
    squares = products(library, columns, columns)
    return np.asarray(np.sqrt(np.diagonal(squares, axis1=1, axis2=2)))


def fitted_lanes(block: LaneBlock, asked: Prefilter) -> LaneFits:
    """Return the fits of lanes by the instrumental-variables iteration.

    Lanes that are to be identified separately are missing. For a first least-squares fit, samples
    near reversals of the records are excluded. For the second, samples near reversals of the loops
    that are simulated with the first fit are excluded instead. The iteration starts from the second
    fit.
    """
    excluded, is_batched = _near_reversals(block, asked), block.starts[1]
    if excluded is not None:
        _, _, loops, follows, shown = _first_fit(block, excluded, block.rows_of(excluded))
        of_loops = block.turns(block.filtered(loops.position))
        # A lane whose loop does not follow the record keeps the reversals of the record.
        excluded = np.where(follows & excluded.any(axis=0), of_loops, excluded)
        is_batched = is_batched & shown
    rows = block.rows_of(excluded)
    measured, found, loops, follows, shown = _first_fit(block, excluded, rows)
    return _iterated(block, measured, excluded, rows, found, follows & shown & is_batched, loops)


def _first_fit(
    block: LaneBlock, excluded: BoolArray | None, rows: BoolArray | None
) -> tuple[Equations, LaneSolutions, LaneLoops, BoolArray, BoolArray]:
    """Estimate lanes by least squares, and simulate their loops.

    Returns
    -------
    measured : Equations
        Rows of the records.
    found : LaneSolutions
        Least-squares solutions.
    loops : LaneLoops
        Simulated with the solutions.
    follows : (L,) array of bool
        True for lanes whose simulated loop follows the record.
    shown : (L,) array of bool
        True for lanes that clearly show every parameter.
    """
    measured = block.rows(excluded, rows)
    left = measured.left - measured.intercept
    found = solved(block.library, left, measured.regressor, measured.regressor)
    loops = block.loops(found.theta, np.ones(len(block.lanes), dtype=bool), excluded, rows)
    off = measured.left - (fitted(loops.Z, found.theta) + loops.intercept)
    error = 100 * (np.linalg.norm(off, axis=0) / np.linalg.norm(measured.left, axis=0))
    follows = loops.well & found.sound & (error < MAX_SIMULATION_ERROR.value)
    return measured, found, loops, follows, _clearly_shown(block, measured, rows, found)


def _near_reversals(block: LaneBlock, asked: Prefilter) -> BoolArray | None:
    """Return True for samples near reversals and rests that are excluded, (N, L).

    None if no samples are excluded. `asked` are the settings of the filter.
    """
    axis = block.axis
    if asked.reversals == "keep" or not (asked.reversals or axis.has_direction):
        return None
    near = block.turns(block.motion)
    if asked.reversals is None and not has_nonlinear_speed_friction(axis):
        # Lanes that would hardly show a parameter without these samples keep all samples.
        slow = MIN_MOVING_SPEED.value * np.abs(block.motion[1]).max(axis=0)
        pairs = block.library.information(block.motion, block.template.sampling.kept, near, slow)
        moving, left = (each.transpose(2, 0, 1) for each in pairs)
        counts = ~is_speed_friction(axis)
        remaining = [
            remaining_information(counts, *lane) for lane in zip(moving, left, strict=True)
        ]
        near &= ~(np.array(remaining) < MIN_INFORMATION_LEFT.value)
    return near if near.any() else None


def _clearly_shown(
    block: LaneBlock, measured: Equations, rows: BoolArray | None, first: LaneSolutions
) -> BoolArray:
    """Return True for lanes that clearly show every parameter, (L,), by least squares.

    A parameter is clearly shown if its uncertainty is below half of its detection limit. The
    detection limits follow from force and motion, which are equal in all lanes except for noise, so
    that the limits of the first lane are used. `first` are the least-squares solutions.
    """
    signals = block.template.signals
    every = InverseForm(block.axis).equations(signals)
    reach = SignalRanges.of([(signals, every, block.template.sampling.kept)])
    if reach is None:
        return np.zeros(len(block.lanes), dtype=bool)
    most: Array = detection_limits(block.axis, reach)
    sizes = norms(block.library, measured.regressor)
    freedom = row_counts(rows, measured.left.shape) - sizes.shape[1]
    noise = np.maximum(np.sqrt(first.power / freedom), _ROUNDING * reach.force)
    needed = MIN_DISTANCE_FROM_NOISE.value * noise[:, None] / sizes
    return np.asarray((needed < _CLEARLY * most).all(axis=1) & (freedom > 0))


def _iterated(
    block: LaneBlock,
    measured: Equations,
    excluded: BoolArray | None,
    rows: BoolArray | None,
    found: LaneSolutions,
    active: BoolArray,
    loops: LaneLoops,
) -> LaneFits:
    """Return the fits of lanes by instrumental variables, iterated from least squares.

    In each step, lanes whose last step was short enough are stored. Lanes that fail, are
    ill-conditioned, or whose step has to be shortened, are dropped; they are missing in the result.

    Parameters
    ----------
    block : LaneBlock
    measured : Equations
        Rows of the records.
    excluded, rows : array of bool or None
        As in `LaneBlock.rows`.
    found : LaneSolutions
        Least-squares solutions.
    active : (L,) array of bool
        True for lanes to iterate.
    loops : LaneLoops
        Loops simulated with these solutions.
    """
    ended: LaneFits = {}
    net, lanes = measured.left - measured.intercept, len(active)
    paces, counts = [StepControl() for _ in range(lanes)], row_counts(rows, net.shape)
    physical, size, going = found.theta.copy(), np.full(lanes, np.inf), np.arange(lanes)
    active = active.copy()
    for step in range(_MOST + 1):
        # Store lanes that have converged.
        active &= loops.well
        for index, lane in enumerate(going):
            if active[lane] and size[lane] <= CONVERGED.value:
                ended[int(lane)] = found.alone(block, rows, int(lane), index), step
                active[lane] = False
        if not active.any() or step == _MOST:
            break
        # Solve the other lanes with the instruments of their last loops.
        going = np.flatnonzero(active)
        left, regressor = (
            np.ascontiguousarray(each[..., going]) for each in (net, measured.regressor)
        )
        Z = np.ascontiguousarray(loops.Z[..., np.searchsorted(loops.lanes, going)])
        found = solved(block.library, left, regressor, Z)
        sigma = found.power / (counts[going] - 1)
        deviations = np.sqrt(sigma[:, None] * np.diagonal(found.inverse, axis1=1, axis2=2))
        # Drop lanes whose step has to be shortened.
        for index, lane in enumerate(going):
            size[lane], _ = paces[lane].step(physical[lane], found.theta[index], deviations[index])
            found.sound[index] &= paces[lane].share == 1.0
        physical[going] = found.theta
        active[going[~found.sound]] = False
        if active.any():
            loops = block.loops(physical, active, excluded, rows)
    return ended
