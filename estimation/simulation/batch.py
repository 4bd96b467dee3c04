"""Many closed loops side by side, across processors."""

from __future__ import annotations  # as they are written, in what help() prints

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from axisid.codegen.artefacts import GeneratedAxis, as_generated
from axisid.codegen.lowering import BLOCK, SIGNALS, STATUSES, LoopSettings, LoopStart
from axisid.codegen.runtime import VirtualLoop
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array, Exact
from axisid.support.real_numbers import real_array

from .between import at_log_samples
from .lane_arguments import (
    aligned,
    check_lanes,
    check_threads,
    gains_by_lane,
    in_order,
    lane_injected,
    lane_noise,
    wanted_names,
)
from .loop_start import lane_starts
from .recorded import at_law, checked_signals, first_values, lines
from .reducers import (
    LaneBlock,
    Reducer,
    check_wanted,
    checked_reducers,
    joined,
    needed_signals,
    reduced,
)
from .runaway import allowed_distance, widened_distance
from .steps import (
    MOST_SUBSTEPS,
    bounds_refusal,
    check_loop,
    failure,
    fastest_place,
    has_constant_substeps,
    has_states,
    inertia_and_hold,
    most_substeps,
    no_inertia,
    place_at,
    pushes,
    states_refusal,
    substeps_along,
    substeps_at_start,
    too_stiff,
    visited_signals,
)
from .two_clocks import TwoClocks, clocks_of

#: What is needed between the evaluations of a law.
_OF_THE_LAW = ("position", "velocity", "acceleration", "force", "direction", "before")
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
    reduce: str | Reducer | Sequence[str | Reducer] | None = None,
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
    reduce : str, callable or sequence of them, optional
        What is kept of each lane in place of its signals, so that memory does not grow by N x B:
        lanes are simulated and reduced block by block. ``"final"``, ``"mean"``, ``"rms"``,
        ``"peak"`` (the largest amount) and ``"span"`` (from the least to the largest) of every
        signal that is wanted, under names such as ``"rms_force"``; ``"max_tracking_error"`` and
        ``"rms_tracking_error"``, of the position from the reference. A callable takes a `LaneBlock`
        and gives arrays by name, (b, ...), a row for each of its lanes. NaN for a lane that failed.
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
    lanes = len(theta)
    check_lanes(theta, ref)
    noise = lane_noise(position_noise, (len(ref), lanes))
    added = lane_injected(injected, (len(ref), lanes))
    reducers = None if reduce is None else checked_reducers(reduce)
    names = wanted_names(wanted)
    if reducers is not None:
        check_wanted(reducers, names)
    beside = () if reducers is None else needed_signals(reducers)
    logged = ref, period
    given_signals = checked_signals(axis, signals, len(ref), lanes)
    clocks = clocks_of(axis.axis.control, len(ref), period)
    if clocks is not None:
        ref, period = clocks.reference(ref), clocks.law_period
        noise, added = (None if each is None else clocks.held(each) for each in (noise, added))
        given_signals = at_law(axis, given_signals, clocks)
    off = np.zeros(lanes) if noise is None else noise[0]
    recorded = lines(axis, given_signals, period)
    at_first = first_values(recorded)
    by_lane = gains_by_lane(axis, gains, lanes)
    first = lane_starts(
        axis, theta, ref[0], off, resolution, start, start_velocity, memory, at_first, by_lane
    )
    check_threads(threads)
    fixed = has_constant_substeps(axis) or substeps is not None
    looked_at = () if fixed else visited_signals(axis)
    between = () if clocks is None else _OF_THE_LAW
    away = np.abs(first.position - ref[0])
    spans = np.broadcast_to(np.ptp(ref, axis=0), lanes)
    batch = _Batch(
        axis=axis,
        parameters=theta,
        reference=ref,
        noise=noise,
        injected=added,
        start=first,
        period=period,
        resolution=resolution,
        allowed=np.array([allowed_distance(*each) for each in zip(spans, away, strict=True)]),
        wanted=list(dict.fromkeys([*names, *beside, *looked_at, *between])),
        threads=threads,
        signals=given_signals,
        recorded=recorded,
        gains=by_lane,
    )
    given_names = dict(zip(wanted, names, strict=True))
    if reducers is not None:
        return _reduced(batch, reducers, given_names, logged, substeps, clocks)
    out, failures = batch.at_log_samples(substeps, clocks)
    return BatchSimulation(
        signals={given: out[name] for given, name in given_names.items()},
        failures=dict(sorted(failures.items())),
    )


