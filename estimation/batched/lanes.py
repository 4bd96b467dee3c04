"""Lanes, records of one motion: their estimates, and their rows, measured and simulated.

The filter before decimation is a sum of modes, so that only the rows that are kept are made.
Forward and backward, the filter's response is that of its poles, each once running forward and once
backward. Of such a sum a row in so many costs a few products of the samples in between, where the
sections one after the other make every sample. What the sections have at the ends of a stretch, the
modes have too: the forward pass starts as after a long time of the first value, the backward pass
as after one of the last that the forward pass made.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis
from axisid.codegen.lowering import SIGNALS, LoopStart
from axisid.codegen.runtime import Decimation, LaneLibrary
from axisid.estimation.law_replay import (
    START_SAMPLES,
    at_rest_misses,
    below_limit,
    first_velocity,
    law_memory,
    loop_starts,
)
from axisid.estimation.records import Record
from axisid.estimation.regression import Equations
from axisid.estimation.signals import FilteredRecord, Motion, SampledFilter
from axisid.estimation.simulation import LoopInputs, simulate_lanes
from axisid.estimation.thresholds import MIN_ROW_WEIGHT, REST_SPEED
from axisid.support.arrays import Array, BoolArray, ComplexArray, Exact, IntArray
from axisid.support.errors import UsageError

#: How a lane was identified: among others, or as `identify` does it alone.
SIDE_BY_SIDE, ALONE, FAILED = "side by side", "alone", "failed"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecordLanes(Exact):
    """Records of one reference, one a lane, SI.

    Attributes
    ----------
    reference : (N,) array
    position, control : (N, B) array
        Measured, in contiguous memory.
    period : float
        That of the control law, s.
    resolution : float
        Of the encoder; lanes that have one are identified one by one.

    Raises
    ------
    UsageError
        The shapes do not belong together.
    """

    reference: Array
    position: Array
    control: Array
    period: float
    resolution: float = 0.0

    def __post_init__(self) -> None:
        shape = np.shape(self.position)
        if len(shape) != 2 or np.shape(self.control) != shape or len(self.reference) != shape[0]:
            raise UsageError(
                f"the reference has the shape {np.shape(self.reference)}, positions {shape}, "
                f"controls {np.shape(self.control)}; give (N,), (N, B) and (N, B).",
                code="simulation-input",
            )

    def __len__(self) -> int:
        return int(self.position.shape[1])

    def record(self, lane: int) -> Record:
        """One lane as a record."""
        return Record(
            time=self.period * np.arange(float(len(self.reference))),
            position=self.position[:, lane],
            reference=self.reference,
            control=self.control[:, lane],
            sample_period=self.period,
        )

    def part(self, lanes: slice) -> "RecordLanes":
        """Some of the lanes."""
        return RecordLanes(
            reference=self.reference,
            position=np.ascontiguousarray(self.position[:, lanes]),
            control=np.ascontiguousarray(self.control[:, lanes]),
            period=self.period,
            resolution=self.resolution,
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LaneEstimates(Exact):
    """Estimates by one method, one a lane; NaN where there is none.

    Attributes
    ----------
    values : (B, p) array
        Physical parameters, SI.
    deviations : mapping of str to (B, p) array
        By name of `COVARIANCES`.
    freedom : mapping of str to (B, p) array
        Their degrees of freedom.
    iterations : (B,) array of int
    how : tuple of str
        Of each lane: ``side by side``, ``alone`` or ``failed``.
    errors : mapping of int to str
        Why, of lanes that failed.
    """

    values: Array
    deviations: Mapping[str, Array]
    freedom: Mapping[str, Array]
    iterations: IntArray
    how: tuple[str, ...]
    errors: Mapping[int, str]


def _at_rest(axis: GeneratedAxis, reference: Array, position: Array, samples: int) -> Array:
    """The first controls of the law of an axis that rested before, (samples, L)."""
    lanes = position.shape[1]
    commanded = np.broadcast_to(reference[:samples, None], (samples, lanes)).copy()
    (state,) = axis.evaluate("control_start", commanded[0], position[0])
    made = np.empty((samples, lanes))
    for k in range(samples):
        read = (commanded[k], position[k], np.zeros(lanes))
        control, state = axis.evaluate("control_law", *read, state)
        made[k] = control[:, 0]
    return made


_Filter = tuple[ComplexArray, ComplexArray, ComplexArray, float]


#: No filter: modes without memory, which have a quarter of each value.
_ALL_PASS: _Filter = (np.zeros(4, complex), *(np.full(4, 1 / 8, complex),) * 2, 0.0)


def _modes(sampled: SampledFilter) -> _Filter:
    """One pole of each pair, its residue, its gain forward and backward, and what is direct."""
    sections = sampled.decimation.sections
    pairs = np.array([np.roots(section[3:]) for section in sections])
    poles: ComplexArray = np.where(pairs[:, 0].imag > 0, pairs[:, 0], pairs[:, 1])
    every = np.concatenate([poles, poles.conj()])

    def numerator(delays: ComplexArray) -> ComplexArray:
        powers = delays[:, None, None] ** np.arange(3)
        return np.asarray(np.prod((powers * sections[:, :3]).sum(axis=-1), axis=-1))

    others = [np.prod(1 - every[every != pole] / pole) for pole in poles]
    residues = numerator(np.asarray(1 / poles, dtype=complex)) / np.array(others)
    behind = numerator(poles) / np.prod(1 - poles[:, None] * every, axis=1)
    first = float(np.prod(sections[:, 0]))
    last = float(np.prod(sections[:, 2] / sections[:, 5]))
    return poles, residues, residues * behind, first * last


def _ends(poles: ComplexArray, residues: ComplexArray, gains: ComplexArray, beyond: int) -> Array:
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


def _pairs(values: ComplexArray) -> Array:
    """Real and imaginary parts in turn along the last axis."""
    parts = np.stack([values.real, values.imag], axis=-1)
    return parts.reshape(*values.shape[:-1], -1)


@dataclass(frozen=True, kw_only=True)
class LaneBlock:
    """Lanes that are identified side by side.

    Attributes
    ----------
    axis : GeneratedAxis
    library : LaneLibrary
        Its compiled rows.
    lanes : RecordLanes
    template : FilteredRecord
        Of one of them, with all its samples: what is the same for all.
    """

    axis: GeneratedAxis
    library: LaneLibrary
    lanes: RecordLanes
    template: FilteredRecord

    @cached_property
    def motion(self) -> Motion:
        """The measured motion, filtered, (N, L) each."""
        return self.filtered(self.lanes.position)

    @cached_property
    def decimation(self) -> Decimation:
        """Which rows are kept, and by what sums."""
        sampled, samples = self.template.sampling.filter, len(self.lanes.reference)
        every = sampled.settings.decimate
        start, end = sampled.cut
        kept = samples - start - end
        low, high = sampled.dropped[0] - start, samples - sampled.dropped[1] - start
        rows = sampled.rows(samples) - start
        first = int(rows[0])
        padding = sampled.decimation.padding if every > 1 else 0
        skipped = max(0, -((every - padding - first) // every))
        begin = first - every * skipped
        last = kept - 1 + padding
        blocks = 1 - (begin - last) // every
        beyond = begin + every * (blocks - 1) - last
        poles, residues, gains, direct = _modes(sampled) if every > 1 else _ALL_PASS
        powers = poles ** np.arange(every + 1)[:, None]
        return Decimation(
            sizes=np.array(
                [
                    start,
                    kept,
                    low,
                    high,
                    padding,
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

    def filtered(self, position: Array) -> Motion:
        """Motions as measured ones are filtered, (N, L) each."""
        q, dq, ddq = np.empty((3, *position.shape))
        sampled = self.template.sampling.filter
        self.library.motion(
            position,
            sampled.low_pass.sections,
            sampled.low_pass.settled,
            sampled.low_pass.padding,
            self.lanes.period,
            (q, dq, ddq),
        )
        return q, dq, ddq

    def rows(self, excluded: BoolArray | None, rows: BoolArray | None) -> Equations:
        """Rows of the records, (n, L) and (n, p, L); zero where a lane has none."""
        found = self.library.measured(
            self.lanes.control, self.motion, self.template.hold_delay, excluded, self.decimation
        )
        found, p = _kept(found, rows), len(self.axis.parameters)
        intercept = found[:, p] if found.shape[1] > p + 1 else np.zeros(1)
        return Equations(left=found[:, -1], intercept=intercept, regressor=found[:, :p])

    def rows_of(self, excluded: BoolArray | None) -> BoolArray | None:
        """Which rows lanes have, (n, L), without excluded samples; None for all."""
        if excluded is None:
            return None
        weights = self.library.weights(excluded, self.decimation)
        return np.asarray((weights > MIN_ROW_WEIGHT.value) | ~excluded.any(axis=0))

    def turns(self, motion: Motion) -> BoolArray:
        """Samples near reversals and rests of filtered motions, (N, L)."""
        reach = self.template.sampling.filter.turn_reach
        return self.library.turns(motion[1], REST_SPEED.value, reach)

    @cached_property
    def starts(self) -> tuple[LoopStart, BoolArray]:
        """Starts of the loops, and of which lanes they are as `loop_starts` has them.

        Lanes begin with what the law declares for an axis at rest; those whose first controls say
        otherwise are the others.
        """
        axis, lanes, law = self.axis, self.lanes, self.axis.control
        velocity = np.array([first_velocity(lane, lanes.period) for lane in lanes.position.T])
        start = LoopStart(position=lanes.position[0].copy(), velocity=velocity, memory=None)
        if law is None or not law_memory(axis):
            return start, np.ones(len(lanes), dtype=bool)
        if law.balanced or law.takes_velocity:
            found = [loop_starts(axis, lanes.record(lane))[0].memory for lane in range(len(lanes))]
            return start, np.array([memory is None for memory in found])
        first = lanes.control[:START_SAMPLES]
        off = first - _at_rest(axis, lanes.reference, lanes.position, len(first))
        power = np.mean(lanes.control**2, axis=0)
        return start, np.asarray(~at_rest_misses(off, below_limit(axis, first), power))

    def loops(
        self, physical: Array, chosen: BoolArray, excluded: BoolArray | None, rows: BoolArray | None
    ) -> "LaneLoops":
        """Chosen lanes simulated with parameters (L, p), as rows without what is excluded."""
        lanes = np.flatnonzero(chosen)
        physical, start = physical[lanes], self.starts[0]
        inputs = LoopInputs(
            reference=self.lanes.reference,
            period=self.lanes.period,
            start=LoopStart(position=start.position[lanes], velocity=start.velocity[lanes]),
        )
        made = simulate_lanes(self.axis, physical, inputs, wanted=SIGNALS, threads=1)
        well = chosen.copy()
        well[lanes[[*made.failures]]] = False
        names = ("position", "velocity", "acceleration", "force", "direction")
        held = self.template.prefilter.hold == "zoh"
        found = self.library.simulated(
            tuple(made.signals[name] for name in names),
            made.signals["direction_before"] if held else None,
            physical,
            some_lanes(excluded, lanes),
            self.decimation,
        )
        found, p = _kept(found, some_lanes(rows, lanes)), len(self.axis.parameters)
        return LaneLoops(
            lanes=lanes,
            position=made.signals["position"],
            Z=found[:, :p],
            intercept=found[:, p] if found.shape[1] > p else 0.0,
            well=well,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class LaneLoops:
    """Loops of some of the lanes L, one estimate each.

    Attributes
    ----------
    lanes : (l,) array of int
        Which ones.
    position : (N, l) array
        Simulated.
    Z : (n, p, l) array
        Reduced.
    intercept : (n, l) array or float
        Known part of the rows, reduced.
    well : (L,) array of bool
        Which loops there are and went well.
    """

    lanes: IntArray
    position: Array
    Z: Array
    intercept: Array | float
    well: BoolArray


def some_lanes(values: BoolArray | None, lanes: IntArray) -> BoolArray | None:
    """Some lanes, by number, of values (..., L) that there may be, in contiguous memory."""
    return None if values is None else np.ascontiguousarray(values[..., lanes])


def _kept(found: Array, rows: BoolArray | None) -> Array:
    if rows is not None:
        found *= rows[:, None, :]
    return found
