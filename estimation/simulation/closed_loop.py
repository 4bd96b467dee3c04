"""Simulation of the closed loop from its reference.

A sampled control law is evaluated once per sample, and its control is held until the next sample; a
continuous law is evaluated continuously. Between samples, the plant moves in one friction mode:
forward, backward or stuck. At a zero of the velocity the crossing is located and a new mode is
chosen. At rest the model decides: with the accelerations a(+) and a(-) for both friction
directions, the axis sticks if and only if ``a(+) <= 0 <= a(-)`` [Filippov1988]_. Native code is
used if there is a compiler, the CasADi virtual machine otherwise.

Many loops run in parallel on several processors. A loop that is refused, or that needs a larger
range or too many steps, is simulated separately.
"""

from __future__ import annotations  # as they are written, in what help() prints

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from axisid.codegen.generated_axes import GeneratedAxis, as_generated
from axisid.codegen.lowering import SIGNALS, STATUSES, LoopSettings
from axisid.codegen.runtime import VirtualLoop
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array, Exact
from axisid.support.errors import AxisidError, EstimationError, UsageError
from axisid.support.wording import quoted

from .integration_steps import (
    MOST_SUBSTEPS,
    StepBudget,
    has_constant_substeps,
    loop_settings,
    most_substeps,
    steps_by_rate,
    substeps_along,
    visited_signals,
    widened_distance,
)
from .loop_inputs import LoopInputs, TwoClocks, at_log_samples, axis_of, lines
from .refusals import (
    at_rest,
    check_whole,
    checked_loop,
    checked_rate,
    failure,
    place_at,
    states_refusal,
    too_stiff,
)
from .simulated_signals import Simulation, lane_starts, loop_start, measured_positions

_MOST_THREADS = 1024


def simulate(
    axis: Axis | GeneratedAxis,
    parameters: ArrayLike | Mapping[str, float],
    reference: ArrayLike,
    period: float,
    *,
    start: float | None = None,
    start_velocity: float = 0.0,
    memory: ArrayLike | None = None,
    position_noise: ArrayLike | None = None,
    injected: ArrayLike | None = None,
    signals: Mapping[str, ArrayLike] | None = None,
    resolution: float = 0.0,
    substeps: int | None = None,
) -> Simulation:
    """Return the simulation of an axis under its control law, from rest unless a velocity is given.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
        Axis with a control law.
    parameters : (p,) array_like or mapping of str to float
        Physical parameters, SI: in the axis's order, or all of them by name.
    reference : (N,) array_like
        Commanded position.
    period : float
        Sampling period of the reference and of the result, s. If it is not the period of the
        control law, the loop runs at the law's period: the reference is interpolated as the law
        declares (``reference_between``), or by a spline, and the loop is sampled at `period`.
    start : float, optional
        First position; the first reference by default.
    start_velocity : float
        First velocity.
    memory : (m,) array_like, optional
        State of the drive at the first sample: the memory of the law in its order; then the
        controls that are computed but not yet applied, the newest first; then, for a drive with a
        lag or a delay, the forces of commands that do not act yet, the newest first, and the
        present force. By default as the law declares for an axis at rest.
    position_noise : (N,) array_like, optional
        Noise that is added to the position that the law measures; held between samples if the law
        has another period.
    injected : (N,) array_like, optional
        Test signal in the drive's unit, added to the control of the law before the drive's limit
        and the law's delay; held from a sample to the next. Add a test signal at the reference to
        `reference`.
    signals : mapping of str to (N,) array_like, optional
        The recorded signals that the axis declares, by name, SI, one value for each sample of the
        reference. Between samples each signal is held or interpolated linearly, as it is declared;
        the law and the force of a sampled law read them at the samples.
    resolution : float
        Encoder step in the coordinate's unit; the law then reads whole counts. 0 for none.
    substeps : int, optional
        Runge-Kutta steps per sample, at most 1024; the error falls with their fourth power. By
        default a power of 2 that resolves damping, stiffness and waves over the position along the
        motion, mostly 1. If these vary along the motion, the simulation is repeated until the steps
        suffice. For an axis whose force has kinks or jumps over the position it is the minimum:
        each part of a sample, between two kinks, has the steps that its own rates need. Friction
        with internal state uses implicit steps, as many as its stiffness needs; the internal states
        start at their declared values.

    Raises
    ------
    ModelError
        The axis has no control law.
    UsageError
        An argument has the wrong shape or value, a parameter is beyond its declared bounds, or the
        period and the control law's are more than 400 times apart.
    EstimationError
        The inertia is not positive, friction drives the axis, or the loop diverges, chatters or is
        too fast to follow; the sample is named.
    """
    axis = as_generated(axis)
    theta, inputs = checked_loop(
        axis,
        parameters,
        reference,
        period,
        start=start,
        start_velocity=start_velocity or None,
        memory=memory,
        position_noise=position_noise,
        injected=injected,
        signals=signals,
        resolution=resolution,
        substeps=substeps,
    )
    return simulate_loop(axis, theta, inputs, substeps=substeps, bounded=True)


