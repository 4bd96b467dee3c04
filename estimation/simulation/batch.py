"""Many closed loops side by side, across processors."""

from __future__ import annotations  # as they are written, in what help() prints

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from axisid.codegen.artefacts import GeneratedAxis, as_generated
from axisid.codegen.lowering import BLOCK, SIGNALS, STATUSES, STEPS_IN_ALL, LoopSettings
from axisid.codegen.runtime import VirtualLoop
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array, Exact
from axisid.support.errors import EstimationError
from axisid.support.real_numbers import real_array

from .between import at_log_samples
from .inputs import LoopInputs
from .lane_arguments import (
    aligned,
    check_lanes,
    check_threads,
    check_wanted,
    gains_by_lane,
    in_order,
    lane_injected,
    lane_noise,
)
from .loop_start import checked_starts, lane_starts
from .recorded import checked_signals, lines
from .reducers import LaneBlock, Reducer, check_reducer, joined, reduced
from .runaway import allowed_distance, widened_distance
from .steps import (
    MOST_SUBSTEPS,
    at_rest,
    bounds_refusal,
    check_loop,
    failure,
    further_substeps,
    has_constant_substeps,
    has_states,
    most_substeps,
    no_inertia,
    place_at,
    pushes,
    states_refusal,
    steps_by_rate,
    substeps_along,
    substeps_at_start,
    too_stiff,
    visited_signals,
)
from .two_clocks import clocks_of

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
        noise=lane_noise(position_noise, (samples, lanes)),
        injected=lane_injected(injected, (samples, lanes)),
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
    first, theta = inputs.first_signals, parameters[None, :]
    position = np.ravel(inputs.start.position)[:1]
    (steps,) = substeps_at_start(axis, theta, position, inputs.period, first)
    if not has_constant_substeps(axis):
        alone = replace(inputs, clocks=None)
        batch = simulate_lanes(axis, theta, alone, wanted=visited_signals(axis))
        if batch.failures:
            return None
        visited = {name: values[:, 0] for name, values in batch.signals.items()}
        along = substeps_along(axis, parameters, visited, inputs.period, inputs.signals)
        steps = max(int(steps), along)
    return min(int(steps), most_substeps(len(inputs.reference)))


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
        """Simulate every lane; its signals at the samples of the log, (N, B) each, and failures."""
        axis, samples = self.axis, len(self.inputs.reference)
        failures, steps = self._refused()
        sound = np.array([lane not in failures for lane in range(len(self.parameters))])
        counts = np.where(sound, steps, 1) if substeps is None else np.full(len(sound), substeps)
        out: dict[str, Array] = {}
        most = MOST_SUBSTEPS if substeps else most_substeps(samples)
        fixed = substeps is not None or has_constant_substeps(axis)
        for lane in map(int, np.flatnonzero(sound & (counts > most)) if fixed else ()):
            own, still = self.inputs.lanes(lane), (float(self.inputs.start.position[lane]), 0.0)
            at = still, tuple(map(float, own.first_signals))
            failures[lane] = too_stiff(axis, self.parameters[lane], at, own.period, samples)
            sound[lane] = False
        counts = np.minimum(counts, most)
        pending = np.flatnonzero(sound)
        while pending.size:
            # Lanes that ask for more steps in a sample run apart, and do not slow the others.
            groups = [pending[counts[pending] == count] for count in np.unique(counts[pending])]
            for group in groups:
                self._run_into(out, group, int(counts[group[0]]), failures)
            if fixed:
                break
            enough = [self._enough(out, int(lane), int(counts[lane]), failures) for lane in pending]
            more = np.array(enough) > counts[pending]
            counts[pending] = enough
            pending = pending[more]
        out = out or self._nothing()
        clocks = self.inputs.clocks
        if clocks is None:
            return out, failures
        sampled = [
            at_log_samples(
                axis,
                self.parameters[lane],
                {name: np.ascontiguousarray(values[:, lane]) for name, values in out.items()},
                clocks,
                _lines_of(self.recorded, lane),
                int(counts[lane]),
            )
            for lane in range(len(sound))
        ]
        return {name: np.column_stack([lane[name] for lane in sampled]) for name in out}, failures

    def _refused(self) -> tuple[dict[int, str], NDArray[np.int64]]:
        """What to say of lanes that no simulation starts from, and the steps of each at first."""
        axis, start, refused = self.axis, self.inputs.start.position, dict[int, str]()
        first, period = self.inputs.first_signals, self.inputs.period
        has_mass, held, rates = at_rest(axis, self.parameters, start, first)
        low, high = np.array([(p.lower, p.upper) for p in axis.axis.parameters]).T
        inside = ((low <= self.parameters) & (self.parameters <= high)).all(axis=1)
        remembers = has_states(axis, self.parameters)
        for lane in map(int, np.flatnonzero(~(inside & has_mass & held & remembers))):
            theta = self.parameters[lane]
            if not remembers[lane]:
                refused[lane] = states_refusal(axis, theta)
            elif not has_mass[lane]:
                own = [*map(float, self.inputs.lanes(lane).first_signals)]
                refused[lane] = no_inertia(axis, theta, float(start[lane]), own)
            else:
                refused[lane] = bounds_refusal(axis, theta) or pushes(axis, theta)
        return refused, steps_by_rate(axis, rates, period)

    def _enough(
        self, out: dict[str, Array], lane: int, count: int, failures: dict[int, str]
    ) -> int:
        """Steps that were enough, or that are, for wherever a lane went; as many if none are."""
        own, position = self.inputs.lanes(lane), out["position"][:, lane]
        ended = np.isnan(position)
        until = int(ended.argmax()) if ended.any() else len(position)
        names = visited_signals(self.axis)
        visited = {name: np.ascontiguousarray(out[name][:until, lane]) for name in names}
        theta, samples = self.parameters[lane], len(position)
        had = count, visited, own.period, own.signals
        try:
            return further_substeps(self.axis, theta, *had, samples, STEPS_IN_ALL)
        except EstimationError as error:
            failures[lane] = str(error)
            for values in out.values():
                values[:, lane] = np.nan
            return count

    def _nothing(self) -> dict[str, Array]:
        shape = (len(self.inputs.reference), len(self.parameters))
        return {name: np.full(shape, np.nan) for name in self.wanted}

    def _run_into(
        self,
        out: dict[str, Array],
        group: NDArray[np.intp],
        substeps: int,
        failures: dict[int, str],
    ) -> None:
        """Simulate a group of lanes into the signals of all."""
        for lane in group:
            failures.pop(int(lane), None)
        if not out and len(group) == len(self.parameters):
            out.update(self._lanes(None, substeps, failures))
            return
        if not out:
            out.update(self._nothing())
        for name, values in self._lanes(group, substeps, failures).items():
            out[name][:, group] = values

    def _lanes(
        self, group: NDArray[np.intp] | None, substeps: int, failures: dict[int, str]
    ) -> dict[str, Array]:
        """Simulate a group of lanes, or all; what fails is added to `failures`."""
        chosen = np.arange(len(self.parameters)) if group is None else group
        inputs = self.inputs if group is None else self.inputs.lanes(group)
        settings = LoopSettings(
            period=inputs.period,
            resolution=inputs.resolution,
            allowed=np.ascontiguousarray(self.allowed[chosen]),
            substeps=substeps,
        )
        theta, start = self.parameters[chosen], inputs.start
        theta = theta if self.gains is None else np.hstack([theta, self.gains[chosen]])
        recorded = self.recorded if group is None else _lines_of(self.recorded, chosen)
        code = self.axis.loop if self.gains is not None and self.axis.loop else self.axis
        library = code.native.library()
        if library is None:
            code.native.warn_once()
            run = code.functions, theta, settings, inputs, self.wanted, recorded
            status, stopped, out = _virtual_batch(*run)
        else:
            status, stopped, out = library.simulate_batch(
                *(inputs.reference, inputs.noise, inputs.injected, theta, start, settings),
                *(self.wanted, self.threads, recorded),
            )
        again = self._widened(status, chosen)
        for i in np.flatnonzero(status):
            lane, sample = int(chosen[i]), int(stopped[i])
            if not again[i]:
                own, known = inputs.lanes(int(i)).signals, {"position", "velocity"} <= out.keys()
                at = place_at({n: v[:, i] for n, v in out.items()}, sample, own) if known else None
                why = (self.axis, self.parameters[lane], int(status[i]), sample, inputs.period, at)
                failures[lane] = failure(*why)
            for signal in out.values():
                signal[sample:, i] = np.nan
        if again.any():
            for name, values in self._lanes(chosen[again], substeps, failures).items():
                out[name][:, again] = values
        return out

    def _widened(self, status: NDArray[np.int32], chosen: NDArray[np.intp]) -> NDArray[np.bool_]:
        """Which lanes left a range that was too narrow for their load; it is widened for them."""
        again = np.asarray(status == STATUSES.index("out of range"))
        if again.any():
            lanes = chosen[again]
            some = self.inputs.lanes(lanes)
            wider = widened_distance(
                self.axis,
                self.parameters[lanes],
                some.start.position,
                some.noise,
                some.injected,
                some.resolution,
                some.first_signals,
            )
            again[again] = wider > self.allowed[lanes]
            self.allowed[lanes] = np.maximum(self.allowed[lanes], wider)
        return again


