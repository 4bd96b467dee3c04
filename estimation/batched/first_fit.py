"""Where lanes begin: which samples count, least squares, and the loops simulated with it.

As of one record, see `axisid.estimation.methods.bound_record` and `starting`.
"""

from dataclasses import dataclass

import numpy as np

from axisid.estimation.batched.rows import (
    Block,
    Chosen,
    LaneRows,
    solved,
)
from axisid.estimation.signals import Information, Prefilter, losses_count, searches_friction
from axisid.estimation.thresholds import (
    MAX_SIMULATION_ERROR,
    MIN_INFORMATION_LEFT,
    MIN_MOVING_SPEED,
)
from axisid.support.arrays import Array

from .iteration import LaneFits, Loops, iterated, loops_of, simulated_left, unexplained
from .served import clearly_shown


@dataclass(frozen=True, slots=True, kw_only=True)
class FirstFit:
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


def fitted_lanes(block: Block, asked: Prefilter) -> LaneFits:
    """Lanes from their samples to where the instruments' iteration ends."""
    excluded = near_reversals(block, asked)
    shown = np.ones(len(block.lanes), dtype=bool)
    if excluded is not None:
        first = first_fit(block, excluded, block.rows_of(excluded))
        again = block.turns(block.velocity(first.loops.position))
        # Where the loop does not follow, the record's own reversals stay.
        excluded = np.where(first.follows & excluded.any(axis=0), again, excluded)
        shown = first.shown
    rows = block.rows_of(excluded)
    first = first_fit(block, excluded, rows)
    active = first.follows & first.shown & shown
    return iterated(block, first.measured, excluded, rows, first.theta, active, first.loops)


def first_fit(block: Block, excluded: Chosen | None, rows: Chosen | None) -> FirstFit:
    """Least squares of all lanes, with the samples and rows that they have."""
    measured = block.rows(block.measured, excluded, rows)
    found = solved(block.library, measured.left, measured.regressor, measured.regressor)
    every = np.ones(len(block.lanes), dtype=bool)
    loops = loops_of(block, found.theta, every, excluded, rows)
    error = unexplained(measured.whole, simulated_left(loops, found.theta))
    return FirstFit(
        measured=measured,
        theta=found.theta,
        loops=loops,
        follows=loops.well & found.sound & (error < MAX_SIMULATION_ERROR.value),
        shown=clearly_shown(block, measured, rows, found),
    )


def near_reversals(block: Block, asked: Prefilter) -> Chosen | None:
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
