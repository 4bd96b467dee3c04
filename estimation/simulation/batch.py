"""Many closed loops side by side, across processors."""

from __future__ import annotations  # as they are written, in what help() prints

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from axisid.codegen.artefacts import GeneratedAxis, as_generated
from axisid.codegen.lowering import BLOCK, SIGNALS, LoopSettings
from axisid.codegen.native import Native
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array, Exact
from axisid.support.errors import AxisidError, real_array

from .closed_loop import SettledLoop, settled_loop
from .inputs import LoopInputs, allowed_distance, checked_signals, lines
from .lane_arguments import (
    LaneBlock,
    Reducer,
    aligned,
    axes_by_gains,
    check_lanes,
    check_reducer,
    check_threads,
    check_wanted,
    gains_by_lane,
    in_order,
    joined,
    optional_array,
    reduced,
)
from .simulated import checked_starts, lane_starts
from .steps import (
    MOST_SUBSTEPS,
    at_rest,
    check_loop,
    has_constant_substeps,
    most_substeps,
    states_refusal,
    steps_by_rate,
    substeps_along,
    substeps_at_start,
    visited_signals,
)
from .two_clocks import at_log_samples, clocks_of

#: What is needed between the evaluations of a law.
_OF_THE_LAW = tuple(name for name in SIGNALS if name != "control")
_KEPT = 2**23  # values of signals that lie in memory while a batch is reduced


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BatchSimulation(Exact):
    """Many simulations side by side.

    Attributes
    ----------
    signals : dict of str to (N, B) array
        The signals that were asked for, by name as in `Simulation`; NaN from the sample on at which
        a simulation ended early. None where they were reduced.
    failures : dict of int to str
        Why and where, by lane, for those that ended early.
    reduced : dict of str to (B, ...) array
        What was kept in place of the signals, by name.
    """

    signals: dict[str, Array]
    failures: dict[int, str]
    reduced: dict[str, Array] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Array:
        return self.reduced[name] if name in self.reduced else self.signals[name]


def simulate_batch(
    axis: Axis | GeneratedAxis,
    parameters: ArrayLike | Mapping[str, ArrayLike],
    reference: ArrayLike,
    period: float,
    *,
    start: ArrayLike | None = None,
    start_velocity: ArrayLike | None = None,
    memory: ArrayLike | None = None,
    position_noise: ArrayLike | None = None,
    injected: ArrayLike | None = None,
    signals: Mapping[str, ArrayLike] | None = None,
    gains: Mapping[str, ArrayLike] | None = None,
    resolution: float = 0.0,
    substeps: int | None = None,
    wanted: Sequence[str] = SIGNALS[:5],
    reduce: Reducer | None = None,
    threads: int | None = None,
) -> BatchSimulation:
    """Simulate many parameter sets, references or noises side by side.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
        With a control law.
    parameters : (B, p) array_like or mapping of str to (B,) array_like
        One row a lane.
    reference : (N,) or (N, B) array_like
        Shared, or one column a lane.
    period : float
        Sampling period of the reference, s; where it is not the law's, as in `simulate`.
    start : (B,) array_like, optional
        First positions; the first references by default.
    start_velocity : (B,) array_like, optional
        First velocities; 0 by default.
    memory : (B, m) array_like, optional
        What each drive remembers, as in `simulate`.
    position_noise : (N, B) array_like, optional
    injected : (N,) or (N, B) array_like, optional
        Added to the control; shared, or one column a lane.
    signals : mapping of str to (N,) or (N, B) array_like, optional
        The recorded signals that the axis declares, as in `simulate`; shared, or one column a lane.
    gains : mapping of str to float or (B,) array_like, optional
        Gains of a sampled law by name, SI, shared or one a lane; others are as declared. Nothing
        is compiled for them.
    resolution, substeps
        As in `simulate`.
    wanted : sequence of str
        Signals of the simulation that are given back, each N x B floats, or reduced. Names as in
        `Simulation`.
    reduce : callable, optional
        What is kept of each lane in place of its signals, so that memory does not grow by N x B:
        lanes are simulated and reduced block by block. It takes a `LaneBlock` and gives arrays by
        name, (b, ...), a row for each of its lanes. NaN for a lane that failed.
    threads : int, optional
        1 to 1024; as many as there are processors by default.

    Raises
    ------
    ModelError
        The axis has no control law, or none whose gains could change.
    UsageError
        An argument has the wrong shape or value.

    Notes
    -----
    A lane that fails does not end the others; see `BatchSimulation.failures`.

    The substeps are those of `simulate`, settled once before any lane runs where no motion asks for
    more of them than the start does. Where damping, stiffness or waves vary along the way each lane
    has its own, by where its own motion goes: with the most of any lane for all of them, what a
    lane gives would depend on its company.
    """
    axis = as_generated(axis)
    given = in_order(axis, parameters)
    theta = np.ascontiguousarray(real_array(given, "the parameters"))
    ref = aligned(reference, "the reference")
    check_loop(axis, theta.shape[1:], ref, period, resolution, substeps)
    check_lanes(theta, ref)
    check_threads(threads)
    check_wanted(wanted)
    samples, lanes = len(ref), len(theta)
    begin = np.broadcast_to(ref[0], lanes) if start is None else start
    inputs = LoopInputs(
        reference=ref,
        period=period,
        start=checked_starts(axis, begin, start_velocity, memory, lanes),
        noise=optional_array(position_noise, "the noise", (samples, lanes)),
        injected=optional_array(injected, "the injected signal", (samples,), (samples, lanes)),
        signals=checked_signals(axis, signals, samples, lanes),
        resolution=resolution,
    ).at_law(axis, clocks_of(axis.axis.control, samples, period))
    run = partial(simulate_lanes, axis, substeps=substeps, threads=threads)
    own = gains_by_lane(axis, gains, lanes)
    if reduce is None:
        return run(theta, inputs, wanted=wanted, gains=own)
    check_reducer(reduce, wanted)
    failures: dict[int, str] = {}
    blocks = []
    for chosen in _blocks(lanes, samples * len(wanted), _count(threads)):
        some = inputs.lanes(chosen)
        of_lanes = None if own is None else own[chosen]
        batch = run(theta[chosen], some, wanted=wanted, gains=of_lanes)
        failures |= {chosen.start + lane: why for lane, why in batch.failures.items()}
        block = LaneBlock(
            first=chosen.start,
            parameters=theta[chosen],
            reference=some.logged.reference,
            period=period,
            signals=batch.signals,
        )
        blocks.append(reduced(reduce, block))
    return BatchSimulation(signals={}, failures=failures, reduced=joined(blocks))


