"""Simulation of the closed loop in time.

In: a reference and parameters. Out: `Simulation`.
Knows nothing of filters and estimates.
"""

from .closed_loop import (
    BatchSimulation as BatchSimulation,
    settled_substeps as settled_substeps,
    simulate as simulate,
    simulate_batch as simulate_batch,
    simulate_lanes as simulate_lanes,
    simulate_loop as simulate_loop,
)
from .integration_steps import StepBudget as StepBudget, most_substeps as most_substeps
from .loop_inputs import LoopInputs as LoopInputs, TwoClocks as TwoClocks, law_of as law_of
from .refusals import (
    at_rest as at_rest,
    gains_by_lane as gains_by_lane,
    no_control_law as no_control_law,
)
from .simulated_signals import (
    Simulation as Simulation,
    logged_control as logged_control,
    measured_positions as measured_positions,
    signals_about as signals_about,
)
from .twin import TwinPlan as TwinPlan, twin_plan as twin_plan, twin_record as twin_record
