"""A block of lanes behind one filter: their rows, measured and simulated."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.estimation.loops import loop_starts
from axisid.estimation.signals import FilteredRecord, SampledFilter, drive_force
from axisid.estimation.simulation import simulate_batch
from axisid.estimation.thresholds.signals import MIN_ROW_WEIGHT, REST_SPEED
from axisid.support.arrays import Array

from .lanes import RecordLanes

_SIMULATED = (
    "position",
    "velocity",
    "acceleration",
    "force",
    "control",
    "direction",
    "direction_before",
)
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
    regressor : (n, L, p) array
    """

    left: Array
    whole: Array
    regressor: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class LaneSignals:
    """Motion and force sample by sample, (N, L) each."""

    position: Array
    velocity: Array
    acceleration: Array
    force: Array
    direction: Array


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
        return self.seen(self.lanes.position, self.lanes.control)

    def seen(self, position: Array, control: Array) -> LaneSignals:
        """Positions and controls, (N, L), as measured ones are filtered."""
        period = self.lanes.period
        q = self.filter.low_passed(position)
        dq = np.gradient(q, period, axis=0)
        ddq = np.gradient(dq, period, axis=0)
        force = self._force(control, q, dq)
        if delay := self.template.hold_delay:
            force = (1 - delay) * force + delay * _earlier(force)
        return LaneSignals(
            position=q, velocity=dq, acceleration=ddq, force=force, direction=np.sign(dq)
        )

    def _force(self, control: Array, q: Array, dq: Array) -> Array:
        flat = (np.ravel(each) for each in (control, q, dq))
        return drive_force(self.axis, *flat).reshape(control.shape)

    def columns(self, s: LaneSignals) -> tuple[Array, Array]:
        """Regressor, (N, L, p), and what no parameter scales, (N, L)."""
        motion = (s.position, s.velocity, s.acceleration, s.direction)
        row, known = self.axis.evaluate("idm_regressor", *(np.ravel(each) for each in motion))
        shape = s.position.shape
        return row.reshape(*shape, -1), known.reshape(shape)

    def reduced(self, columns: Array, excluded: Chosen | None, rows: Chosen | None) -> Array:
        """Columns (N, L, c) through the decimation filter, (n, L, c)."""
        if excluded is not None:
            columns = np.where(excluded[:, :, None], 0.0, columns)
        flat = self.filter.reduce(columns.reshape(len(columns), -1))
        found = flat.reshape(len(flat), *columns.shape[1:])
        return found if rows is None else np.where(rows[:, :, None], found, 0.0)

    def rows_of(self, excluded: Chosen | None) -> Chosen | None:
        """Which rows lanes have, (n, L), without excluded samples; None for all."""
        if excluded is None:
            return None
        ones = np.ones((*excluded.shape, 1))
        found = self.reduced(ones, excluded, None)[:, :, 0] > MIN_ROW_WEIGHT.value
        return np.asarray(found | ~excluded.any(axis=0))

    def rows(self, s: LaneSignals, excluded: Chosen | None, rows: Chosen | None) -> LaneRows:
        """Rows of signals."""
        regressor, known = self.columns(s)
        every = np.concatenate([regressor, s.force[:, :, None], known[:, :, None]], axis=2)
        found = self.reduced(every, excluded, rows)
        return LaneRows(
            left=found[:, :, -2] - found[:, :, -1],
            whole=found[:, :, -2],
            regressor=found[:, :, :-2],
        )

    def turns(self, velocity: Array) -> Chosen:
        """Samples near reversals and rests of filtered velocities, (N, L)."""
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

    @cached_property
    def start(self) -> LoopStart:
        """Where the loops start."""
        found = [loop_starts(self.axis, self.lanes.record(i))[0] for i in range(len(self.lanes))]
        memories = [each.memory for each in found]
        return LoopStart(
            position=np.array([each.position for each in found]),
            velocity=np.array([each.velocity for each in found]),
            memory=None if memories[0] is None else np.array(memories),
        )

    def simulated(self, physical: Array, chosen: Chosen) -> tuple[dict[str, Array], Chosen]:
        """Loops of some lanes with parameters (B, p), and which of them went well."""
        start = self.start
        memory = None if start.memory is None else start.memory[chosen]
        batch = simulate_batch(
            self.axis,
            physical,
            self.lanes.reference,
            self.lanes.period,
            start=start.position[chosen],
            start_velocity=start.velocity[chosen],
            memory=memory,
            wanted=_SIMULATED,
            threads=1,
        )
        well = np.array([lane not in batch.failures for lane in range(len(physical))])
        return batch.signals, well

    def simulated_columns(
        self, loops: dict[str, Array], physical: Array
    ) -> tuple[Array, Array]:
        """Regressor and intercept of simulated loops, as their rows have them."""
        s = LaneSignals(**{name: loops[name] for name in _SIMULATED[:4] + ("direction",)})
        regressor, known = self.columns(s)
        if not self.held:
            return regressor, known
        force, before = _earlier(loops["force"]), loops["direction_before"]
        sets = np.broadcast_to(physical, (len(force), *physical.shape)).reshape(force.size, -1)
        motion = (np.ravel(each) for each in (s.position, s.velocity, force, before))
        (acceleration,) = self.axis.evaluate("direct_dynamics", *motion, sets)
        earlier = LaneSignals(
            position=s.position,
            velocity=s.velocity,
            acceleration=acceleration.reshape(force.shape),
            force=force,
            direction=before,
        )
        other, known_before = self.columns(earlier)
        return (regressor + other) / 2, (known + known_before) / 2


def _earlier(values: Array) -> Array:
    """Values of the sample before, (N, L)."""
    return np.concatenate([values[:1], values[:-1]])
