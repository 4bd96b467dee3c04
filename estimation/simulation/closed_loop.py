"""Closed-loop simulation: the reference in, everything else simulated.

The control law is evaluated once a sample and held (or all the time, if it is continuous). In
between, the plant moves in one friction mode; where the velocity reaches zero the crossing is
located and the mode chosen anew. At rest the model itself decides: with the accelerations a(+) and
a(-) for both friction directions, the axis sticks if and only if ``a(+) <= 0 <= a(-)``
[Filippov1988]_. Native code runs where there is a compiler, the CasADi virtual machine elsewhere.

Many loops run side by side, across processors; one that has to be refused, or simulated anew with
more steps or range, is simulated as if it were alone.
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
from axisid.support.errors import AxisidError, EstimationError, UsageError, quoted

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
from .loop_inputs import LoopInputs, at_log_samples, axis_of, lines
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
    """Simulate the axis under its control law, starting at rest unless a velocity is given.

    Parameters
    ----------
    axis : Axis or GeneratedAxis
        With a control law.
    parameters : (p,) array_like or mapping of str to float
        Physical parameters, SI: in the axis's order, or all of them by name.
    reference : (N,) array_like
        Commanded position.
    period : float
        Sampling period of the reference and of what is given back, s. Where it is not the control
        law's, the loop runs at the law's own: the reference runs between its samples as the law
        declares (``reference_between``), or smoothly, and the loop is sampled as the reference is.
    start : float, optional
        First position; the first reference by default.
    start_velocity : float
        First velocity.
    memory : (m,) array_like, optional
        What the drive remembers at the first sample: the law's memory in its order, then the
        controls that it has computed but not applied, the newest first; of a
        drive with a lag or a delay the forces of commands that are to act, the newest first, and
        the force that is there. By default what the law
        declares for an axis at rest.
    position_noise : (N,) array_like, optional
        Added to the position that the law measures; with two clocks held between samples.
    injected : (N,) array_like, optional
        Test signal in the drive's unit, added to what the law gives before the drive's limit and
        the law's delay; held from a sample to the next. One that is added to the reference is
        added to `reference`.
    signals : mapping of str to (N,) array_like, optional
        The recorded signals that the axis declares, by name, SI, one value for each sample of the
        reference. Between samples each is held or runs straight, as it is declared; the law and the
        force of a sampled law read them at the samples.
    resolution : float
        Of the encoder, in the coordinate's unit; the law then measures whole counts. 0 for none.
    substeps : int, optional
        Runge-Kutta steps in a sample, at most 1024; the error falls with their fourth power. By
        default a power of 2, as many as the damping, the stiffness and the speed over the length of
        a wave of the position ask for wherever the motion goes: mostly 1. Where they vary the loop
        is simulated anew until it had enough. For an axis whose force has kinks or jumps over the
        position it is the least number: each piece of a sample, from one side to the next, takes
        the steps that its own rates ask for. Friction that remembers takes implicit steps, as many
        as its bristles ask for; its internal states begin where they are declared to.

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
    """Simulate one loop from what `simulate` has checked, or from what a record has.

    Parameters
    ----------
    axis : GeneratedAxis
    parameters : (p,) array
    inputs : LoopInputs
        At the law's evaluations.
    substeps : int, optional
        As many as it needs by default.
    budget : StepBudget, optional
        That what it takes is taken off.
    bounded : bool
        Whether parameters beyond their bounds are refused, and friction that drives the axis;
        estimates may be a little beyond them.

    Raises
    ------
    UsageError, EstimationError
        As in `simulate`.
    """
    clocks, logged = inputs.clocks, inputs.log or inputs
    if clocks is not None and axis.response is not None:
        raise UsageError(
            f"the period is {clocks.log_period:g} s, the control law of axis "
            f"{axis.name!r} is evaluated every {clocks.law_period:g} s, and its "
            f"drive has a {' and '.join(axis.of_law_samples)}: between the "
            "law's samples such a loop is not known. Give the law's period.",
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
    """The loop at the evaluations of its law, its steps and range enough for wherever it went.

    Arguments as of `simulate_loop`.

    Returns
    -------
    dict of str to (M,) array
        Signals by name, not a number from where the loop ended early.
    int
        Steps in a sample.
    str
        Why and where it ended early, empty where it did not.

    Raises
    ------
    UsageError, EstimationError
        It cannot start, or takes too many steps.
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
    """Status, the sample it speaks of, and the signals: native, or in the virtual machine."""
    reference = np.ascontiguousarray(inputs.reference)
    noise, injected = (
        each if each is None else np.ascontiguousarray(each)
        for each in (inputs.noise, inputs.injected)
    )
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
    theta, period = np.ascontiguousarray(parameters), inputs.period
    inputs = replace(inputs, start=lane_starts(axis, theta, inputs), log=None)
    fixed = bool(substeps) or has_constant_substeps(axis)
    looked_at = () if fixed else visited_signals(axis)
    between = () if inputs.clocks is None else (name for name in SIGNALS if name != "control")
    shape = len(inputs.reference), len(theta)
    out = {name: np.empty(shape) for name in [*wanted, *looked_at, *between]}
    most = MOST_SUBSTEPS if substeps else most_substeps(len(inputs.reference))
    well, counts = _first_steps(axis, theta, inputs, substeps)
    well &= counts <= most
    pending = np.flatnonzero(well)
    while pending.size:
        # Lanes that ask for more steps in a sample run apart, and do not slow the others.
        for count in np.unique(counts[pending]):
            group = pending[counts[pending] == count]
            well[group] = _run_into(out, axis, theta, inputs, group, int(count), threads)
        pending = pending[well[pending] & (not fixed)]
        visited = {name: out[name] for name in looked_at}
        needed = np.array(
            [
                substeps_along(
                    axis, theta[lane], _of_lane(visited, lane), period, inputs.lanes(lane).signals
                )[0]
                for lane in map(int, pending)
            ],
            dtype=np.int64,
        )
        more = needed > counts[pending]
        well[pending[more & (counts[pending] >= most)]] = False
        counts[pending] = np.maximum(counts[pending], np.minimum(needed, most))
        pending = pending[more & well[pending]]
    # What no lane beside others can be told of is done alone: a start that is refused, a range that
    # is too narrow, steps that are too many, and all of them where nothing is compiled.
    failures: dict[int, str] = {}
    for lane in map(int, np.flatnonzero(~well)):
        signals = dict[str, Array]()
        try:
            signals, counts[lane], failures[lane] = settled_loop(
                axis, theta[lane], inputs.lanes(lane), substeps=substeps, bounded=True
            )
        except AxisidError as error:
            failures[lane] = str(error)
        for name, values in out.items():
            values[:, lane] = signals.get(name, np.nan)
    if inputs.clocks is not None:
        sampled = [
            at_log_samples(
                axis,
                theta[lane],
                _of_lane(out, lane),
                inputs.clocks,
                inputs.lanes(lane).signals,
                int(counts[lane]),
            )
            for lane in range(len(theta))
        ]
        out = {name: np.column_stack([lane[name] for lane in sampled]) for name in out}
    return BatchSimulation(
        signals={name: out[name] for name in wanted},
        failures={lane: why for lane, why in failures.items() if why},
    )


def _first_steps(
    axis: GeneratedAxis, parameters: Array, inputs: LoopInputs, substeps: int | None
) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Which lanes can start beside others, and the steps of each at first."""
    has_mass, friction_holds, rates = at_rest(
        axis, parameters, inputs.start.position, inputs.first_signals
    )
    low, high = np.array([(p.lower, p.upper) for p in axis.axis_parameters]).T
    inside = ((low <= parameters) & (parameters <= high)).all(axis=1)
    remembers = [not states_refusal(axis, own) for own in parameters]
    well = inside & has_mass & friction_holds & remembers
    counts = steps_by_rate(axis, np.where(well, rates, 0.0), inputs.period)
    return well, np.full_like(counts, substeps) if substeps else counts


def _run_into(
    out: dict[str, Array],
    axis: GeneratedAxis,
    parameters: Array,
    inputs: LoopInputs,
    group: NDArray[np.intp],
    substeps: int,
    threads: int | None,
) -> NDArray[np.bool_]:
    """Simulate a group of lanes into the signals of all; which of them came to the end."""
    code = axis if inputs.gains is None else axis.loop or axis
    library = code.native.library()
    if library is None:
        return np.zeros(len(group), dtype=bool)
    every, theta = len(group) == len(parameters), parameters[group]
    inputs = inputs if every else inputs.lanes(group)
    by_system = hasattr(os, "sched_getaffinity")
    processors = len(os.sched_getaffinity(0)) if by_system else os.cpu_count() or 1
    status, _, signals = library.simulate_batch(
        inputs.reference,
        inputs.noise,
        inputs.injected,
        theta if inputs.gains is None else np.hstack([theta, inputs.gains]),
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
    return {name: np.ascontiguousarray(values[:, lane]) for name, values in signals.items()}


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
