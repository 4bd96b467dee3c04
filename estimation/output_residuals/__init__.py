"""Errors of records' simulated outputs, for many parameter sets side by side, and their slopes.

In: axes, records, parameters. Out: `Lanes` of simulated less recorded outputs, and their slopes.
Knows nothing of how parameters are searched for.
"""

from .closed_loop_errors import (
    ClosedLoopErrors as ClosedLoopErrors,
    measured_output as measured_output,
)
from .open_loop_multiple_shooting import (
    FEWEST_IN_WINDOW as FEWEST_IN_WINDOW,
    OpenLoopErrors as OpenLoopErrors,
    default_horizon as default_horizon,
)
from .output_residuals import (
    SimulationErrors as SimulationErrors,
    jacobian_at as jacobian_at,
    record_rows as record_rows,
)
