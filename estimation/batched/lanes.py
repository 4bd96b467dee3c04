"""Lanes: records of one reference that are filtered, simulated and solved in parallel.

The decimation filter is computed as a sum of first-order modes, so that only the rows that remain
after decimation are computed. The response of the filter, applied forward and backward, is a sum
over its poles: a mode for each pole runs once forward and once backward. A remaining row then needs
a few products with the samples since the last remaining row, whereas second-order sections would
compute every sample. The modes start and end as the sections do: the forward pass starts in the
steady state of the first value, and the backward pass in the steady state of the last value of the
forward pass.
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

#: Ways in which a lane was identified: batched, separately by `identify`, or not at all.
SIDE_BY_SIDE, ALONE, FAILED = "side by side", "alone", "failed"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecordLanes(Exact):
    """Records of one reference, one for each lane, SI.

    Attributes
    ----------
    reference : (N,) array
        Reference of all lanes.
    position, control : (N, B) array
        Measured positions and controls, in contiguous memory.
    period : float
        Period of the control law, s.
    resolution : float
        Encoder step; lanes with an encoder step are identified separately.

    Raises
    ------
    UsageError
        The shapes do not match.
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
                f"the reference has the shape {np.shape(self.reference)}, the positions {shape} "
                f"and the controls {np.shape(self.control)}. Give the shapes (N,), (N, B) and "
                "(N, B).",
                code="simulation-input",
            )

    def __len__(self) -> int:
        return int(self.position.shape[1])

    def record(self, lane: int) -> Record:
        """Return the record of one lane, given by its index."""
        return Record(
            time=self.period * np.arange(float(len(self.reference))),
            position=self.position[:, lane],
            reference=self.reference,
            control=self.control[:, lane],
            sample_period=self.period,
        )

    def part(self, lanes: slice) -> "RecordLanes":
        """Return the lanes of a slice, in contiguous memory."""
        return RecordLanes(
            reference=self.reference,
            position=np.ascontiguousarray(self.position[:, lanes]),
            control=np.ascontiguousarray(self.control[:, lanes]),
            period=self.period,
            resolution=self.resolution,
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LaneEstimates(Exact):
    """Estimates of lanes by one method; NaN for lanes without an estimate.

    Attributes
    ----------
    values : (B, p) array
        Physical parameters, SI.
    deviations : mapping of str to (B, p) array
        Standard errors by name of `COVARIANCES`.
    freedom : mapping of str to (B, p) array
        Degrees of freedom of the standard errors, by name of `COVARIANCES`.
    iterations : (B,) array of int
        Number of iterations.
    how : tuple of str
        For each lane ``side by side``, ``alone`` or ``failed``.
    errors : mapping of int to str
        Error message of each failed lane.
    """

    values: Array
    deviations: Mapping[str, Array]
    freedom: Mapping[str, Array]
    iterations: IntArray
    how: tuple[str, ...]
    errors: Mapping[int, str]


def _at_rest(axis: GeneratedAxis, reference: Array, position: Array, samples: int) -> Array:
    """Return the first controls that the law computes if the axis was at rest before, (samples, L).

    Parameters
    ----------
    axis : GeneratedAxis
    reference : (N,) array
        Reference of all lanes.
    position : (N, L) array
        Measured positions.
    samples : int
        Number of controls.
    """
    lanes = position.shape[1]
    commanded = np.broadcast_to(reference[:samples, None], (samples, lanes)).copy()
    (state,) = axis.evaluate("control_start", commanded[0], position[0])
    made = np.empty((samples, lanes))
    for k in range(samples):
        read = (commanded[k], position[k], np.zeros(lanes))
        control, state = axis.evaluate("control_law", *read, state)
        made[k] = control[:, 0]
    return made


#: First-order modes of a filter: one pole of each conjugate pair, its residue, its gain forward and
#: backward, (s,) each, and the gain of the part without memory.
_Filter = tuple[ComplexArray, ComplexArray, ComplexArray, float]


#: No filter: four modes without memory, each with a quarter of the value.
_ALL_PASS: _Filter = (np.zeros(4, complex), *(np.full(4, 1 / 8, complex),) * 2, 0.0)


def _modes(sampled: SampledFilter) -> _Filter:
    """Return the first-order modes of the decimation filter, by partial fractions.

    See `_Filter`. The poles of the second-order sections are conjugate pairs.
    """
    sections = sampled.decimation.sections
    pairs = np.array([np.roots(section[3:]) for section in sections])
    poles: ComplexArray = np.where(pairs[:, 0].imag > 0, pairs[:, 0], pairs[:, 1])
    every = np.concatenate([poles, poles.conj()])

    def numerator(delays: ComplexArray) -> ComplexArray:
        """Return the numerator of the filter's transfer function at values of ``1/z``."""
        powers = delays[:, None, None] ** np.arange(3)
        return np.asarray(np.prod((powers * sections[:, :3]).sum(axis=-1), axis=-1))

    others = [np.prod(1 - every[every != pole] / pole) for pole in poles]
    residues = numerator(np.asarray(1 / poles, dtype=complex)) / np.array(others)
    behind = numerator(poles) / np.prod(1 - poles[:, None] * every, axis=1)
    first = float(np.prod(sections[:, 0]))
    last = float(np.prod(sections[:, 2] / sections[:, 5]))
    return poles, residues, residues * behind, first * last


def _ends(poles: ComplexArray, residues: ComplexArray, gains: ComplexArray, beyond: int) -> Array:
    """Return the matrix from forward modes to the initial state of backward modes, (2 s, 2 s).

    The forward modes are relative to their steady state. Forward and backward modes are those at
    `beyond` samples after the last value, which is repeated up to there. Rows and columns of the
    matrix alternate real and imaginary parts.

    Parameters
    ----------
    poles, residues, gains : (s,) array
        As from `_modes`.
    beyond : int
        Number of samples after the last value.
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
    """Return complex values, (..., s), as alternating real and imaginary parts, (..., 2 s)."""
    parts = np.stack([values.real, values.imag], axis=-1)
    return parts.reshape(*values.shape[:-1], -1)


@dataclass(frozen=True, kw_only=True)
class LaneBlock:
    """Lanes that are identified together.

    Attributes
    ----------
    axis : GeneratedAxis
    library : LaneLibrary
        Compiled code for the rows.
    lanes : RecordLanes
    template : FilteredRecord
        The first lane with all its samples, for everything that is equal in all lanes.
    """

    axis: GeneratedAxis
    library: LaneLibrary
    lanes: RecordLanes
    template: FilteredRecord

    @cached_property
    def motion(self) -> Motion:
        """Filtered measured position, velocity and acceleration, (N, L) each."""
        return self.filtered(self.lanes.position)

    @cached_property
    def decimation(self) -> Decimation:
        """Kept rows and coefficients of the modes of the decimation filter."""
        # Samples that the filter reads; indices below are relative to the first of them.
        sampled, samples = self.template.sampling.filter, len(self.lanes.reference)
        every = sampled.settings.decimate
        start, end = sampled.cut
        kept = samples - start - end
        low, high = sampled.dropped[0] - start, samples - sampled.dropped[1] - start
        rows = sampled.rows(samples) - start
        first = int(rows[0])
        # Blocks of `every` samples end at `begin`, `begin + every` and so on; a row is the end of a
        # block. The first block has the first sample of the padding, and the first row is the end
        # of block `skipped`. The last block ends `beyond` samples after the padding.
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
            gains=_pairs(2 * gains.conj()),  # for the real part of a product
            settled=_pairs(1 / (1 - poles)),
            ends=_ends(poles, residues, gains, beyond),
            direct=direct,
        )

    def filtered(self, position: Array) -> Motion:
        """Return filtered position, velocity and acceleration for positions, (N, L) each.

        The filter is that of the measured motion.
        """
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
        """Return the rows of the records: left side (n, L) and regressor (n, p, L).

        Rows that a lane lacks are 0.

        Parameters
        ----------
        excluded : (N, L) array of bool or None
            True for samples without weight; None if all samples have weight.
        rows : (n, L) array of bool or None
            True for rows that a lane has; None if each lane has all rows.
        """
        found = self.library.measured(
            self.lanes.control, self.motion, self.template.hold_delay, excluded, self.decimation
        )
        found, p = _kept(found, rows), len(self.axis.parameters)
        intercept = found[:, p] if found.shape[1] > p + 1 else np.zeros(1)
        return Equations(left=found[:, -1], intercept=intercept, regressor=found[:, :p])

    def rows_of(self, excluded: BoolArray | None) -> BoolArray | None:
        """Return True for the rows that each lane has, (n, L).

        A lane lacks rows whose weight is small because of excluded samples, (N, L). None if
        `excluded` is None, so that each lane has all rows.
        """
        if excluded is None:
            return None
        weights = self.library.weights(excluded, self.decimation)
        return np.asarray((weights > MIN_ROW_WEIGHT.value) | ~excluded.any(axis=0))

    def turns(self, motion: Motion) -> BoolArray:
        """Return True for samples near reversals and rests of filtered motions, (N, L)."""
        reach = self.template.sampling.filter.turn_reach
        return self.library.turns(motion[1], REST_SPEED.value, reach)

    @cached_property
    def starts(self) -> tuple[LoopStart, BoolArray]:
        """Initial states of the loops, and True for lanes where they agree with `loop_starts`.

        The memory of the law is None, for the declared memory of an axis at rest. This is wrong for
        lanes whose first controls show another memory.
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
        """Return the simulated loops of chosen lanes and their rows.

        Parameters
        ----------
        physical : (L, p) array
            Parameters of all lanes.
        chosen : (L,) array of bool
            True for lanes to simulate.
        excluded, rows : array of bool or None
            As in `rows`.
        """
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
    """Simulated loops of some of the lanes L.

    Attributes
    ----------
    lanes : (l,) array of int
        Numbers of the simulated lanes.
    position : (N, l) array
        Simulated positions.
    Z : (n, p, l) array
        Columns of the simulated rows.
    intercept : (n, l) array or float
        Known part of the simulated rows.
    well : (L,) array of bool
        True for lanes that were simulated without failure.
    """

    lanes: IntArray
    position: Array
    Z: Array
    intercept: Array | float
    well: BoolArray


def some_lanes(values: BoolArray | None, lanes: IntArray) -> BoolArray | None:
    """Return the values (..., L) of some lanes, given by index, (..., l); None for None.

    They are in contiguous memory.
    """
    if values is None:
        return None
    return np.ascontiguousarray(values[..., lanes])


def _kept(found: Array, rows: BoolArray | None) -> Array:
    """Return rows, (n, c, L), in which rows that a lane lacks are set to 0 in place.

    `rows`, (n, L), is True for rows that a lane has; None for all.
    """
    if rows is not None:
        found *= rows[:, None, :]
    return found
