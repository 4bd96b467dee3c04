"""What noise in the loop moves estimates of lanes by, whose records lack the filter's own error.

As of one record, see `axisid.estimation.methods.fitted_point`; the loops of all lanes and draws are
simulated side by side.
"""

from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.batched.rows import (
    Block,
    LaneSolutions,
    simulated_lanes,
    solved,
)
from axisid.estimation.problems import (
    Answer,
    NoiseFree,
    confirmed,
    settled_together,
    settling,
    white_part,
)
from axisid.estimation.regression import Covariance, Solution, beyond_shown, hidden_scatter
from axisid.estimation.thresholds.estimates import MAX_SIMULATION_ERROR, SETTLED_FILTER_BIAS
from axisid.support.arrays import Array
from axisid.support.errors import DataError, EstimationError

from .deviations import lane_solution, shown_variances
from .iteration import LaneFits, unexplained

LaneQuiet = tuple[Array, Array]

_DRAWS, _OF_A_DRAW = 4, 2  # as of one record: orders of the noise, each with either sign
_DRAWN = _DRAWS * _OF_A_DRAW
_TOGETHER = 4  # lanes whose draws are simulated together


@lru_cache(maxsize=2)  # a block's lanes are as long as each other
def _orders(samples: int) -> tuple[NDArray[np.int64], ...]:
    """The orders in which noise of so many samples is drawn, the same at every place."""
    rng = np.random.default_rng(0)
    return tuple(rng.permutation(samples) for _ in range(_DRAWS))


