"""The records of twins, one by one or as lanes."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.batched import RecordLanes, is_served
from axisid.estimation.choices import ROW_LOSSES, STARTS
from axisid.estimation.records import Record
from axisid.estimation.simulation import Simulation, TwinPlan, simulate_batch, twin_plan
from axisid.estimation.twins import Chain, Draws
from axisid.support.arrays import Array
from axisid.support.errors import AxisidError
from axisid.support.remedy import Note

from .plan import MonteCarloPlan

_POSITION, _SENSORS, _CONTROL, _DISTURBANCE, _OFFSET = range(5)  # each a stream of its own


@dataclass(frozen=True, slots=True, kw_only=True)
class DrawnChain:
    """The noise of one twin, whatever others there are.

    Attributes
    ----------
    chain : Chain
    seed : int
    run : int
        The number of the twin.
    """

    chain: Chain
    seed: int
    run: int

    def draws(self, stream: int) -> Draws:
        """The random numbers of a stream: a child of the seed for each run, whoever runs it."""
        child = np.random.SeedSequence(self.seed, spawn_key=(self.run, stream))
        return Draws(np.random.default_rng(child))

    def position(self, samples: int) -> Array:
        """Noise of the measured position, (samples,)."""
        return self.chain.drawn_position(self.draws(_POSITION), samples)

    def own(self, plan: TwinPlan) -> TwinPlan:
        """The plan of this twin: its encoder, where it begins, and what disturbs it."""
        chain, step, added = self.chain, self.chain.position_step, plan.added
        begin = chain.anywhere * step / 2 + chain.drawn_offset(self.draws(_OFFSET))
        if chain.disturbances:
            draws, samples = self.draws(_DISTURBANCE), len(plan.reference)
            added = {"control": chain.drawn_disturbance(draws, samples, plan.period)}
        experiment = replace(plan.experiment, resolution=step)
        return replace(plan, reference=plan.reference + begin, added=added, experiment=experiment)

    def record(self, plan: TwinPlan, loop: Simulation) -> Record:
        """What is logged of the loop of its own plan, without what disturbs it."""
        chain = self.chain
        if chain.disturbances:
            loop = replace(loop, control=loop.control - plan.added["control"])
        record = plan.record(
            loop,
            f"twin {self.run + 1} of {plan.axis.axis.name}, seed {self.seed}",
            None if chain.velocity is None else loop.velocity,
            None if chain.acceleration is None else plan.acceleration(loop),
        )
        return chain.logged(record, self.draws(_SENSORS), self.draws(_CONTROL))


def twins(plan: MonteCarloPlan, runs: Sequence[int]) -> Iterator[tuple[int, Record | Note]]:
    """The record of each run, or why there is none; made when it is asked for."""
    made = twin_plan(plan.twin)
    for run in runs:
        drawn = DrawnChain(chain=plan.noise, seed=plan.seed, run=run)
        own = drawn.own(made)
        try:
            loop = own.loop(drawn.position)
        except AxisidError as error:
            yield run, error.note
            continue
        still = _at_rest(own, loop.position)
        yield run, Note(still) if still else drawn.record(own, loop)


def _at_rest(plan: TwinPlan, position: Array) -> str:
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


def drawn_twin(plan: TwinPlan, noise: Chain, seed: int, run: int) -> Record:
    """The record of one run alone.

    Parameters
    ----------
    plan : TwinPlan
    noise : Chain
    seed, run : int
        As of a study, whose run has the same noise.

    Raises
    ------
    AxisidError
        The loop runs away.
    """
    drawn = DrawnChain(chain=noise, seed=seed, run=run)
    own = drawn.own(plan)
    return drawn.record(own, own.loop(drawn.position))


def are_lanes(plan: MonteCarloPlan) -> bool:
    """Whether runs that are not judged go side by side, whatever their company."""
    made, settings = twin_plan(plan.twin), plan.settings
    declared = plan.axis.declared.parameters
    return (
        len(plan.methods) == len(plan.regressions) == 1
        and (settings["start"], settings["loss"]) == (STARTS[0], ROW_LOSSES[0])
        and plan.axis.names == tuple(p.name for p in declared)
        and made.clocks is None
        and not (made.added or made.signals or made.axis.axis.signals)
        and made.injected is None
        and made.axis.axis.response is None
        and not made.axis.axis.drive.logs_what_acts
        # Twins differ by the noise of their position, and of their recorded control, alone.
        and replace(plan.noise, position=0.0, control=()) == Chain()
        and is_served(plan.axis, made.period, plan.methods[0])
    )


def twin_lanes(
    twin: GeneratedAxis, drawn: Sequence[DrawnChain], threads: int | None
) -> tuple[RecordLanes, Mapping[int, str]]:
    """The records of twins side by side, and why there is none of some, by lane."""
    plan = twin_plan(twin)
    samples = len(plan.reference)
    noise: Array = np.column_stack([each.position(samples) for each in drawn])
    batch = simulate_batch(
        plan.axis,
        np.tile(plan.truth, (len(drawn), 1)),
        plan.reference,
        plan.period,
        position_noise=noise,
        wanted=("position", "control"),
        threads=threads,
    )
    unsimulated = dict(batch.failures)
    for lane, position in enumerate(batch["position"].T):
        if lane not in unsimulated and (still := _at_rest(plan, position)):
            unsimulated[lane] = still
    noise += batch["position"]
    control = batch["control"]
    for lane, each in enumerate(drawn):
        if each.chain.control:
            control[:, lane] = each.chain.logged_control(
                each.draws(_CONTROL), control[:, lane], plan.period
            )
    lanes = RecordLanes(
        reference=plan.reference, position=noise, control=control, period=plan.period
    )
    return lanes, unsimulated
