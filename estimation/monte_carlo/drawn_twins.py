"""The twins of a study: their noise, true values, and simulated records or lanes."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from axisid.codegen.generated_axes import GeneratedAxis, build
from axisid.estimation.batched import RecordLanes, is_served
from axisid.estimation.choices import INSTRUMENT_STARTS, ROW_LOSSES
from axisid.estimation.noise_models import AntitheticDraws, Autoregressions, Chain
from axisid.estimation.records import Record
from axisid.estimation.simulation import TwinPlan, simulate_batch, twin_plan
from axisid.modeling.declaration import Experiment
from axisid.support.arrays import Array
from axisid.support.checks import by_name
from axisid.support.errors import AxisidError, EstimationError, ModelError, UsageError
from axisid.support.wording import quoted

from .plan import MonteCarloPlan


def noise_of(given: object, twin: GeneratedAxis, runs: object = 1) -> Chain:
    """Return the checked noise of an axis's twins.

    Parameters
    ----------
    given : Chain or None
        Noise as the user gave it; None for that of the experiment.
    twin : GeneratedAxis
        Axis to simulate.
    runs : int
        Number of twins.

    Raises
    ------
    UsageError
        The noise is no Chain; its motions begin at a random place within an encoder step, but it
        has no encoder step; several twins would be equal; or the noise has jitter or position noise
        that the law does not read, which twins of an experiment do not have.
    ModelError
        The noise has disturbances, and the drive logs the acting control.
    """
    noise = Chain.of_experiment(twin.axis) if given is None else given
    if not isinstance(noise, Chain):
        raise UsageError(
            f"the noise is {quoted(noise)}. Give a Chain, or omit noise.",
            code="noise",
        )
    # Condition, type of the error, and the sentence after "the twins of AXIS".
    for is_wrong, kind, text in (
        (
            noise.jitter or not noise.is_measured_by_law,
            UsageError,
            "are sampled evenly and their law reads the logged position. Give noise without "
            "jitter, with is_measured_by_law=True",
        ),
        (
            noise.disturbances and twin.axis.drive.logs_what_acts,
            ModelError,
            "log the acting control, which includes a disturbance. Omit the disturbance, or "
            "declare a drive that logs its command",
        ),
        (
            noise.anywhere and not noise.position_step,
            UsageError,
            "start at a random place within an encoder step, but their encoder has no resolution. "
            "Give a resolution, or omit the random start",
        ),
        (
            runs != 1 and not noise.is_random,
            UsageError,
            "would all be the same, because their noise is not random. Give random noise, only one "
            "run, or an encoder resolution with a random start",
        ),
    ):
        if is_wrong:
            raise kind(f"the twins of {twin.axis.name!r} {text}.", code="study")
    return noise.likeliest


def declared_chain(
    chain: Chain,
    *,
    position: float | None = None,
    resolution: float | None = None,
    anywhere: bool = False,
    velocity: float | None = None,
    acceleration: float | None = None,
    control: float | None = None,
    disturbance: float | None = None,
    correlation_time: float | None = None,
) -> Chain:
    """Return the noise of an experiment with given figures replaced.

    Parameters
    ----------
    chain : Chain
        Noise of the experiment, as from `Chain.of_experiment`.
    position, resolution : float, optional
        Noise and step of the encoder, in the coordinate's unit; the chain's by default.
    anywhere, velocity, acceleration
        As in `Chain`.
    control, disturbance : float, optional
        Standard deviations in the drive's unit; none by default.
    correlation_time : float, optional
        Correlation time of control noise and disturbance, s; white by default.
    """

    def coloured(deviation: float | None) -> Autoregressions:
        """Return one autoregression with a standard deviation; none for 0 or None."""
        if not deviation:
            return ()
        return ((correlation_time or 0.0, deviation),)

    return replace(
        chain,
        position=chain.position if position is None else position,
        position_step=chain.position_step if resolution is None else resolution,
        anywhere=anywhere,
        velocity=velocity,
        acceleration=acceleration,
        control=coloured(control),
        disturbances=coloured(disturbance),
    )


def declared_figures(chain: Chain) -> dict[str, float | bool | None]:
    """Return the figures of a noise model (`Chain`) by the names of `declared_chain`'s arguments.

    Several autoregressions are summarised by the standard deviation of their sum and by the longest
    correlation time.
    """
    control = math.hypot(*(deviation for _, deviation in chain.control))
    disturbance = math.hypot(*(deviation for _, deviation in chain.disturbances))
    times = [time for time, _ in (*chain.control, *chain.disturbances)]
    return {
        "position": chain.position,
        "resolution": chain.position_step,
        "anywhere": chain.anywhere,
        "velocity": chain.velocity,
        "acceleration": chain.acceleration,
        "control": control,
        "disturbance": disturbance,
        "correlation_time": max(times, default=0.0),
    }


def twin_of(axis: GeneratedAxis, truth: object, moves: object) -> GeneratedAxis:
    """Return the axis with other true values or another motion; unchanged without both.

    Parameters
    ----------
    axis : GeneratedAxis
    truth : mapping of str to float
        Values that replace those of the experiment.
    moves : sequence of Move or None
        Moves that replace those of the experiment; None for those of the experiment.

    Raises
    ------
    UsageError
        The arguments are not valid, or a name is not that of a parameter.
    """
    declared = axis.declared
    before = declared.experiment
    if moves is None and (before is None or not truth):
        return axis  # an axis without an experiment is refused later
    known = {} if before is None else before.truth
    changed: dict[str, Any] = {"truth": {**known, **by_name(truth, "true values")}}
    if moves is not None:
        changed["moves"] = moves
    try:
        given = Experiment(**changed) if before is None else replace(before, **changed)
        declared = replace(declared, experiment=given)
    except ModelError as error:
        raise UsageError(str(error), code=error.code) from error
    return build(declared, native=axis.native.enabled)


_POSITION, _SENSORS, _CONTROL, _DISTURBANCE, _OFFSET = range(5)  # separate random streams


def _draws(seed: int, run: int, stream: int) -> AntitheticDraws:
    """Return the random numbers of one source of noise (`stream`) of a run.

    They depend on the seed, the number of the run, and the stream only.
    """
    return AntitheticDraws(
        np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(run, stream)))
    )


def twins(plan: MonteCarloPlan, runs: Sequence[int]) -> Iterator[tuple[int, Record | str]]:
    """Yield the number of each run with its simulated record.

    If a simulation fails, the reason, as text, is yielded instead of the record.
    """
    plan_of_twin = twin_plan(plan.twin)
    for run in runs:
        try:
            yield run, drawn_twin(plan_of_twin, plan.noise, plan.seed, run)
        except AxisidError as error:
            yield run, str(error)


def drawn_twin(plan: TwinPlan, noise: Chain, seed: int, run: int) -> Record:
    """Return the simulated record of one run.

    Parameters
    ----------
    plan : TwinPlan
        Inputs of the simulated loop.
    noise : Chain
        Noise of the record.
    seed, run : int
        Seed of the study, and number of the run, from 0. The same two give the same noise.

    Raises
    ------
    AxisidError
        The loop diverges, or the axis is at standstill while its reference moves.
    """
    draws, step = partial(_draws, seed, run), noise.position_step
    # The motion begins at a random place within an encoder step, if the noise has such a start.
    begin = noise.anywhere * step / 2 + noise.drawn_offset(draws(_OFFSET))
    experiment = replace(plan.experiment, resolution=step)
    undisturbed = replace(plan, reference=plan.reference + begin, experiment=experiment)
    disturbed = undisturbed
    if noise.disturbances:
        disturbance = noise.drawn_disturbance(draws(_DISTURBANCE), len(plan.reference), plan.period)
        disturbed = replace(undisturbed, injected=disturbance, injected_at="control")

    def position_noise(count: int) -> Array:
        """Return the noise of the position at the first samples, (count,)."""
        return noise.position * draws(_POSITION).normal(count)

    loop = disturbed.loop(position_noise)
    reason = _reason_of_standstill(undisturbed, loop.position)
    if reason:
        raise EstimationError(reason, code="twin")
    if noise.disturbances:  # disturbances are not logged
        loop = replace(loop, control=loop.control - disturbance)
    # Velocity and acceleration are logged only if the noise model has their noise.
    velocity = acceleration = None
    if noise.velocity is not None:
        velocity = loop.velocity
    if noise.acceleration is not None:
        acceleration = undisturbed.acceleration(loop)
    source = f"twin {run + 1} of {plan.axis.name}, seed {seed}"
    record = undisturbed.record(loop, source, velocity, acceleration)
    return record.with_values(**noise.logged(record, draws(_SENSORS), draws(_CONTROL)))


def _reason_of_standstill(plan: TwinPlan, position: Array) -> str:
    """Return the reason why a twin does not move, as a sentence; empty if it moves.

    `position`, (N,), is its position without noise. A constant reference needs no motion.
    """
    if np.ptp(position) or not np.ptp(plan.reference):
        return ""
    return (
        f"axis {plan.axis.name!r} does not move with {plan.axis.describe(plan.truth)}: its "
        "friction is larger than the force of the drive. Give true values with which the axis "
        "moves."
    )


def are_lanes(plan: MonteCarloPlan) -> bool:
    """Return True if runs without a verdict can be simulated and identified in parallel lanes."""
    twin, settings = twin_plan(plan.twin), plan.settings
    return (
        # One method of `identify` with default settings, and no base parameters.
        len(plan.methods) == len(plan.regressions) == 1
        and (settings["start"], settings["loss"]) == (INSTRUMENT_STARTS[0], ROW_LOSSES[0])
        and plan.axis.names == tuple(p.name for p in plan.axis.declared.parameters)
        # A loop that the batched simulation can run.
        and twin.clocks is None
        and not (twin.signals or twin.axis.signals)
        and twin.axis.response is None
        and not twin.axis.drive.logs_what_acts
        # Twins that differ only by the noise of their position and of their logged control.
        and replace(plan.noise, position=0.0, control=()) == Chain()
        and is_served(plan.axis, twin.period, plan.methods[0])
    )


def twin_lanes(
    twin: GeneratedAxis, chain: Chain, seed: int, runs: Sequence[int], threads: int | None
) -> tuple[RecordLanes, Mapping[int, str]]:
    """Return simulated records of runs, one lane for each, and reasons of failures by lane.

    Parameters
    ----------
    twin : GeneratedAxis
    chain : Chain
        Noise: white noise of the position, and noise of the logged control.
    seed : int
    runs : sequence of int
        Numbers of the runs.
    threads : int or None
        Threads of the simulation; None for the default of `simulate_batch`.

    Returns
    -------
    RecordLanes
        Reference, positions, controls and period of the records.
    mapping of int to str
        Reasons why the simulation of a lane failed, by number of the lane.
    """
    plan = twin_plan(twin)
    samples = len(plan.reference)
    drawn = [_draws(seed, run, _POSITION).normal(samples) for run in runs]
    noise = chain.position * np.column_stack(drawn)
    batch = simulate_batch(
        plan.axis,
        np.tile(plan.truth, (len(runs), 1)),
        plan.reference,
        plan.period,
        position_noise=noise,
        wanted=("position", "control"),
        threads=threads,
    )
    unsimulated = dict(batch.failures)
    for lane, position in enumerate(batch["position"].T):
        if lane in unsimulated:
            continue
        reason = _reason_of_standstill(plan, position)
        if reason:
            unsimulated[lane] = reason
    # The logged signals: position and control with their noise.
    logged_position = noise
    logged_position += batch["position"]
    control = batch["control"]
    if chain.control:
        for lane, run in enumerate(runs):
            drawn_control = _draws(seed, run, _CONTROL)
            control[:, lane] = chain.logged_control(drawn_control, control[:, lane], plan.period)
    lanes = RecordLanes(
        reference=plan.reference, position=logged_position, control=control, period=plan.period
    )
    return lanes, unsimulated
