"""Twins that are identified side by side: of an axis and a noise that lanes serve."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from axisid.estimation.batched import LaneEstimates, RecordLanes, identify_lanes, is_served
from axisid.estimation.choices import ROW_LOSSES, STARTS
from axisid.estimation.simulation import TwinPlan, simulate_batch, twin_plan
from axisid.estimation.twins import Chain
from axisid.support.arrays import Array

from .plan import MonteCarloPlan
from .twins import CONTROL, DrawnChain, at_rest


def runs_in_lanes(plan: MonteCarloPlan, start: int, stop: int) -> range:
    """Which of the runs from `start` to before `stop` go side by side: none, or those not judged.

    Whether a run does depends on the plan and on its number alone.
    """
    return range(max(start, plan.checks), stop) if _are_lanes(plan) else range(stop, stop)


def identified_lanes(
    plan: MonteCarloPlan, runs: range, threads: int | None
) -> tuple[LaneEstimates, Mapping[int, str]]:
    """Simulate and identify runs side by side, a lane for each.

    Returns
    -------
    LaneEstimates, mapping of int to str
        The latter why, of lanes whose twin could not be simulated.
    """
    made = twin_plan(plan.twin)
    drawn = [DrawnChain(chain=plan.noise, seed=plan.seed, run=run) for run in runs]
    lanes, unsimulated = _simulated(made, drawn, threads)
    estimates = identify_lanes(
        plan.axis,
        lanes,
        plan.methods[0],
        plan.prefilter,
        lags=plan.settings["lags"],
    )
    return estimates, unsimulated


def _are_lanes(plan: MonteCarloPlan) -> bool:
    made, settings = twin_plan(plan.twin), plan.settings
    declared = plan.axis.declared.parameters
    lanes = RecordLanes(
        reference=made.reference[:2],
        position=np.zeros((2, 1)),
        control=np.zeros((2, 1)),
        period=made.period,
        resolution=plan.noise.position_step,
    )
    return (
        len(plan.methods) == len(plan.regressions) == 1
        and (settings["start"], settings["loss"]) == (STARTS[0], ROW_LOSSES[0])
        and plan.axis.names == tuple(p.name for p in declared)
        and made.clocks is None
        and not (made.added or made.signals or made.axis.axis.signals)
        and made.injected is None
        and made.axis.axis.response is None
        and not made.axis.axis.drive.logs_what_acts
        and _is_of_position(plan.noise)
        and is_served(plan.axis, lanes, plan.methods[0], {})
    )


def _is_of_position(noise: Chain) -> bool:
    """Whether twins differ by the noise of their position, and of their recorded control, alone."""
    return replace(noise, position=0.0, position_step=0.0, control=()) == Chain()


def _simulated(
    plan: TwinPlan, drawn: list[DrawnChain], threads: int | None
) -> tuple[RecordLanes, dict[int, str]]:
    """The records of twins as lanes, and why there is none of some."""
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
        if lane not in unsimulated and (still := at_rest(plan, position)):
            unsimulated[lane] = still
    noise += batch["position"]
    control = batch["control"]
    for lane, each in enumerate(drawn):
        if each.chain.control:
            control[:, lane] = each.chain.logged_control(
                each.draws(CONTROL), control[:, lane], plan.period
            )
    lanes = RecordLanes(
        reference=plan.reference, position=noise, control=control, period=plan.period
    )
    return lanes, unsimulated
