"""Closed-loop simulation: the reference in, everything else simulated.

The control law is evaluated once a sample and held (or all the time, if it is continuous). In
between, the plant moves in one friction mode; where the velocity reaches zero the crossing is
located and the mode chosen anew. At rest the model itself decides: with the accelerations a(+) and
a(-) for both friction directions, the axis sticks if and only if ``a(+) <= 0 <= a(-)``
[Filippov1988]_. Native code runs where there is a compiler, the CasADi virtual machine elsewhere.
"""

from __future__ import annotations  # as they are written, in what help() prints

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from axisid.codegen.artefacts import GeneratedAxis, as_generated
from axisid.codegen.lowering import STATUSES, LoopSettings
from axisid.codegen.runtime import VirtualLoop
from axisid.modeling.declaration import Axis
from axisid.support.arrays import Array
from axisid.support.errors import EstimationError, UsageError

from .arguments import checked_loop
from .inputs import LoopInputs, at_log_samples, axis_of, lines, widened_distance
from .simulated import Simulation, loop_start, measured_positions
from .steps import (
    StepBudget,
    checked_rate,
    failure,
    has_constant_substeps,
    most_substeps,
    place_at,
    steps_by_rate,
    substeps_along,
    too_stiff,
)


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
    clocks, logged = inputs.clocks, inputs.logged
    if clocks is not None and axis.axis.response is not None:
        raise UsageError(
            f"the period is {clocks.log_period:g} s, the control law of axis "
            f"{axis.axis.name!r} is evaluated every {clocks.law_period:g} s, and its "
            f"drive has a {' and '.join(axis.axis.of_law_samples)}: between the "
            "law's samples such a loop is not known. Give the law's period.",
            code="loop-period",
        )
    out, steps, failed = settled_loop(
        axis, parameters, inputs, substeps=substeps, budget=budget, bounded=bounded
    )
    if failed:
        raise EstimationError(failed, code="simulation")
    if clocks is not None:
        recorded = lines(axis, inputs.signals, inputs.period)
        out = at_log_samples(axis, parameters, out, clocks, recorded, steps)
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
    settings = inputs.settings(steps)
    while True:
        left = budget.left
        budget.left -= samples * settings.substeps
        status, stopped, out = _run(axis, theta, settings, inputs, recorded)
        if substeps is None and not constant:
            visited = {name: values[:stopped] if status else values for name, values in out.items()}
            needed, at = substeps_along(axis, theta, visited, period, inputs.signals)
            most = most_substeps(samples, left)
            if needed > settings.substeps >= most:
                raise too_stiff(axis, theta, at, period, samples, left)
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
