"""What the prefilter moves the estimates of lanes by; see `axisid.estimation.problems`."""

from dataclasses import dataclass

import numpy as np

from axisid.estimation.batched.rows import (
    Block,
    Chosen,
    of_lanes,
    products,
    solved,
    some_lanes,
)
from axisid.estimation.regression import Covariance
from axisid.estimation.thresholds.estimates import (
    MAX_FILTER_HOP,
    MAX_SIMULATION_ERROR,
    MIN_FILTER_SHARE,
    MIN_PRINTED_FILTER_BIAS,
    SETTLED_FILTER_BIAS,
)
from axisid.support.arrays import Array

from .iteration import LaneFits, unexplained
from .noisy_loops import NoisyLoops

_MOST = 6  # corrections, as of one record


@dataclass(frozen=True, slots=True)
class LaneBias:
    """What moves the estimates of lanes.

    Attributes
    ----------
    bias : (L, p) array
    hidden : (L, p) array
        What noise in the loop adds to their variances.
    well : (L,) array of bool
        Of which lanes it is as of one alone.
    """

    bias: Array
    hidden: Array
    well: Chosen


@dataclass(slots=True)
class _Found:
    """Bias (L, p) and residuals (n, L) of quiet loops, and which lanes have them."""

    bias: Array
    residuals: Array
    well: Chosen


def lane_bias(block: Block, fits: LaneFits, deviations: Array, model: Covariance) -> LaneBias:
    """The filter's bias of lanes that ended well, for deviations (L, p) under a covariance."""
    chosen = fits.well & fits.follows
    if not chosen.any():
        none = np.full_like(fits.theta, np.nan)
        return LaneBias(bias=none, hidden=np.zeros_like(none), well=chosen)
    lanes = np.flatnonzero(chosen)
    position, control = (of_lanes(each, lanes) for each in (fits.position, fits.control))
    first = _quiet(block, fits, position, control, fits.theta, chosen)
    size = _in_deviations(first.bias, deviations)
    bias, well = first.bias.copy(), first.well.copy()
    residuals = first.residuals.copy()
    before, settled = first.bias.copy(), ~chosen | (size <= MIN_PRINTED_FILTER_BIAS.value)
    moving = ~settled & well
    corrected = moving.copy()
    for turn in range(_MOST):
        if not moving.any():
            break
        again = _again(block, fits, bias, moving)
        well &= again.well | ~moving
        moving &= again.well
        moved = _in_deviations(again.bias - bias, deviations)
        grows = moving & ~(moved < size)
        hops = grows & (turn > 0) & (moved <= MAX_FILTER_HOP.value)
        well &= ~(grows & ~hops)  # in doubt, which a lane alone tells
        now = moving & ~grows
        bias[hops] = (bias[hops] + again.bias[hops]) / 2
        residuals[:, hops | now] = again.residuals[:, hops | now]
        before[now], bias[now], size[now] = bias[now], again.bias[now], moved[now]
        moving = now & (moved > SETTLED_FILTER_BIAS.value)
    middle = moving & (size <= MAX_FILTER_HOP.value)
    bias[middle] = (before[middle] + bias[middle]) / 2
    well &= ~(moving & ~middle)
    both = np.stack([residuals, fits.residuals], axis=1)
    own, shared = products(block.library, residuals[:, None], both)[:, 0].T
    with np.errstate(all="ignore"):
        share = shared / own
    hidden = np.zeros_like(bias)
    # Where the record lacks the error, loops with noise are asked.
    asked = well & corrected & ~(share >= MIN_FILTER_SHARE.value) & (own > 0)
    noisy = NoisyLoops(block, fits, np.flatnonzero(asked))
    places = (first.bias, first.residuals), (bias, residuals)
    for lane, found in noisy.settled(*places, deviations, model).items():
        well[lane] = found is not None
        if found is not None:
            bias[lane] = np.nan if found.doubt else found.bias
            hidden[lane] = 0.0 if found.hidden is None else np.diag(found.hidden)
    return LaneBias(bias=bias, hidden=hidden, well=well & chosen)


def _in_deviations(change: Array, deviations: Array) -> Array:
    """Largest change of each lane, (L,)."""
    there = deviations > 0
    sizes = np.divide(np.abs(change), deviations, out=np.zeros_like(change), where=there)
    return np.asarray(sizes.max(axis=1))


def _again(block: Block, fits: LaneFits, bias: Array, chosen: Chosen) -> _Found:
    """The bias of loops with corrected parameters."""
    physical = fits.theta - bias
    raw, fine = block.simulated(physical[chosen], chosen)
    there = chosen.copy()
    there[np.flatnonzero(chosen)[~fine]] = False
    if not fine.any():
        return _Found(np.full_like(bias, np.nan), np.zeros_like(fits.residuals), there)
    position, control = (
        of_lanes(raw[name], np.flatnonzero(fine)) for name in ("position", "control")
    )
    return _quiet(block, fits, position, control, physical, there, check=True)


def _quiet(
    block: Block,
    fits: LaneFits,
    position: Array,
    control: Array,
    physical: Array,
    chosen: Chosen,
    *,
    check: bool = False,
) -> _Found:
    """What the instruments make of loops of chosen lanes, simulated with parameters (L, p)."""
    lanes = np.flatnonzero(chosen)
    excluded, there = (some_lanes(each, lanes) for each in (fits.excluded, fits.rows))
    rows = block.rows(block.seen(position, control), excluded, there)
    found = solved(block.library, rows.left, rows.regressor, of_lanes(fits.instruments, lanes))
    bias, residuals = np.full_like(fits.theta, np.nan), np.zeros_like(fits.residuals)
    bias[chosen], residuals[:, chosen] = found.theta - physical[chosen], found.residuals
    well = chosen.copy()
    well[chosen] = found.sound
    if check:
        error = unexplained(fits.measured.whole[:, chosen], rows.whole)
        well[chosen] &= error < MAX_SIMULATION_ERROR.value
    return _Found(bias, residuals, well)
