"""The closed loop in time.

In: a reference, parameters. Out: `Simulation`.
Knows nothing of filters and estimates.
"""

from .batch import BatchSimulation as BatchSimulation
from .batch import simulate_batch as simulate_batch
from .closed_loop import (
    simulate as simulate,
)
from .closed_loop import (
    simulate_estimate as simulate_estimate,
)
from .lanes import LoopInputs as LoopInputs
from .lanes import settled_substeps as settled_substeps
from .lanes import simulate_lanes as simulate_lanes
from .loop_start import law_of as law_of
from .recorded import at_law as at_law
from .reducers import LaneBlock as LaneBlock
from .runaway import allowed_distance as allowed_distance
from .simulated import SIMULATED as SIMULATED
from .simulated import Simulation as Simulation
from .simulated import logged_control as logged_control
from .simulated import measured_positions as measured_positions
from .simulated import signals_about as signals_about
from .steps import StepBudget as StepBudget
from .steps import has_constant_substeps as has_constant_substeps
from .steps import has_inertia as has_inertia
from .steps import most_substeps as most_substeps
from .steps import no_control_law as no_control_law
from .steps import substeps_at_start as substeps_at_start
from .twin import TwinPlan as TwinPlan
from .twin import twin_plan as twin_plan
from .twin import twin_record as twin_record
from .two_clocks import TwoClocks as TwoClocks
