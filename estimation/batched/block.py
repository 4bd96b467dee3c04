"""A block of lanes behind one filter: their rows, measured and simulated.

The filter before decimation is a sum of modes, so that only the rows that are kept are made.
Forward and backward, the filter's response is that of its poles, each once running forward and once
backward. Of such a sum a row in so many costs a few products of the samples in between, where the
sections one after the other make every sample. What the sections have at the ends of a stretch, the
modes have too: the forward pass starts as after a long time of the first value, the backward pass
as after one of the last that the forward pass made.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from axisid.codegen.artefacts import GeneratedAxis
from axisid.codegen.lowering import LoopStart
from axisid.codegen.native import LaneLibrary, Thinning
from axisid.estimation.signals import DECIMATION_PADDING, FilteredRecord, SampledFilter, drive_force
from axisid.estimation.thresholds import MIN_ROW_WEIGHT, REST_SPEED
from axisid.support.arrays import Array

from .lanes import RecordLanes
from .loops import lane_starts, simulated_lanes
from .regression import products
from .workspace import spaces

_Modes = NDArray[np.complex128]

Chosen = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class _LaneSignals:
    """Lanes as they are measured.

    Attributes
    ----------
    motion : tuple of (N, L) array
        Filtered position, velocity and acceleration.
    control : (N, L) array
    """

    motion: tuple[Array, Array, Array]
    control: Array


def _measured_columns(axis: GeneratedAxis, s: _LaneSignals, delay: float) -> Array:
    """Regressor, known part and force, the force so many samples earlier, (N, p + 2, L)."""
    q, dq, _ = s.motion
    made = drive_force(axis, np.ravel(s.control), np.ravel(q), np.ravel(dq))
    force = made.reshape(q.shape)
    if delay:
        force = (1 - delay) * force + delay * earlier(force)
    return np.concatenate([_motion_rows(axis, (*s.motion, np.sign(dq))), force[:, None]], axis=1)


def _loop_columns(
    axis: GeneratedAxis, signals: tuple[Array, ...], before: Array | None, physical: Array
) -> Array:
    """Regressor and known part of simulated loops, (N, p + 1, L).

    Parameters
    ----------
    axis : GeneratedAxis
    signals : tuple of (N, L) array
        Position, velocity, acceleration, force and direction.
    before : (N, L) array or None
        Directions just before the samples, where rows are the mean of just before and just after.
    physical : (L, p) array
    """
    q, dq, ddq, force, direction = signals
    after = _motion_rows(axis, (q, dq, ddq, direction))
    if before is None:
        return after
    sets = np.broadcast_to(physical, (len(q), *physical.shape)).reshape(q.size, -1)
    motion = (np.ravel(each) for each in (q, dq, earlier(force), before))
    (acceleration,) = axis.evaluate("direct_dynamics", *motion, sets)
    return (after + _motion_rows(axis, (q, dq, acceleration.reshape(q.shape), before))) / 2


def earlier(values: Array) -> Array:
    """Values of the sample before, (N, L)."""
    return np.concatenate([values[:1], values[:-1]])


def _motion_rows(axis: GeneratedAxis, motion: tuple[Array, ...]) -> Array:
    """Regressor and known part of a motion and its direction, (N, L) each: (N, p + 1, L)."""
    row, known = axis.evaluate("idm_regressor", *(np.ravel(each) for each in motion))
    shape = motion[0].shape
    every = np.concatenate([row, known], axis=1).reshape(*shape, -1)
    return np.ascontiguousarray(every.transpose(0, 2, 1))


def _thinning_of(sampled: SampledFilter, samples: int) -> Thinning:
    """Which rows a filter keeps of so many samples, and by what sums.

    Parameters
    ----------
    sampled : SampledFilter
        That decimates.
    samples : int
    """
    every = sampled.settings.decimate
    start, end = sampled.cut
    kept = samples - start - end
    ends = sampled.weightless_ends(samples)
    low, high = (ends[0][1], ends[1][0]) if ends else (0, kept)
    rows = sampled.rows_between(samples, 0, samples) - start
    first = int(rows[0])
    skipped = max(0, math.ceil((first - every + DECIMATION_PADDING) / every))
    begin = first - every * skipped
    last = kept - 1 + DECIMATION_PADDING
    blocks = math.ceil((last - begin) / every) + 1
    beyond = begin + every * (blocks - 1) - last
    poles, residues, gains, direct = _modes(sampled.decimation.sections)
    powers = poles ** np.arange(every + 1)[:, None]
    return Thinning(
        sizes=np.array(
            [
                start,
                kept,
                low,
                high,
                DECIMATION_PADDING,
                every,
                begin,
                skipped,
                blocks,
                len(rows),
            ],
            dtype=np.int64,
        ),
        powers=_pairs(powers),
        gains=_pairs(2 * gains.conj()),  # the real part of a product
        settled=_pairs(1 / (1 - poles)),
        ends=_ends(poles, residues, gains, beyond),
        direct=direct,
    )


def _modes(sections: Array) -> tuple[_Modes, _Modes, _Modes, float]:
    """One pole of each pair, its residue, its gain forward and backward, and what is direct."""
    pairs = np.array([np.roots(section[3:]) for section in sections])
    poles: _Modes = np.where(pairs[:, 0].imag > 0, pairs[:, 0], pairs[:, 1])
    every = np.concatenate([poles, poles.conj()])

    def numerator(delays: _Modes) -> _Modes:
        powers = delays[:, None, None] ** np.arange(3)
        return np.asarray(np.prod((powers * sections[:, :3]).sum(axis=-1), axis=-1))

    others = [np.prod(1 - every[every != pole] / pole) for pole in poles]
    residues = numerator(np.asarray(1 / poles, dtype=complex)) / np.array(others)
    behind = numerator(poles) / np.prod(1 - poles[:, None] * every, axis=1)
    first = float(np.prod(sections[:, 0]))
    last = float(np.prod(sections[:, 2] / sections[:, 5]))
    return poles, residues, residues * behind, first * last


def _ends(poles: _Modes, residues: _Modes, gains: _Modes, beyond: int) -> Array:
    """What modes that run backward start from, by how far the forward ones are from settled.

    Both `beyond` samples after the last value, which goes on there.
    """
    ahead = np.concatenate([poles, poles.conj()])[None, :]
    weights = np.concatenate([residues, residues.conj()])
    own = poles[:, None]
    sums = own / (1 - own) - own * ahead / (1 - own * ahead)
    found = (residues / gains)[:, None] * own**-beyond * weights * ahead**-beyond * sums
    same, other = found[:, : len(poles)], found[:, len(poles) :]
    real, imaginary = same + other, 1j * (same - other)  # of the forward modes' parts
    matrix = np.empty((2 * len(poles),) * 2)
    matrix[0::2, 0::2], matrix[1::2, 0::2] = real.real, real.imag
    matrix[0::2, 1::2], matrix[1::2, 1::2] = imaginary.real, imaginary.imag
    return matrix


def _pairs(values: _Modes) -> Array:
    """Real and imaginary parts in turn along the last axis."""
    parts = np.stack([values.real, values.imag], axis=-1)
    return parts.reshape(*values.shape[:-1], -1)


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
    def measured(self) -> _LaneSignals:
        """The filtered motion beside the force."""
        return self.seen(self.lanes.position, self.lanes.control, "measured")

    @cached_property
    def library(self) -> LaneLibrary | None:
        """Compiled rows; None where there is no compiler, or nothing is decimated."""
        return None if self.template.prefilter.decimate == 1 else self.axis.native.lanes()

    @cached_property
    def thinning(self) -> Thinning:
        """Which rows are kept, and by what sums."""
        return _thinning_of(self.filter, len(self.lanes.reference))

    def seen(self, position: Array, control: Array, name: str = "seen") -> _LaneSignals:
        """Positions and controls, (N, L), with the motion as measured ones are filtered.

        It is there until others of the name are looked at.
        """
        period, sampled = self.lanes.period, self.filter
        if self.library is None:
            q = sampled.low_passed(position)
            dq = np.gradient(q, period, axis=0)
            return _LaneSignals(motion=(q, dq, np.gradient(dq, period, axis=0)), control=control)
        q, dq, ddq = spaces(name, 3, *position.shape)
        low_pass = sampled.low_pass
        self.library.motion(
            position, low_pass.sections, low_pass.settled, sampled.padding, period, (q, dq, ddq)
        )
        return _LaneSignals(motion=(q, dq, ddq), control=control)

    def velocity(self, position: Array) -> Array:
        """Of positions as measured ones are filtered, (N, L)."""
        return self.seen(position, position).motion[1]

    def rows(self, s: _LaneSignals, excluded: Chosen | None, rows: Chosen | None) -> LaneRows:
        """Rows of signals."""
        if self.library is not None:
            delay, thinning = self.template.hold_delay, self.thinning
            found = self.library.measured(s.control, s.motion, delay, excluded, thinning)
        else:
            found = self._reduced(
                _measured_columns(self.axis, s, self.template.hold_delay), excluded
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
            found = self._reduced(_loop_columns(self.axis, signals, before, physical), excluded)
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
        rows = _motion_rows(self.axis, (*motion, np.sign(motion[1])))[
            :, : len(self.axis.parameters)
        ]
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
