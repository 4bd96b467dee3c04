"""The records of a block of twins, simulated side by side."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from axisid.estimation.records import Record
from axisid.estimation.simulation import (
    SIMULATED,
    Simulation,
    TwinPlan,
    measured_positions,
    simulate_batch,
    twin_plan,
)
from axisid.support.arrays import Array
from axisid.support.errors import AxisidError
from axisid.support.remedy import Note

from .noise import DrawnNoise, TwinNoise, resolution_of
from .plan import MonteCarloPlan


def twins(
    plan: MonteCarloPlan, runs: Sequence[int], threads: int | None = None
) -> Iterator[tuple[int, Record | Note]]:
    """The record of each run, or why there is none.

    A record is made when it is asked for: of a block the signals of the loops are held, not the
    records.
    """
    made = _measuring(twin_plan(plan.twin), plan.noise)
    drawn = [DrawnNoise(noise=plan.noise, plan=made, seed=plan.seed, run=run) for run in runs]
    # A law with a clock of its own is simulated loop by loop.
    loops = _alone(made, drawn) if made.clocks is not None else _together(made, drawn, threads)
    for each, (own, loop) in zip(drawn, loops, strict=True):
        if isinstance(loop, Note):
            yield each.run, loop
        elif still := at_rest(own, loop.position):
            yield each.run, Note(still)
        else:
            yield each.run, _record(own, each, loop, plan.noise)


def at_rest(plan: TwinPlan, position: Array) -> str:
    """Why a twin's record shows nothing: its axis stands still while its reference moves.

    Parameters
    ----------
    plan : TwinPlan
    position : (N,) array
        Of the simulated axis, without noise.
    """
    if np.ptp(position) or not np.ptp(plan.reference):
        return ""
    return (
        f"axis {plan.axis.axis.name!r} does not move with {plan.axis.describe(plan.truth)}: its "
        "friction holds whatever the drive gives. Give true values with which it moves"
    )


def drawn_twin(plan: TwinPlan, noise: TwinNoise, seed: int, run: int) -> Record:
    """The record of one run alone.

    Parameters
    ----------
    plan : TwinPlan
    noise : TwinNoise
    seed, run : int
        As of a study, whose run has the same noise.

    Raises
    ------
    AxisidError
        The loop runs away.
    """
    made = _measuring(plan, noise)
    drawn = DrawnNoise(noise=noise, plan=made, seed=seed, run=run)
    own = _own(made, drawn)
    return _record(own, drawn, own.loop(drawn.position), noise)


def _measuring(plan: TwinPlan, noise: TwinNoise) -> TwinPlan:
    """The plan with the encoder of its noise."""
    experiment = replace(plan.experiment, resolution=resolution_of(noise, plan))
    return replace(plan, experiment=experiment)


Loop = tuple[TwinPlan, Simulation | Note]


def _own(plan: TwinPlan, drawn: DrawnNoise) -> TwinPlan:
    """The plan of one twin: where it begins, and what disturbs it."""
    phase, disturbance = drawn.phase, drawn.disturbance
    moved = replace(plan, reference=plan.reference + phase) if phase else plan
    if disturbance is None:
        return moved
    return replace(moved, added={"control": disturbance})


def _alone(plan: TwinPlan, drawn: Sequence[DrawnNoise]) -> Iterator[Loop]:
    for each in drawn:
        own = _own(plan, each)
        try:
            yield own, own.loop(each.position)
        except AxisidError as error:
            yield own, error.note


def _together(plan: TwinPlan, drawn: Sequence[DrawnNoise], threads: int | None) -> Iterator[Loop]:
    samples, resolution = len(plan.reference), plan.experiment.resolution
    own = [_own(plan, each) for each in drawn]
    noise = np.column_stack([each.position(samples) for each in drawn])
    disturbed = [each.added["control"] for each in own if each.added]
    batch = simulate_batch(
        plan.axis,
        np.tile(plan.truth, (len(own), 1)),
        np.column_stack([each.reference for each in own]),
        plan.period,
        start=np.array([each.reference[0] for each in own]),
        position_noise=noise,
        injected=np.column_stack(disturbed) if disturbed else None,
        signals=plan.signals,
        resolution=resolution,
        wanted=SIMULATED,
        threads=threads,
    )
    time = plan.period * np.arange(samples, dtype=np.float64)
    recorded = tuple(np.asarray(plan.signals[s.name], dtype=float) for s in plan.axis.axis.signals)
    for lane, each in enumerate(own):
        if lane in batch.failures:
            yield each, Note(batch.failures[lane])
            continue
        signals: Mapping[str, Array] = {
            name: np.ascontiguousarray(values[:, lane]) for name, values in batch.signals.items()
        }
        measured = measured_positions(signals["position"], noise[:, lane], resolution)
        yield (
            each,
            Simulation(time=time, measured_position=measured, recorded=recorded, **signals),
        )


def _record(plan: TwinPlan, drawn: DrawnNoise, loop: Simulation, noise: TwinNoise) -> Record:
    """What is logged of a twin's loop, without what disturbs it."""
    sensed = plan.sensed(loop, drawn.sensors, noise.velocity, noise.acceleration)
    added = drawn.control
    if noise.disturbance:
        loop = replace(loop, control=loop.control - plan.added["control"])
    source = f"twin {drawn.run + 1} of {plan.axis.axis.name}, seed {drawn.seed}"
    record = plan.record(loop, source, sensed)
    if added is None or record.control is None:
        return record
    return replace(record, control=record.control + added)