def _reduced(
    batch: _Batch,
    reducers: Sequence[str | Reducer],
    names: Mapping[str, str],
    logged: tuple[Array, float],
    substeps: int | None,
    clocks: TwoClocks | None,
) -> BatchSimulation:
    """Simulate and reduce block by block; `logged` are the reference and its period as given."""
    failures: dict[int, str] = {}
    blocks = []
    for chosen in batch.blocks():
        own = batch.of(chosen)
        out, failed = own.at_log_samples(substeps, clocks)
        failures |= {chosen.start + lane: why for lane, why in failed.items()}
        block = LaneBlock(
            first=chosen.start,
            parameters=own.parameters,
            reference=logged[0] if logged[0].ndim == 1 else logged[0][:, chosen],
            period=logged[1],
            signals={given: out[name] for given, name in names.items()},
        )
        blocks.append(reduced(reducers, block, out))
    return BatchSimulation(
        signals={}, failures=dict(sorted(failures.items())), reduced=joined(blocks)
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Batch:
    """What the groups of lanes of a batch share."""

    axis: GeneratedAxis
    parameters: Array
    reference: Array
    noise: Array | None
    injected: Array | None
    start: LoopStart
    period: float
    resolution: float
    allowed: Array
    wanted: Sequence[str]
    threads: int | None
    signals: tuple[Array, ...]
    recorded: Array | None
    gains: Array | None

    def blocks(self) -> Iterator[slice]:
        """The lanes in parts whose signals lie in memory together."""
        blocks = _KEPT // (BLOCK * len(self.reference) * len(self.wanted))
        size = BLOCK * max(blocks, self._count())
        for first in range(0, len(self.parameters), size):
            yield slice(first, min(first + size, len(self.parameters)))

    def of(self, lanes: slice) -> _Batch:
        """The same of some of its lanes."""
        chosen = np.arange(lanes.start, lanes.stop)
        return replace(
            self,
            parameters=self.parameters[lanes],
            reference=self.reference if self.reference.ndim == 1 else self.reference[:, lanes],
            noise=_of_lanes(self.noise, chosen),
            injected=_of_lanes(self.injected, chosen),
            start=_start_of(self.start, chosen),
            allowed=self.allowed[lanes],
            signals=tuple(v if v.ndim == 1 else v[:, lanes] for v in self.signals),
            recorded=_lines_of(self.recorded, chosen),
            gains=None if self.gains is None else self.gains[lanes],
        )

    def at_log_samples(
        self, substeps: int | None, clocks: TwoClocks | None
    ) -> tuple[dict[str, Array], dict[int, str]]:
        """Simulate every lane; the signals at the samples of the reference, and the failures."""
        out, failures = self.run(substeps)
        if clocks is None:
            return out, failures
        lanes = [
            at_log_samples(
                self.axis,
                self.parameters[lane],
                {name: values[:, lane] for name, values in out.items()},
                clocks,
                _lines_of(self.recorded, lane),
            )
            for lane in range(len(self.parameters))
        ]
        return {name: np.column_stack([lane[name] for lane in lanes]) for name in out}, failures

    def run(self, substeps: int | None) -> tuple[dict[str, Array], dict[int, str]]:
        """Simulate every lane; returns the signals, (N, B) each, and the failures."""
        lanes = len(self.parameters)
        failures = self._refused()
        sound = np.array([lane not in failures for lane in range(lanes)])
        counts = np.full(lanes, substeps or 1)
        if substeps is None and sound.any():
            counts[sound] = substeps_at_start(
                self.axis,
                self.parameters[sound],
                self.start.position[sound],
                self.period,
                self._first(np.flatnonzero(sound)),
            )
        out: dict[str, Array] = {}
        most = MOST_SUBSTEPS if substeps else most_substeps(len(self.reference))
        stiff = sound & (counts > most)
        counts = np.minimum(counts, most)
        if has_constant_substeps(self.axis):
            self._refuse(out, np.flatnonzero(stiff), failures)
            sound &= ~stiff
        pending = np.flatnonzero(sound)
        while pending.size:
            # Lanes that ask for more steps in a sample run apart, and do not slow the others.
            groups = [pending[counts[pending] == count] for count in np.unique(counts[pending])]
            for group in groups:
                self._run_into(out, group, int(counts[group[0]]), failures)
            if substeps is not None or has_constant_substeps(self.axis):
                break
            needed = np.array([self._needed(out, int(lane)) for lane in pending])
            more = needed > counts[pending]
            self._refuse(out, pending[more & (counts[pending] == most)], failures)
            more &= counts[pending] < most
            counts[pending] = np.clip(needed, counts[pending], most)
            pending = pending[more]
        return out or self._nothing(), failures

    def _refused(self) -> dict[int, str]:
        """What to say of lanes that no simulation starts from."""
        first = self._first(np.arange(len(self.parameters)))
        place, refused = (self.axis, self.parameters, self.start.position, first), {}
        has_mass, held = inertia_and_hold(*place)
        low, high = np.array([(p.lower, p.upper) for p in self.axis.axis.parameters]).T
        inside = ((low <= self.parameters) & (self.parameters <= high)).all(axis=1)
        remembers = has_states(self.axis, self.parameters)
        for lane in map(int, np.flatnonzero(~(inside & has_mass & held & remembers))):
            theta = self.parameters[lane]
            refusal = bounds_refusal(self.axis, theta)
            if not remembers[lane]:
                refused[lane] = states_refusal(self.axis, theta)
                continue
            if not has_mass[lane]:
                at, own = float(self.start.position[lane]), self._first(np.array([lane]))
                refused[lane] = no_inertia(self.axis, theta, at, own)
            elif refusal or not held[lane]:
                refused[lane] = refusal or pushes(self.axis, theta)
        return refused

    def _refuse(
        self, out: Mapping[str, Array], lanes: NDArray[np.intp], failures: dict[int, str]
    ) -> None:
        for lane in map(int, lanes):
            theta, (visited, own) = self.parameters[lane], self._visited(out, lane)
            at = fastest_place(self.axis, theta, visited, self.period, own)
            failures[lane] = too_stiff(self.axis, theta, at, self.period, len(self.reference))
            for values in out.values():
                values[:, lane] = np.nan

    def _needed(self, out: Mapping[str, Array], lane: int) -> int:
        visited, own = self._visited(out, lane)
        return substeps_along(self.axis, self.parameters[lane], visited, self.period, own)

    def _visited(self, out: Mapping[str, Array], lane: int) -> tuple[dict[str, Array], list[Array]]:
        """Where a lane went, or starts, and its recorded signals."""
        own = [v if v.ndim == 1 else v[:, lane] for v in self.signals]
        if not out:
            still = dict.fromkeys(visited_signals(self.axis), np.zeros(1))
            return still | {"position": self.start.position[lane : lane + 1]}, own
        position = out["position"][:, lane]
        ended = np.isnan(position)
        until = int(ended.argmax()) if ended.any() else len(position)
        names = visited_signals(self.axis)
        return {name: np.ascontiguousarray(out[name][:until, lane]) for name in names}, own

    def _first(self, lanes: NDArray[np.intp]) -> Array:
        """First values of the recorded signals of some lanes."""
        first = first_values(self.recorded)
        return first if first.ndim == 1 else first[:, lanes]

    def _nothing(self) -> dict[str, Array]:
        shape = (len(self.reference), len(self.parameters))
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
        every = group is None
        chosen = np.arange(len(self.parameters)) if group is None else group
        settings = LoopSettings(
            period=self.period,
            resolution=self.resolution,
            allowed=self.allowed if every else np.ascontiguousarray(self.allowed[chosen]),
            substeps=substeps,
        )
        arguments = (
            self.reference if every or self.reference.ndim == 1 else self.reference[:, chosen],
            self.noise if every else _of_lanes(self.noise, chosen),
            self.injected if every else _of_lanes(self.injected, chosen),
            self._theta(group),
            self.start if every else _start_of(self.start, chosen),
            settings,
            self.wanted,
        )
        recorded = self.recorded if every else _lines_of(self.recorded, chosen)
        code = (
            self.axis.loop if self.gains is not None and self.axis.loop is not None else self.axis
        )
        library = code.native.library()
        if library is None:
            code.native.warn_once()
            status, stopped, out = _virtual_batch(code.functions, *arguments, recorded)
        else:
            status, stopped, out = library.simulate_batch(*arguments, self._count(), recorded)
        again = self._widened(status, chosen)
        for i in np.flatnonzero(status):
            lane, sample = int(chosen[i]), int(stopped[i])
            if not again[i]:
                own = [v if v.ndim == 1 else v[:, lane] for v in self.signals]
                known = {"position", "velocity"} <= out.keys()
                at = place_at({n: v[:, i] for n, v in out.items()}, sample, own) if known else None
                why = (self.axis, self.parameters[lane], int(status[i]), sample, self.period, at)
                failures[lane] = failure(*why)
            for signal in out.values():
                signal[sample:, i] = np.nan
        if again.any():
            for name, values in self._lanes(chosen[again], substeps, failures).items():
                out[name][:, again] = values
        return out

    def _count(self) -> int:
        """Threads."""
        if self.threads is not None:
            return int(self.threads)
        return (
            len(os.sched_getaffinity(0))
            if hasattr(os, "sched_getaffinity")
            else os.cpu_count() or 1
        )

    def _theta(self, group: NDArray[np.intp] | None) -> Array:
        """Parameters of a group of lanes, or of all, behind them gains of their own."""
        theta = self.parameters
        theta = theta if self.gains is None else np.hstack([theta, self.gains])
        return theta if group is None else np.ascontiguousarray(theta[group])

    def _widened(self, status: NDArray[np.int32], chosen: NDArray[np.intp]) -> NDArray[np.bool_]:
        """Which lanes left a range that was too narrow for their load; it is widened for them."""
        again = np.asarray(status == STATUSES.index("out of range"))
        if again.any():
            lanes = chosen[again]
            wider = widened_distance(
                self.axis,
                self.parameters[lanes],
                self.start.position[lanes],
                _of_lanes(self.noise, lanes),
                _of_lanes(self.injected, lanes),
                self.resolution,
                self._first(lanes),
            )
            again[again] = wider > self.allowed[lanes]
            self.allowed[lanes] = np.maximum(self.allowed[lanes], wider)
        return again


def _of_lanes(values: Array | None, lanes: NDArray[np.intp]) -> Array | None:
    """A signal of some lanes; one that all share as it is."""
    return values if values is None or values.ndim == 1 else values[:, lanes]


def _lines_of(recorded: Array | None, lanes: NDArray[np.intp] | int) -> Array | None:
    """Recorded signals of some lanes, or of one; what all share as it is."""
    return recorded if recorded is None or recorded.ndim == 2 else recorded[:, :, lanes]


def _start_of(start: LoopStart, lanes: NDArray[np.intp] | int) -> LoopStart:
    """Where one lane or several start."""
    memory = None if start.memory is None else np.ascontiguousarray(start.memory[lanes])
    return LoopStart(position=start.position[lanes], velocity=start.velocity[lanes], memory=memory)


def _virtual_batch(
    functions: Mapping[str, Any],
    reference: Array,
    noise: Array | None,
    injected: Array | None,
    parameters: Array,
    start: LoopStart,
    settings: LoopSettings,
    wanted: Sequence[str],
    recorded: Array | None,
) -> tuple[NDArray[np.int32], NDArray[np.int64], dict[str, Array]]:
    """Lane by lane in the virtual machine."""
    lanes = len(parameters)
    out = {name: np.empty((len(reference), lanes)) for name in wanted}
    status, stopped = np.zeros(lanes, dtype=np.int32), np.zeros(lanes, dtype=np.int64)
    for lane in range(lanes):
        own = replace(settings, allowed=float(settings.allowed[lane]))
        status[lane], stopped[lane], signals = VirtualLoop(functions, parameters[lane], own).run(
            reference if reference.ndim == 1 else reference[:, lane],
            None if noise is None else noise[:, lane],
            injected if injected is None or injected.ndim == 1 else injected[:, lane],
            _start_of(start, lane),
            _lines_of(recorded, lane),
        )
        for name in wanted:
            out[name][:, lane] = signals[name]
    return status, stopped, out
