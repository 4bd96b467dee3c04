"""What noise in the loop moves a lane's estimate by, whose record lacks the filter's own error.

As of one record, see `axisid.estimation.methods.fitted_point`; the loops of all draws are simulated
side by side.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.lowering import LoopStart
from axisid.estimation.batched.rows import (
    Block,
    LaneSolutions,
    simulated_lanes,
    solved,
)
from axisid.estimation.problems import NoiseFree, confirmed, settled_noise_free, white_part
from axisid.estimation.regression import Covariance, Solution, beyond_shown, hidden_scatter
from axisid.estimation.thresholds.estimates import MAX_SIMULATION_ERROR, SETTLED_FILTER_BIAS
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError

from .deviations import lane_solution, shown_variances
from .iteration import LaneFits, unexplained

LaneQuiet = tuple[Array, Array]

_DRAWS, _OF_A_DRAW = 4, 2  # as of one record: orders of the noise, each with either sign


@lru_cache(maxsize=2)  # a block's lanes are as long as each other
def _orders(samples: int) -> tuple[NDArray[np.int64], ...]:
    """The orders in which noise of so many samples is drawn, the same at every place."""
    rng = np.random.default_rng(0)
    return tuple(rng.permutation(samples) for _ in range(_DRAWS))


class NoisyLoops:
    """The loops of one lane with its noise in other orders.

    Parameters
    ----------
    block : Block
    fits : LaneFits
    lane : int
    """

    def __init__(self, block: Block, fits: LaneFits, lane: int) -> None:
        self._block, self._lane = block, lane
        self._rows = None if fits.rows is None else fits.rows[:, [lane]]
        self._excluded = None if fits.excluded is None else fits.excluded[:, [lane]]
        self._instruments = fits.instruments[:, :, [lane]]
        self._whole = fits.measured.whole[:, [lane]]
        self._theta, self._position = fits.theta[lane], fits.position[:, lane]
        self._solution = lane_solution(block, fits, lane)
        start, _ = block.starts
        self._start = start.position[lane], start.velocity[lane]

    def settled(
        self, first: LaneQuiet, last: LaneQuiet, deviations: Array, model: Covariance
    ) -> NoiseFree:
        """The bias with noise where that is the record's, or else without, if it is in doubt.

        Parameters
        ----------
        first, last : LaneQuiet
            Bias (p,) and residuals (n,) of the loops without noise: at the estimate, and where the
            correction leads.
        deviations : (p,) array
        model : Covariance

        Raises
        ------
        EstimationError
            A loop cannot be simulated.
        """
        quiet = self._quiet(*first)
        here = self._with_noise(quiet, self._theta, self._position, deviations)
        found = settled_noise_free(here, self._found_at, self._theta, deviations)
        noisy = confirmed(found, self._solution, model)
        if noisy.has_noise and not noisy.doubt:
            return noisy
        return confirmed(self._quiet(*last), self._solution, model)

    def _quiet(self, bias: Array, residuals: Array) -> NoiseFree:
        return NoiseFree(
            regressor=np.zeros((0, len(bias))),
            theta=self._theta + bias,
            residuals=self._there(residuals[:, None])[0],
            bias=bias,
        )

    def _found_at(self, physical: Array) -> NoiseFree | None:
        """The same at other parameters; None where the loop does not follow."""
        found, whole, position = self._solved(physical, None)
        if unexplained(self._whole, whole)[0] >= MAX_SIMULATION_ERROR.value:
            return None
        quiet = self._quiet(found.theta[0] - physical, found.residuals[:, 0])
        return self._with_noise(quiet, physical, position, None)

    def _with_noise(
        self, quiet: NoiseFree, physical: Array, position: Array, deviations: Array | None
    ) -> NoiseFree:
        """The same of loops with noise, unless the first draw shows that it is no matter.

        `position` is that of the loop without, (N,).
        """
        noise = white_part(self._block.lanes.position[:, self._lane] - position)
        if not noise.any():
            return quiet
        orders = [noise[order] for order in _orders(len(noise))]
        drawn = np.column_stack([sign * each for each in orders for sign in (1.0, -1.0)])
        found, _, _ = self._solved(physical, drawn)
        moved = found.theta - physical
        if deviations is not None:
            apart = np.abs(moved[:_OF_A_DRAW].mean(axis=0) - quiet.bias)
            if np.all(apart <= SETTLED_FILTER_BIAS.value * deviations):
                return quiet
        left = self._there(found.residuals)
        return replace(
            quiet,
            bias=np.mean(moved, axis=0),
            has_noise=True,
            hidden=self._hidden(found),
            halves=left.reshape(2, -1, left.shape[1]).mean(axis=1),
        )

    def _solved(self, physical: Array, noise: Array | None) -> tuple[LaneSolutions, Array, Array]:
        """What the instruments make of loops, their left side, and the position of the first."""
        count = 1 if noise is None else noise.shape[1]
        position, velocity = (np.full(count, each) for each in self._start)
        start = LoopStart(position=position, velocity=velocity)
        sets = np.tile(physical, (count, 1))
        loops, well = simulated_lanes(self._block.axis, sets, self._block.lanes, start, noise)
        if not well.all():
            raise EstimationError("a loop with noise cannot be simulated.", code="noisy-loop")
        position = loops["position"] if noise is None else loops["position"] + noise
        first = loops["position"][:, 0].copy()
        excluded, there = (
            None if each is None else np.repeat(each, count, axis=1)
            for each in (self._excluded, self._rows)
        )
        rows = self._block.rows(self._block.seen(position, loops["control"]), excluded, there)
        instruments = np.repeat(self._instruments, count, axis=2)
        found = solved(self._block.library, rows.left, rows.regressor, instruments)
        return found, rows.whole, first

    def _hidden(self, found: LaneSolutions) -> Array:
        """As `hidden_scatter`, of variances alone, which is all that is asked of lanes."""
        instruments = np.repeat(self._instruments, len(found.theta), axis=2)
        rows = len(self._solution.residuals)
        shown = shown_variances(self._block, found, instruments, rows)
        if shown is None:
            return hidden_scatter(self._solutions(found))
        return beyond_shown(found.theta, np.diag(shown))

    def _solutions(self, found: LaneSolutions) -> list[Solution]:
        """Solutions of loops as if each were alone."""
        own = self._there(self._instruments[:, :, 0]).T
        left = self._there(found.residuals)
        return [
            replace(self._solution, theta=theta, residuals=e, influence=own @ mixing.T)
            for theta, e, mixing in zip(found.theta, left, found.mixing, strict=True)
        ]

    def _there(self, residuals: Array) -> Array:
        """Residuals (n, B) of rows that the lane has, (B, rows)."""
        kept = residuals if self._rows is None else residuals[np.ravel(self._rows)]
        return np.ascontiguousarray(kept.T)
