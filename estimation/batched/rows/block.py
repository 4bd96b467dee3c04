"""A block of lanes behind one filter: their rows, measured and simulated."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.codegen.native import LaneLibrary, Thinning
from axisid.estimation.signals import FilteredRecord, SampledFilter
from axisid.estimation.thresholds import MIN_ROW_WEIGHT, REST_SPEED
from axisid.support.arrays import Array

from .columns import LaneSignals, loop_columns, measured_columns, motion_rows
from .lane_starts import lane_starts
from .lanes import RecordLanes
from .loops import simulated_lanes
from .regression import products
from .thinning import thinning_of
from .workspace import spaces

Chosen = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class LaneRows:
    """Rows of the inverse model, of lanes; zero where a lane has none.

    Attributes
    ----------
    left : (n, L) array
        Less what no parameter scales.
    whole : (n, L) array
        With it.
    regressor : (n, p, L) array
    """

    left: Array
    whole: Array
    regressor: Array


@dataclass(frozen=True, kw_only=True)
class Block:
    """Lanes that are identified side by side.

    Attributes
    ----------
    axis : GeneratedAxis
    lanes : RecordLanes
    template : FilteredRecord
        Of one of them, with all its samples: what is the same for all.
    """

    axis: GeneratedAxis
    lanes: RecordLanes
    template: FilteredRecord

    @property
    def filter(self) -> SampledFilter:
        """What the prefilter does to a lane."""
        return self.template.sampling.filter

    @property
    def held(self) -> bool:
        """Whether the force is paired with the motion as a hold does."""
        return self.template.prefilter.hold == "zoh"

    @cached_property
    def measured(self) -> LaneSignals:
        """The filtered motion beside the force."""
        return self.seen(self.lanes.position, self.lanes.control, "measured")

    @cached_property
    def library(self) -> LaneLibrary | None:
        """Compiled rows; None where there is no compiler, or nothing is decimated."""
        return None if self.template.prefilter.decimate == 1 else self.axis.native.lanes()

    @cached_property
    def thinning(self) -> Thinning:
        """Which rows are kept, and by what sums."""
        return thinning_of(self.filter, len(self.lanes.reference))

    def seen(self, position: Array, control: Array, name: str = "seen") -> LaneSignals:
        """Positions and controls, (N, L), with the motion as measured ones are filtered.

        It is there until others of the name are looked at.
        """
        period, sampled = self.lanes.period, self.filter
        if self.library is None:
            q = sampled.low_passed(position)
            dq = np.gradient(q, period, axis=0)
            return LaneSignals(motion=(q, dq, np.gradient(dq, period, axis=0)), control=control)
        q, dq, ddq = spaces(name, 3, *position.shape)
        low_pass = sampled.low_pass
        self.library.motion(
            position, low_pass.sections, low_pass.settled, sampled.padding, period, (q, dq, ddq)
        )
        return LaneSignals(motion=(q, dq, ddq), control=control)

    def velocity(self, position: Array) -> Array:
        """Of positions as measured ones are filtered, (N, L)."""
        return self.seen(position, position).motion[1]

    def rows(self, s: LaneSignals, excluded: Chosen | None, rows: Chosen | None) -> LaneRows:
        """Rows of signals."""
        if self.library is not None:
            delay, thinning = self.template.hold_delay, self.thinning
            found = self.library.measured(s.control, s.motion, delay, excluded, thinning)
        else:
            found = self._reduced(
                measured_columns(self.axis, s, self.template.hold_delay), excluded
            )
        found, p = _kept(found, rows), len(self.axis.parameters)
        whole = found[:, -1]
        known = found.shape[1] > p + 1
        return LaneRows(
            left=whole - found[:, p] if known else whole, whole=whole, regressor=found[:, :p]
        )

    def simulated_rows(
        self,
        loops: dict[str, Array],
        physical: Array,
        excluded: Chosen | None,
        rows: Chosen | None,
    ) -> tuple[Array, Array | float]:
        """Regressor, (n, p, L), and known part, (n, L) or nothing, of simulated loops."""
        names = ("position", "velocity", "acceleration", "force", "direction")
        signals = tuple(loops[name] for name in names)
        before = loops["direction_before"] if self.held else None
        if self.library is not None:
            found = self.library.simulated(signals, before, physical, excluded, self.thinning)
        else:
            found = self._reduced(loop_columns(self.axis, signals, before, physical), excluded)
        found, p = _kept(found, rows), len(self.axis.parameters)
        return found[:, :p], found[:, p] if found.shape[1] > p else 0.0

    def rows_of(self, excluded: Chosen | None) -> Chosen | None:
        """Which rows lanes have, (n, L), without excluded samples; None for all."""
        if excluded is None:
            return None
        if self.library is not None:
            weights = self.library.weights(excluded, self.thinning)
        else:
            weights = self._reduced(np.ones((len(excluded), 1, excluded.shape[1])), excluded)[:, 0]
        found = weights > MIN_ROW_WEIGHT.value
        return np.asarray(found | ~excluded.any(axis=0))

    def _reduced(self, columns: Array, excluded: Chosen | None) -> Array:
        """Columns (N, c, L) through the decimation filter, (n, c, L)."""
        if excluded is not None:
            columns = np.where(excluded[:, None, :], 0.0, columns)
        flat = self.filter.reduce(columns.reshape(len(columns), -1))
        return flat.reshape(len(flat), *columns.shape[1:])

    def turns(self, velocity: Array) -> Chosen:
        """Samples near reversals and rests of filtered velocities, (N, L)."""
        if self.library is not None:
            return self.library.turns(velocity, REST_SPEED.value, self.filter.turn_reach)
        speed = np.abs(velocity)
        direction = np.sign(velocity) * (speed > REST_SPEED.value * speed.max(axis=0))
        turns = direction == 0
        turns[1:] |= direction[1:] != direction[:-1]
        reach = self.filter.turn_reach
        count = np.zeros((len(turns) + 1, turns.shape[1]), dtype=np.int32)
        np.cumsum(turns, axis=0, out=count[1:])
        places = np.arange(len(turns))
        ahead = np.minimum(places + reach + 1, len(turns))
        return np.asarray(count[ahead] > count[np.maximum(places - reach, 0)])

    def information(self, near: Chosen, slow: Array) -> tuple[Array, Array]:
        """Products of the regressor's columns over samples that are kept, (L, p, p) each.

        Of those faster than lanes' slow speeds, (L,), and of those that are not near reversals.
        """
        kept, motion = self.template.kept, self.measured.motion
        if self.library is not None:
            moving, left = self.library.information(motion, kept, near, slow)
            return moving.transpose(2, 0, 1), left.transpose(2, 0, 1)
        rows = motion_rows(self.axis, (*motion, np.sign(motion[1])))[:, : len(self.axis.parameters)]
        moves, away = ((kept[:, None] & e)[:, None] for e in (np.abs(motion[1]) > slow, ~near))
        return products(None, moves * rows, rows), products(None, away * rows, rows)

    @cached_property
    def starts(self) -> tuple[LoopStart, Chosen]:
        """Where the loops start, and of which lanes that is as of one alone."""
        lanes = self.lanes
        columns = (lanes.reference, lanes.position, lanes.control)
        return lane_starts(self.axis, *columns, lanes.period, lanes.record)

    def simulated(self, physical: Array, chosen: Chosen) -> tuple[dict[str, Array], Chosen]:
        """Loops of some lanes with parameters (B, p), and which of them went well."""
        start, _ = self.starts
        own = replace(start, position=start.position[chosen], velocity=start.velocity[chosen])
        return simulated_lanes(self.axis, physical, self.lanes, own)


def _kept(found: Array, rows: Chosen | None) -> Array:
    """Columns (n, c, L), zero in rows that lanes do not have."""
    if rows is not None:
        found *= rows[:, None, :]
    return found