def simulate_loop(
    axis: GeneratedAxis,
    parameters: Array,
    inputs: LoopInputs,
    *,
    substeps: int | None = None,
    budget: StepBudget | None = None,
    bounded: bool = False,
) -> Simulation:
    """Return the simulation of one loop from checked inputs, or from those of a record.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (p,) array
    inputs : LoopInputs
        Inputs at the law's evaluations.
    substeps : int, optional
        Steps per sample; by default as many as needed.
    budget : StepBudget, optional
        Remaining steps of a search, from which the steps of this simulation are subtracted.
    bounded : bool
        True if parameters beyond their bounds, and friction that drives the axis, are refused;
        estimates may be slightly beyond their bounds.

    Raises
    ------
    UsageError, EstimationError
        As in `simulate`.
    """
    # Inputs at the samples of the log; without two clocks these are the inputs of the law.
    clocks, logged = inputs.clocks, inputs.log or inputs
    if clocks is not None and axis.response is not None:
        raise UsageError(
            f"the sampling period is {clocks.log_period:g} s, but the control law of axis "
            f"{axis.name!r} is evaluated every {clocks.law_period:g} s. The drive has a "
            f"{' and '.join(axis.of_law_samples)}, so its loop is simulated only at the "
            "evaluations of the law. Give the period of the law.",
            code="loop-period",
        )
    out, steps, failed = settled_loop(
        axis, parameters, inputs, substeps=substeps, budget=budget, bounded=bounded
    )
    if failed:
        raise EstimationError(failed, code="simulation")
    if clocks is not None:
        out = at_log_samples(axis, parameters, out, clocks, inputs.signals, steps)
    return Simulation(
        time=logged.period * np.arange(float(len(out["position"]))),
        measured_position=measured_positions(out["position"], logged.noise, inputs.resolution),
        recorded=logged.signals,
        **out,
    )


def settled_loop(
    axis: GeneratedAxis,
    parameters: Array,
    inputs: LoopInputs,
    *,
    substeps: int | None = None,
    budget: StepBudget | None = None,
    bounded: bool = False,
) -> tuple[dict[str, Array], int, str]:
    """Simulate a loop at the evaluations of its law, with sufficient steps and range.

    The simulation is repeated with more steps per sample until they resolve the motion, and with a
    larger allowed distance from the reference if that is exceeded. The arguments are those of
    `simulate_loop`.

    Returns
    -------
    dict of str to (M,) array
        Signals by name; NaN from the sample at which the loop ended early.
    int
        Steps per sample.
    str
        Reason and place of an early end; empty for a complete loop.

    Raises
    ------
    UsageError, EstimationError
        The loop cannot start, or needs too many steps.
    """
    axis, theta = axis_of(axis, inputs), np.ascontiguousarray(parameters)
    first = tuple(map(float, inputs.first_signals))
    inputs = replace(inputs, start=loop_start(axis, theta, inputs))
    rate = checked_rate(axis, theta, float(inputs.start.position), first, bounded=bounded)
    period, samples, constant = inputs.period, len(inputs.reference), has_constant_substeps(axis)
    budget, recorded = budget or StepBudget(), lines(axis, inputs.signals, period)
    steps = substeps or int(steps_by_rate(axis, np.array([rate]), period)[0])
    if substeps is None and steps > most_substeps(samples, budget.left):
        still = (float(inputs.start.position), 0.0), first
        raise too_stiff(axis, theta, still, period, samples, budget.left)
    settings = loop_settings(inputs, steps)
    while True:
        steps_left = budget.left
        budget.left -= samples * settings.substeps
        status, stopped, out = _run(axis, theta, settings, inputs, recorded)
        # More steps, if the simulated motion needs them.
        if substeps is None and not constant:
            visited = {name: values[:stopped] if status else values for name, values in out.items()}
            needed, sample = substeps_along(axis, theta, visited, period, inputs.signals)
            most = most_substeps(samples, steps_left)
            if needed > settings.substeps >= most:
                at = place_at(visited, sample, inputs.signals)
                raise too_stiff(axis, theta, at, period, samples, steps_left)
            if needed > settings.substeps:
                settings = replace(settings, substeps=min(needed, most))
                continue
        # A larger range, if the loop is moved by load, noise or test signals only.
        if STATUSES[status] != "out of range":
            break
        wider = widened_distance(axis, theta, inputs)
        if not wider > settings.allowed:
            break
        settings = replace(settings, allowed=wider)
    failed = ""
    if status:
        at = place_at(out, stopped, inputs.signals)
        failed = failure(axis, theta, status, stopped, period, at)
        for values in out.values():
            values[stopped:] = np.nan
    return out, settings.substeps, failed