class NoisyLoops:
    """The loops of some lanes with their noise in other orders.

    Parameters
    ----------
    block : Block
    fits : LaneFits
    lanes : array of int
    """

    def __init__(self, block: Block, fits: LaneFits, lanes: NDArray[np.intp]) -> None:
        self._block, self._fits = block, fits
        self._solutions = {lane: lane_solution(block, fits, lane) for lane in map(int, lanes)}

    def settled(
        self, first: LaneQuiet, last: LaneQuiet, deviations: Array, model: Covariance
    ) -> dict[int, NoiseFree | None]:
        """By lane the bias with noise where that is the record's, or else without, if in doubt.

        None where a loop cannot be simulated, or its rows not be solved.

        Parameters
        ----------
        first, last : LaneQuiet
            Bias (L, p) and residuals (n, L) of the loops without noise: at the estimate, and where
            the correction leads.
        deviations : (L, p) array
        model : Covariance
        """
        theta = {lane: self._fits.theta[lane] for lane in self._solutions}
        quiet = {lane: self._quiet(lane, *_of_lane(first, lane)) for lane in theta}
        position = {lane: self._fits.position[:, lane] for lane in theta}
        here = self._with_noise(quiet, theta, position, deviations)
        talks = {
            lane: settling(at, theta[lane], deviations[lane])
            for lane, at in here.items()
            if isinstance(at, NoiseFree)
        }
        noisy = settled_together(talks, self._found_at)
        found: dict[int, NoiseFree | None] = dict.fromkeys(self._solutions)
        for lane, at in noisy.items():
            with suppress(DataError, EstimationError):
                plain = self._quiet(lane, *_of_lane(last, lane))
                found[lane] = _chosen(at, plain, self._solutions[lane], model)
        return found

    def _quiet(self, lane: int, bias: Array, residuals: Array) -> NoiseFree:
        return NoiseFree(
            regressor=np.zeros((0, len(bias))),
            theta=self._fits.theta[lane] + bias,
            residuals=self._there(lane, residuals[:, None])[0],
            bias=bias,
        )

    def _found_at(self, asked: dict[int, Array]) -> dict[int, Answer]:
        """The same at other parameters; None of lanes whose loop does not follow."""
        lanes = list(asked)
        loops = self._solved(lanes, np.array([asked[lane] for lane in lanes]), None)
        apart = unexplained(self._fits.measured.whole[:, lanes], loops.whole)
        quiet, answers = {}, dict[int, Answer](dict.fromkeys(asked))
        for i, lane in enumerate(lanes):
            if not loops.well[i]:
                answers[lane] = _not_simulated()
            elif apart[i] < MAX_SIMULATION_ERROR.value:
                bias = loops.found.theta[i] - asked[lane]
                quiet[lane] = self._quiet(lane, bias, loops.found.residuals[:, i])
        position = {lane: loops.position[:, i] for i, lane in enumerate(lanes)}
        return answers | self._with_noise(quiet, asked, position, None)

    def _with_noise(
        self,
        quiet: dict[int, NoiseFree],
        physical: dict[int, Array],
        position: dict[int, Array],
        deviations: Array | None,
    ) -> dict[int, Answer]:
        """The same of loops with noise, unless the first draw shows that it is no matter.

        `position` are those of the loops without, (N,).
        """
        measured = self._block.lanes.position
        noise = {lane: white_part(measured[:, lane] - position[lane]) for lane in quiet}
        answers = dict[int, Answer](quiet)
        shaken = [lane for lane in quiet if noise[lane].any()]
        for begin in range(0, len(shaken), _TOGETHER):
            lanes = shaken[begin : begin + _TOGETHER]
            drawn = np.column_stack([_drawn(noise[lane]) for lane in lanes])
            loops = self._solved(lanes, np.array([physical[lane] for lane in lanes]), drawn)
            for i, lane in enumerate(lanes):
                own = loops.of(slice(i * _DRAWN, (i + 1) * _DRAWN))
                limits = None if deviations is None else deviations[lane]
                answers[lane] = self._shaken(lane, quiet[lane], physical[lane], own, limits)
        return answers

    def _shaken(
        self, lane: int, quiet: NoiseFree, physical: Array, loops: "_Loops", limits: Array | None
    ) -> Answer:
        """What the draws of a lane say of its bias."""
        if not loops.well.all():
            return _not_simulated()
        moved = loops.found.theta - physical
        if limits is not None:
            apart = np.abs(moved[:_OF_A_DRAW].mean(axis=0) - quiet.bias)
            if np.all(apart <= SETTLED_FILTER_BIAS.value * limits):
                return quiet
        left = self._there(lane, loops.found.residuals)
        return replace(
            quiet,
            bias=np.mean(moved, axis=0),
            has_noise=True,
            hidden=self._hidden(lane, loops.found),
            halves=left.reshape(2, -1, left.shape[1]).mean(axis=1),
        )

    def _solved(self, lanes: list[int], physical: Array, noise: Array | None) -> "_Loops":
        """What the instruments make of loops of lanes with parameters (m, p), as often as drawn."""
        block, fits = self._block, self._fits
        each = np.repeat(lanes, 1 if noise is None else _DRAWN)
        begin, _ = block.starts
        start = replace(begin, position=begin.position[each], velocity=begin.velocity[each])
        sets = np.repeat(physical, len(each) // len(lanes), axis=0)
        loops, well = simulated_lanes(block.axis, sets, block.lanes, start, noise)
        position = loops["position"]
        if noise is None:
            position = position.copy()  # which outlives the loops
        else:
            position += noise  # as it is measured
        excluded, there = (
            None if given is None else given[:, each] for given in (fits.excluded, fits.rows)
        )
        rows = block.rows(block.seen(position, loops["control"]), excluded, there)
        instruments = np.ascontiguousarray(fits.instruments[:, :, each])
        found = solved(block.library, rows.left, rows.regressor, instruments)
        return _Loops(found=found, whole=rows.whole, position=position, well=well)

    def _hidden(self, lane: int, found: LaneSolutions) -> Array:
        """As `hidden_scatter`, of variances alone, which is all that is asked of lanes."""
        instruments = np.repeat(self._fits.instruments[:, :, [lane]], len(found.theta), axis=2)
        rows = len(self._solutions[lane].residuals)
        shown = shown_variances(self._block, found, instruments, rows)
        if shown is None:
            return hidden_scatter(self._alone(lane, found))
        return beyond_shown(found.theta, np.diag(shown))

    def _alone(self, lane: int, found: LaneSolutions) -> list[Solution]:
        """Solutions of a lane's loops as if each were alone."""
        own = self._there(lane, self._fits.instruments[:, :, lane]).T
        left, solution = self._there(lane, found.residuals), self._solutions[lane]
        return [
            replace(solution, theta=theta, residuals=e, influence=own @ mixing.T)
            for theta, e, mixing in zip(found.theta, left, found.mixing, strict=True)
        ]

    def _there(self, lane: int, columns: Array) -> Array:
        """Columns (n, B) in the rows that a lane has, (B, rows)."""
        rows = self._fits.rows
        kept = columns if rows is None else columns[rows[:, lane]]
        return np.ascontiguousarray(kept.T)


@dataclass(frozen=True, slots=True)
class _Loops:
    """Solutions, left sides (n, B), positions as measured (N, B), and which went well, (B,)."""

    found: LaneSolutions
    whole: Array
    position: Array
    well: NDArray[np.bool_]

    def of(self, loops: slice) -> "_Loops":
        """Some of them."""
        found = self.found
        some = replace(
            found,
            theta=found.theta[loops],
            residuals=np.ascontiguousarray(found.residuals[:, loops]),
            mixing=found.mixing[loops],
            power=found.power[loops],
            sound=found.sound[loops],
        )
        return _Loops(some, self.whole[:, loops], self.position[:, loops], self.well[loops])


def _chosen(noisy: NoiseFree, quiet: NoiseFree, solution: Solution, model: Covariance) -> NoiseFree:
    """The bias with noise where that is the record's, or else without."""
    with_noise = confirmed(noisy, solution, model)
    if with_noise.has_noise and not with_noise.doubt:
        return with_noise
    return confirmed(quiet, solution, model)


def _of_lane(quiet: LaneQuiet, lane: int) -> LaneQuiet:
    bias, residuals = quiet
    return bias[lane].copy(), residuals[:, lane]


def _drawn(noise: Array) -> Array:
    """Noise (N,) in other orders, each with either sign, (N, draws)."""
    orders = [noise[order] for order in _orders(len(noise))]
    return np.column_stack([sign * each for each in orders for sign in (1.0, -1.0)])


def _not_simulated() -> EstimationError:
    return EstimationError("a loop with noise cannot be simulated.", code="noisy-loop")