def _blocks(lanes: int, values: int, threads: int) -> Iterator[slice]:
    """Lanes in parts whose signals, so many values of each lane, lie in memory together."""
    size = BLOCK * max(_KEPT // (BLOCK * values), threads)
    for first in range(0, lanes, size):
        yield slice(first, min(first + size, lanes))


def simulate_lanes(
    axis: GeneratedAxis,
    parameters: Array,
    inputs: LoopInputs,
    *,
    substeps: int | None = None,
    wanted: Sequence[str],
    gains: Array | None = None,
    threads: int | None = None,
) -> BatchSimulation:
    """Loops with parameters (B, p), the signals that are wanted at the samples of the log.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (B, p) array
    inputs : LoopInputs
        At the law's evaluations.
    substeps : int, optional
        As in `simulate`.
    wanted : sequence of str
    gains : (B, g) array, optional
        Of the law, by lane; as declared by default.
    threads : int, optional
        As in `simulate_batch`.
    """
    fixed = has_constant_substeps(axis) or substeps is not None
    looked_at = () if fixed else visited_signals(axis)
    between = () if inputs.clocks is None else _OF_THE_LAW
    start = lane_starts(axis, parameters, inputs, gains)
    away = np.abs(start.position - inputs.reference[0])
    spans = np.broadcast_to(np.ptp(inputs.reference, axis=0), len(parameters))
    batch = _Batch(
        axis=axis,
        parameters=np.ascontiguousarray(parameters),
        inputs=replace(inputs, start=start, log=None),
        recorded=lines(axis, inputs.signals, inputs.period),
        allowed=np.array([allowed_distance(*each) for each in zip(spans, away, strict=True)]),
        wanted=list(dict.fromkeys([*wanted, *looked_at, *between])),
        threads=_count(threads),
        gains=gains,
    )
    out, failures = batch.run(substeps)
    return BatchSimulation(
        signals={name: out[name] for name in wanted},
        failures=dict(sorted(failures.items())),
    )


def _count(threads: int | None) -> int:
    """So many threads, or as many as there are processors."""
    if threads is not None:
        return int(threads)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def settled_substeps(axis: GeneratedAxis, parameters: Array, inputs: LoopInputs) -> int | None:
    """Steps in a sample that parameters (p,) ask for, so that others near them take as many.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (p,) array
    inputs : LoopInputs

    Returns
    -------
    int or None
        None where the loop cannot be simulated with them.
    """
    own = inputs.lanes(0) if np.ndim(inputs.start.position) else inputs
    most = most_substeps(len(own.reference))
    if has_constant_substeps(axis):
        position = np.array([own.start.position])
        given = parameters[None, :], position, own.period, own.first_signals
        return min(int(substeps_at_start(axis, *given)[0]), most)
    try:
        loop = settled_loop(axis, parameters, own, bounded=True)
    except AxisidError:
        return None
    return None if loop.failure else min(loop.substeps, most)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Batch:
    """What the groups of lanes of a batch share."""

    axis: GeneratedAxis
    parameters: Array
    inputs: LoopInputs
    recorded: Array | None
    allowed: Array
    wanted: Sequence[str]
    threads: int
    gains: Array | None

    def run(self, substeps: int | None) -> tuple[dict[str, Array], dict[int, str]]:
        """Simulate every lane; its signals at the samples of the log, (N, B) each, and failures.

        What no lane beside others can be told of is done alone: a start that is refused, a range
        that is too narrow, steps that are too many, and all of them where nothing is compiled.
        """
        axis, lanes = self.axis, range(len(self.parameters))
        most = MOST_SUBSTEPS if substeps else most_substeps(len(self.inputs.reference))
        fixed = substeps is not None or has_constant_substeps(axis)
        well, counts = self._first_steps()
        if substeps is not None:
            counts = np.full(len(lanes), substeps)
        well &= (counts <= most) | (not fixed)
        counts, out = np.minimum(counts, most), dict[str, Array]()
        pending = np.flatnonzero(well)
        while pending.size:
            # Lanes that ask for more steps in a sample run apart, and do not slow the others.
            for count in np.unique(counts[pending]):
                group = pending[counts[pending] == count]
                well[group] = self._run_into(out, group, int(count))
            pending = pending[well[pending] & (not fixed)]
            needed = np.array([self._needed(out, int(lane)) for lane in pending], dtype=np.int64)
            more = needed > counts[pending]
            well[pending[more & (counts[pending] >= most)]] = False
            counts[pending] = np.maximum(counts[pending], np.minimum(needed, most))
            pending = pending[more & well[pending]]
        out = out or self._nothing()
        failures: dict[int, str] = {}
        for lane in map(int, np.flatnonzero(~well)):
            loop = self._alone(lane, substeps)
            counts[lane], failures[lane] = loop.substeps, loop.failure
            for name, values in out.items():
                values[:, lane] = loop.signals.get(name, np.nan)
        clocks = self.inputs.clocks
        if clocks is not None:
            sampled = [
                at_log_samples(
                    axis,
                    self.parameters[lane],
                    {name: np.ascontiguousarray(values[:, lane]) for name, values in out.items()},
                    clocks,
                    _lines_of(self.recorded, lane),
                    int(counts[lane]),
                )
                for lane in lanes
            ]
            out = {name: np.column_stack([lane[name] for lane in sampled]) for name in out}
        return out, {lane: why for lane, why in failures.items() if why}

    def _first_steps(self) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
        """Which lanes can start beside others, and the steps of each at first."""
        axis, start = self.axis, self.inputs.start.position
        has_mass, held, rates = at_rest(axis, self.parameters, start, self.inputs.first_signals)
        low, high = np.array([(p.lower, p.upper) for p in axis.axis.parameters]).T
        inside = ((low <= self.parameters) & (self.parameters <= high)).all(axis=1)
        remembers = [not states_refusal(axis, own) for own in self.parameters]
        well = inside & has_mass & held & remembers
        return well, steps_by_rate(axis, np.where(well, rates, 0.0), self.inputs.period)

    def _needed(self, out: Mapping[str, Array], lane: int) -> int:
        """Steps in a sample that a lane asks for, wherever it went."""
        own, names = self.inputs.lanes(lane), visited_signals(self.axis)
        visited = {name: np.ascontiguousarray(out[name][:, lane]) for name in names}
        return substeps_along(self.axis, self.parameters[lane], visited, own.period, own.signals)

    def _alone(self, lane: int, substeps: int | None) -> SettledLoop:
        """A lane as it is simulated by itself; without signals where it is refused."""
        own = None if self.gains is None else self.gains[lane : lane + 1]
        (axis,) = axes_by_gains(self.axis, own, 1)
        theta, inputs = self.parameters[lane], self.inputs.lanes(lane)
        try:
            return settled_loop(axis, theta, inputs, substeps=substeps, bounded=True)
        except AxisidError as error:
            return SettledLoop(signals={}, substeps=1, failure=str(error))

    def _nothing(self) -> dict[str, Array]:
        shape = len(self.inputs.reference), len(self.parameters)
        return {name: np.full(shape, np.nan) for name in self.wanted}

    @property
    def _native(self) -> Native:
        """What the loop is compiled from."""
        code = self.axis.loop if self.gains is not None and self.axis.loop else self.axis
        return code.native

    def _run_into(
        self, out: dict[str, Array], group: NDArray[np.intp], substeps: int
    ) -> NDArray[np.bool_]:
        """Simulate a group of lanes into the signals of all; which of them came to the end."""
        library, every = self._native.library(), len(group) == len(self.parameters)
        if library is None:
            return np.zeros(len(group), dtype=bool)
        inputs = self.inputs if every else self.inputs.lanes(group)
        recorded = self.recorded if every else _lines_of(self.recorded, group)
        settings = LoopSettings(
            period=inputs.period,
            resolution=inputs.resolution,
            allowed=np.ascontiguousarray(self.allowed[group]),
            substeps=substeps,
        )
        theta = self.parameters[group]
        status, _, made = library.simulate_batch(
            inputs.reference,
            inputs.noise,
            inputs.injected,
            theta if self.gains is None else np.hstack([theta, self.gains[group]]),
            inputs.start,
            settings,
            self.wanted,
            self.threads,
            recorded,
        )
        if every:
            out.update(made)
        else:
            out.update({} if out else self._nothing())
            for name, values in made.items():
                out[name][:, group] = values
        return np.asarray(status == 0)


def _lines_of(recorded: Array | None, lanes: NDArray[np.intp] | int) -> Array | None:
    """Recorded signals of some lanes, or of one; what all share as it is."""
    return recorded if recorded is None or recorded.ndim == 2 else recorded[:, :, lanes]
