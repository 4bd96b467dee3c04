"""Many closed loops side by side, across processors."""

from __future__ import annotations  # as they are written, in what help() prints

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from axisid.codegen.artefacts import GeneratedAxis, as_generated
from axisid.codegen.lowering import SIGNALS
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array, Exact
from axisid.support.errors import AxisidError, UsageError, quoted

from .arguments import check_whole, checked_loop
from .closed_loop import settled_loop
from .inputs import LoopInputs, at_log_samples, lines
from .simulated import lane_starts
from .steps import (
    MOST_SUBSTEPS,
    at_rest,
    has_constant_substeps,
    most_substeps,
    states_refusal,
    steps_by_rate,
    substeps_along,
    visited_signals,
)

#: What is needed between the evaluations of a law.
_OF_THE_LAW = tuple(name for name in SIGNALS if name != "control")
_MOST_THREADS = 1024


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BatchSimulation(Exact):
    """Many simulations side by side.

    Attributes
    ----------
    signals : dict of str to (N, B) array
        The signals that were asked for, by name as in `Simulation`; NaN from the sample on at which
        a simulation ended early.
    failures : dict of int to str
        Why and where, by lane, for those that ended early.
    """

    signals: dict[str, Array]
    failures: dict[int, str]

    def __getitem__(self, name: str) -> Array:
        return self.signals[name]


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
        Signals of the simulation that are given back, each N x B floats. Names as in `Simulation`.
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
    A lane that fails does not end the others; see `BatchSimulation.failures`. What a lane gives
    does not depend on its company: where all signals take too much memory, simulate some
    lanes after the others.

    The substeps are those of `simulate`, settled once before any lane runs where no motion asks for
    more of them than the start does. Where damping, stiffness or waves vary along the way each lane
    has its own, by where its own motion goes: with the most of any lane for all of them, what a
    lane gives would depend on its company.
    """
    axis = as_generated(axis)
    check_whole("the threads", threads, _MOST_THREADS)
    several = isinstance(wanted, Iterable) and not isinstance(wanted, str)
    if not several or any(name not in SIGNALS for name in wanted):
        raise UsageError(
            f"the wanted signals are {quoted(wanted)}; give a list of names, of "
            f"{', '.join(SIGNALS)}.",
            code="simulation-input",
        )
    theta, inputs = checked_loop(
        axis,
        parameters,
        reference,
        period,
        many=True,
        start=start,
        start_velocity=start_velocity,
        memory=memory,
        position_noise=position_noise,
        injected=injected,
        signals=signals,
        gains=gains,
        resolution=resolution,
        substeps=substeps,
    )
    return simulate_lanes(axis, theta, inputs, substeps=substeps, wanted=wanted, threads=threads)


def simulate_lanes(
    axis: GeneratedAxis,
    parameters: Array,
    inputs: LoopInputs,
    *,
    substeps: int | None = None,
    wanted: Sequence[str],
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
    threads : int, optional
        As in `simulate_batch`.
    """
    fixed = has_constant_substeps(axis) or substeps is not None
    looked_at = () if fixed else visited_signals(axis)
    between = () if inputs.clocks is None else _OF_THE_LAW
    by_system = hasattr(os, "sched_getaffinity")
    processors = len(os.sched_getaffinity(0)) if by_system else os.cpu_count() or 1
    batch = _Batch(
        axis=axis,
        parameters=np.ascontiguousarray(parameters),
        inputs=replace(inputs, start=lane_starts(axis, parameters, inputs), log=None),
        wanted=list(dict.fromkeys([*wanted, *looked_at, *between])),
        threads=threads or processors,
    )
    out, failures = batch.run(substeps)
    return BatchSimulation(
        signals={name: out[name] for name in wanted},
        failures=dict(sorted(failures.items())),
    )


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
    most = most_substeps(len(inputs.reference))
    if has_constant_substeps(axis):
        position = np.array([inputs.start.position])
        rates = at_rest(axis, parameters[None, :], position, inputs.first_signals)[2]
        return min(int(steps_by_rate(axis, rates, inputs.period)[0]), most)
    try:
        _, steps, failed = settled_loop(axis, parameters, inputs, bounded=True)
    except AxisidError:
        return None
    return None if failed else min(steps, most)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Batch:
    """What the groups of lanes of a batch share."""

    axis: GeneratedAxis
    parameters: Array
    inputs: LoopInputs
    wanted: Sequence[str]
    threads: int

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
        well, out = well & (counts <= most), dict[str, Array]()
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
            own, given = dict[str, Array](), (self.parameters[lane], self.inputs.lanes(lane))
            try:
                own, counts[lane], failures[lane] = settled_loop(
                    axis, *given, substeps=substeps, bounded=True
                )
            except AxisidError as error:
                failures[lane] = str(error)
            for name, values in out.items():
                values[:, lane] = own.get(name, np.nan)
        if self.inputs.clocks is not None:
            sampled = [self._at_log_samples(out, lane, int(counts[lane])) for lane in lanes]
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
        own, names = self.inputs.lanes(lane), visited_signals(self.axis)
        visited = {name: np.ascontiguousarray(out[name][:, lane]) for name in names}
        return substeps_along(self.axis, self.parameters[lane], visited, own.period, own.signals)[0]

    def _at_log_samples(
        self, out: Mapping[str, Array], lane: int, substeps: int
    ) -> dict[str, Array]:
        own = self.inputs.lanes(lane)
        recorded = lines(self.axis, own.signals, own.period)
        signals = {name: np.ascontiguousarray(values[:, lane]) for name, values in out.items()}
        theta, clocks = self.parameters[lane], own.clocks
        assert clocks is not None  # noqa: S101
        return at_log_samples(self.axis, theta, signals, clocks, recorded, substeps)

    def _nothing(self) -> dict[str, Array]:
        shape = len(self.inputs.reference), len(self.parameters)
        return {name: np.full(shape, np.nan) for name in self.wanted}

    def _run_into(
        self, out: dict[str, Array], group: NDArray[np.intp], substeps: int
    ) -> NDArray[np.bool_]:
        """Simulate a group of lanes into the signals of all; which of them came to the end."""
        inputs, every = self.inputs, len(group) == len(self.parameters)
        code = self.axis if inputs.gains is None else self.axis.loop or self.axis
        library = code.native.library()
        if library is None:
            return np.zeros(len(group), dtype=bool)
        theta = self.parameters[group]
        inputs = inputs if every else inputs.lanes(group)
        status, _, made = library.simulate_batch(
            inputs.reference,
            inputs.noise,
            inputs.injected,
            theta if inputs.gains is None else np.hstack([theta, inputs.gains]),
            inputs.start,
            inputs.settings(substeps),
            self.wanted,
            self.threads,
            lines(self.axis, inputs.signals, inputs.period),
        )
        if every:
            out.update(made)
        else:
            out.update({} if out else self._nothing())
            for name, values in made.items():
                out[name][:, group] = values
        return np.asarray(status == 0)