def _lines_of(recorded: Array | None, lanes: NDArray[np.intp] | int) -> Array | None:
    """Recorded signals of some lanes, or of one; what all share as it is."""
    return recorded if recorded is None or recorded.ndim == 2 else recorded[:, :, lanes]


def _virtual_batch(
    functions: Mapping[str, Any],
    parameters: Array,
    settings: LoopSettings,
    inputs: LoopInputs,
    wanted: Sequence[str],
    recorded: Array | None,
) -> tuple[NDArray[np.int32], NDArray[np.int64], dict[str, Array]]:
    """Lane by lane in the virtual machine."""
    lanes = len(parameters)
    out = {name: np.empty((len(inputs.reference), lanes)) for name in wanted}
    status, stopped = np.zeros(lanes, dtype=np.int32), np.zeros(lanes, dtype=np.int64)
    for lane in range(lanes):
        own, allowed = inputs.lanes(lane), float(settings.allowed[lane])
        loop = VirtualLoop(functions, parameters[lane], replace(settings, allowed=allowed))
        given = (own.reference, own.noise, own.injected, own.start)
        status[lane], stopped[lane], signals = loop.run(*given, _lines_of(recorded, lane))
        for name in wanted:
            out[name][:, lane] = signals[name]
    return status, stopped, out
