"""The instruments' iteration of lanes; see `axisid.estimation.methods.instrumental`."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from axisid.estimation.methods import Pace
from axisid.estimation.thresholds import CONVERGED
from axisid.support.arrays import Array

from .block import Block, Chosen, LaneRows
from .regression import inverse_products, row_counts, solved
from .workspace import of_lanes, put_lanes, some_lanes

_MOST = 8  # steps of lanes; what takes more is identified alone


@dataclass(frozen=True, slots=True, kw_only=True)
class LaneFits:
    """Where lanes ended, (L, ...) each; what is not `well` is to be identified alone.

    Attributes
    ----------
    measured : LaneRows
    rows : (n, L) array of bool or None
        Which there are.
    well : (L,) array of bool
    theta, residuals, mixing, power
        Of the solutions, see `LaneSolutions`.
    instruments : (n, p, L) array
    iterations : (L,) array of int
    """

    measured: LaneRows
    rows: Chosen | None
    well: Chosen
    theta: Array
    residuals: Array
    mixing: Array
    power: Array
    instruments: Array
    iterations: NDArray[np.int64]

    @property
    def counts(self) -> Array:
        """Rows of each lane, (L,)."""
        return row_counts(self.rows, self.measured.left.shape)


@dataclass(slots=True, kw_only=True)
class Loops:
    """Loops of all lanes simulated with one estimate each, and their reduced right sides."""

    position: Array
    Z: Array
    intercept: Array | float
    well: Chosen


def loops_of(
    block: Block, physical: Array, chosen: Chosen, excluded: Chosen | None, rows: Chosen | None
) -> Loops:
    """Simulate chosen lanes with parameters (L, p); what others have is of no meaning."""
    raw, fine = block.simulated(physical[chosen], chosen)
    lanes = np.flatnonzero(chosen)
    own, there = some_lanes(excluded, lanes), some_lanes(rows, lanes)
    Z, intercept = block.simulated_rows(raw, physical[chosen], own, there)
    well = np.zeros(len(chosen), dtype=bool)
    well[lanes[fine]] = True
    return Loops(
        position=raw["position"],
        Z=Z,
        intercept=intercept,
        well=well,
    )


def unexplained(whole: Array, simulated: Array) -> Array:
    """Percent of the left side (n, L) that simulated ones leave, (L,)."""
    with np.errstate(all="ignore"):
        error = np.linalg.norm(whole - simulated, axis=0) / np.linalg.norm(whole, axis=0)
    return np.asarray(100 * error)


def iterated(
    block: Block,
    measured: LaneRows,
    excluded: Chosen | None,
    rows: Chosen | None,
    physical: Array,
    active: Chosen,
    loops: Loops,
) -> LaneFits:
    """Iterate lanes from least squares (L, p), whose loops are known, until they stand still."""
    n, p, lanes = measured.regressor.shape
    end = LaneFits(  # its arrays are filled in as lanes end
        measured=measured,
        rows=rows,
        well=np.zeros(lanes, dtype=bool),
        theta=np.full((lanes, p), np.nan),
        residuals=np.zeros((n, lanes)),
        mixing=np.zeros((lanes, p, p)),
        power=np.zeros(lanes),
        instruments=np.zeros((n, p, lanes)),
        iterations=np.zeros(lanes, dtype=np.int64),
    )
    paces = [Pace() for _ in range(lanes)]
    counts = row_counts(rows, measured.left.shape)
    physical, size = physical.copy(), np.full(lanes, np.inf)
    active = active.copy()
    for step in range(1, _MOST + 2):
        at = np.flatnonzero(active)
        active &= loops.well
        inside = loops.well[at]  # of the lanes that were simulated
        at = at[inside]
        done = size[at] <= CONVERGED.value
        if done.any():
            end.well[at[done]], end.iterations[at[done]] = True, step - 1
            active[at[done]] = False
        if not active.any() or step > _MOST:
            break
        going = at[~done]
        Z = of_lanes(loops.Z, np.flatnonzero(inside)[~done])
        left, regressor = (of_lanes(e, going) for e in (measured.left, measured.regressor))
        found = solved(block.library, left, regressor, Z)
        inverse = inverse_products(block.library, Z)
        sigma = found.power / (counts[going] - 1)
        deviations = np.sqrt(sigma[:, None] * np.diagonal(inverse, axis1=1, axis2=2))
        end.theta[going], end.residuals[:, going] = found.theta, found.residuals
        end.mixing[going] = found.mixing
        put_lanes(end.instruments, going, Z)
        end.power[going] = found.power
        for i, lane in enumerate(going):
            size[lane], _ = paces[lane].step(physical[lane], found.theta[i], deviations[i])
            found.sound[i] &= paces[lane].share == 1.0
        physical[going] = found.theta
        active[going[~found.sound]] = False
        if active.any():
            loops = loops_of(block, physical, active, excluded, rows)
    return end