def _run(
    axis: GeneratedAxis,
    parameters: Array,
    settings: LoopSettings,
    inputs: LoopInputs,
    recorded: Array | None,
) -> tuple[int, int, dict[str, Array]]:
    """Run a loop once, in native code or in the CasADi virtual machine.

    Returns
    -------
    int
        Index in `STATUSES`; 0 for a complete loop.
    int
        Sample at which the loop ended early.
    dict of str to (M,) array
        Signals by name.
    """
    reference = np.ascontiguousarray(inputs.reference)
    noise, injected = inputs.noise, inputs.injected
    if noise is not None:
        noise = np.ascontiguousarray(noise)
    if injected is not None:
        injected = np.ascontiguousarray(injected)
    library = axis.native.library()
    if library is None:
        axis.native.warn_once()
        loop = VirtualLoop(axis.functions, parameters, settings)
        return loop.run(reference, noise, injected, inputs.start, recorded)
    return library.simulate(
        reference, noise, injected, parameters, inputs.start, settings, recorded
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BatchSimulation(Exact):
    """Signals of many simulations in parallel lanes.

    Attributes
    ----------
    signals : dict of str to (N, B) array
        The requested signals, by name as in `Simulation`; NaN from the sample at which a simulation
        ended early.
    failures : dict of int to str
        Reason and place of an early end, by lane.
    """

    signals: dict[str, Array]
    failures: dict[int, str]

    def __getitem__(self, name: str) -> Array:
        """Return one of the requested signals, (N, B)."""
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
    """Return simulations of many parameter sets, references or noises in parallel lanes.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
        Axis with a control law.
    parameters : (B, p) array_like or mapping of str to (B,) array_like
        One row for each lane.
    reference : (N,) or (N, B) array_like
        One reference for all lanes, or one column for each lane.
    period : float
        Sampling period of the reference, s; if it is not the law's, as in `simulate`.
    start : (B,) array_like, optional
        First positions; the first references by default.
    start_velocity : (B,) array_like, optional
        First velocities; 0 by default.
    memory : (B, m) array_like, optional
        State of each drive, as in `simulate`.
    position_noise : (N, B) array_like, optional
        Noise that is added to the position that the law measures.
    injected : (N,) or (N, B) array_like, optional
        Test signal that is added to the control; one signal for all lanes, or one column for each.
    signals : mapping of str to (N,) or (N, B) array_like, optional
        The recorded signals that the axis declares, as in `simulate`; one signal for all lanes, or
        one column for each lane.
    gains : mapping of str to float or (B,) array_like, optional
        Gains of a sampled law by name, SI, one value for all lanes or one for each lane; other
        gains are as declared. No code is compiled for them.
    resolution, substeps
        As in `simulate`.
    wanted : sequence of str
        Names of the signals to return, as in `Simulation`; each is an array of N x B floats.
    threads : int, optional
        1 to 1024; by default the number of processors.

    Raises
    ------
    ModelError
        The axis has no control law, or no law with variable gains.
    UsageError
        An argument has the wrong shape or value.

    Notes
    -----
    A lane that fails does not end the others; see `BatchSimulation.failures`. The result of a lane
    does not depend on the other lanes: if all signals need too much memory, simulate the lanes in
    several calls.

    The substeps are those of `simulate`. They are chosen once before any lane runs if no motion
    needs more steps than the start. If damping, stiffness or waves vary along the motion, each lane
    has its own number: with the largest number for all lanes, the result of a lane would depend on
    the other lanes.
    """
    axis = as_generated(axis)
    check_whole("threads", threads, _MOST_THREADS)
    several = isinstance(wanted, Iterable) and not isinstance(wanted, str)
    if not several or any(name not in SIGNALS for name in wanted):
        raise UsageError(
            f"the wanted signals are {quoted(wanted)}. Give a list of names from "
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
    """Return the signals of simulated loops with parameters (B, p), at the samples of the log.

    Lanes run in groups with equal steps per sample. Lanes that cannot run in a group, or do not
    complete in a group, are simulated separately.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (B, p) array
    inputs : LoopInputs
        Inputs of all lanes at the law's evaluations.
    substeps : int, optional
        As in `simulate`.
    wanted : sequence of str
        Names of the signals to return.
    threads : int, optional
        As in `simulate_batch`.
    """
    theta = np.ascontiguousarray(parameters)
    inputs = replace(inputs, start=lane_starts(axis, theta, inputs), log=None)
    is_fixed = bool(substeps) or has_constant_substeps(axis)
    visited: tuple[str, ...] = ()
    if not is_fixed:
        visited = visited_signals(axis)
    # The wanted signals, and those from which the steps and the samples of the log are calculated.
    names = [*wanted, *visited]
    if inputs.clocks is not None:
        names += [name for name in SIGNALS if name != "control"]
    shape = len(inputs.reference), len(theta)
    out = {name: np.empty(shape) for name in names}
    # Groups first, then the lanes that are not complete.
    complete, counts = _run_in_groups(out, axis, theta, inputs, substeps, visited, threads)
    failures: dict[int, str] = {}
    for lane in map(int, np.flatnonzero(~complete)):
        steps, failures[lane] = _run_separately(out, axis, theta, inputs, lane, substeps)
        if steps is not None:
            counts[lane] = steps
    if inputs.clocks is not None:
        out = _at_samples_of_log(out, axis, theta, inputs, inputs.clocks, counts)
    return BatchSimulation(
        signals={name: out[name] for name in wanted},
        failures={lane: why for lane, why in failures.items() if why},
    )


def _run_in_groups(
    out: dict[str, Array],
    axis: GeneratedAxis,
    parameters: Array,
    inputs: LoopInputs,
    substeps: int | None,
    visited: tuple[str, ...],
    threads: int | None,
) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Simulate lanes in groups of equal steps per sample, repeated until the steps suffice.

    Parameters
    ----------
    out : dict of str to (M, B) array
        Arrays by name, in which the signals are stored.
    axis : GeneratedAxis
    parameters : (B, p) array
    inputs : LoopInputs
    substeps : int or None
        As in `simulate`.
    visited : tuple of str
        Names of the signals from which the steps are chosen; empty for constant steps.
    threads : int or None
        Number of threads; None for that of the processors.

    Returns
    -------
    (B,) array of bool
        True for complete lanes. The other lanes are to be simulated separately: their start is
        refused, their range is too narrow, or they need too many steps. Without compiled code no
        lane is complete.
    (B,) array of int
        Steps per sample.
    """
    most = MOST_SUBSTEPS if substeps else most_substeps(len(inputs.reference))
    complete, counts = _first_steps(axis, parameters, inputs, substeps)
    complete &= counts <= most
    pending = np.flatnonzero(complete)
    while pending.size:
        # Run groups of equal steps, so that a lane with many steps does not slow down the others.
        for count in np.unique(counts[pending]):
            group = pending[counts[pending] == count]
            complete[group] = _run_into(out, axis, parameters, inputs, group, int(count), threads)
        if not visited:
            break
        pending = pending[complete[pending]]
        # Repeat lanes whose motion needs more steps, unless they have the largest number already.
        motions = {name: out[name] for name in visited}
        needed = np.empty(len(pending), dtype=np.int64)
        for place, lane in enumerate(map(int, pending)):
            motion, signals = _of_lane(motions, lane), inputs.lanes(lane).signals
            steps, _ = substeps_along(axis, parameters[lane], motion, inputs.period, signals)
            needed[place] = steps
        more = needed > counts[pending]
        complete[pending[more & (counts[pending] >= most)]] = False
        counts[pending] = np.maximum(counts[pending], np.minimum(needed, most))
        pending = pending[more & complete[pending]]
    return complete, counts


def _run_separately(
    out: dict[str, Array],
    axis: GeneratedAxis,
    parameters: Array,
    inputs: LoopInputs,
    lane: int,
    substeps: int | None,
) -> tuple[int | None, str]:
    """Simulate one lane separately, and store its signals in the lane's columns of `out`.

    The arguments are those of `_run_in_groups`; `lane` is the number of the lane.

    Returns
    -------
    int or None
        Steps per sample; None if the lane cannot start.
    str
        Reason of a failure; empty for a complete lane.
    """
    signals: dict[str, Array] = {}
    steps = None
    try:
        signals, steps, failed = settled_loop(
            axis, parameters[lane], inputs.lanes(lane), substeps=substeps, bounded=True
        )
    except AxisidError as error:
        failed = str(error)
    for name, values in out.items():
        values[:, lane] = signals.get(name, np.nan)
    return steps, failed


def _at_samples_of_log(
    out: Mapping[str, Array],
    axis: GeneratedAxis,
    parameters: Array,
    inputs: LoopInputs,
    clocks: TwoClocks,
    counts: NDArray[np.int64],
) -> dict[str, Array]:
    """Return the signals of all lanes at the samples of the log, (N, B) each.

    `out` has the signals at the law's evaluations, (M, B) each, and `counts`, (B,), the steps per
    evaluation.
    """
    sampled = [
        at_log_samples(
            axis, theta, _of_lane(out, lane), clocks, inputs.lanes(lane).signals, int(counts[lane])
        )
        for lane, theta in enumerate(parameters)
    ]
    return {name: np.column_stack([lane[name] for lane in sampled]) for name in out}


def _first_steps(
    axis: GeneratedAxis, parameters: Array, inputs: LoopInputs, substeps: int | None
) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Return True for lanes that can run in a group, and first steps per sample, (B,) each.

    A lane can run in a group if its parameters are within their bounds, its inertia is positive,
    its friction does not drive the axis, and the parameters of its friction states are valid.
    """
    has_mass, friction_holds, rates = at_rest(
        axis, parameters, inputs.start.position, inputs.first_signals
    )
    low, high = np.array([(p.lower, p.upper) for p in axis.axis_parameters]).T
    inside = ((low <= parameters) & (parameters <= high)).all(axis=1)
    has_valid_states = [not states_refusal(axis, theta) for theta in parameters]
    can_run = inside & has_mass & friction_holds & has_valid_states
    counts = steps_by_rate(axis, np.where(can_run, rates, 0.0), inputs.period)
    if substeps:
        counts = np.full_like(counts, substeps)
    return can_run, counts


def _run_into(
    out: dict[str, Array],
    axis: GeneratedAxis,
    parameters: Array,
    inputs: LoopInputs,
    group: NDArray[np.intp],
    substeps: int,
    threads: int | None,
) -> NDArray[np.bool_]:
    """Simulate a group of lanes in compiled code; return True for complete lanes, (g,).

    Without compiled code nothing is simulated, and no lane is complete.

    Parameters
    ----------
    out : dict of str to (M, B) array
        Signals of all lanes, in which those of the group are stored.
    axis : GeneratedAxis
    parameters : (B, p) array
    inputs : LoopInputs
    group : (g,) array of int
        Numbers of the lanes.
    substeps : int
        Steps per sample.
    threads : int or None
        Number of threads; None for that of the processors.
    """
    # With given gains, the code is that of the loop whose gains follow the parameters.
    code = axis if inputs.gains is None else axis.loop or axis
    library = code.native.library()
    if library is None:
        return np.zeros(len(group), dtype=bool)
    every, arguments = len(group) == len(parameters), parameters[group]
    inputs = inputs if every else inputs.lanes(group)
    if inputs.gains is not None:
        arguments = np.hstack([arguments, inputs.gains])
    by_system = hasattr(os, "sched_getaffinity")
    processors = len(os.sched_getaffinity(0)) if by_system else os.cpu_count() or 1
    status, _, signals = library.simulate_batch(
        inputs.reference,
        inputs.noise,
        inputs.injected,
        arguments,
        inputs.start,
        loop_settings(inputs, substeps),
        [*out],
        threads or processors,
        lines(axis, inputs.signals, inputs.period),
    )
    if every:
        out.update(signals)
    else:
        for name, values in signals.items():
            out[name][:, group] = values
    return np.asarray(status == 0)


def _of_lane(signals: Mapping[str, Array], lane: int) -> dict[str, Array]:
    """Return the signals of one lane, (M,) each, as contiguous arrays by name."""
    return {name: np.ascontiguousarray(values[:, lane]) for name, values in signals.items()}


def settled_substeps(axis: GeneratedAxis, parameters: Array, inputs: LoopInputs) -> int | None:
    """Return the number of steps per sample that parameters (p,) and similar parameters need.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (p,) array
    inputs : LoopInputs

    Returns
    -------
    int or None
        Steps per sample; None if the loop cannot be simulated with these parameters.
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
