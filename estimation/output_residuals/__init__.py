"""Residuals of simulated outputs for many parameter sets in parallel, and their Jacobian.

In: axes, records, parameters. Out: `BatchResiduals`, simulated minus recorded outputs, and their
derivatives. Knows nothing of search algorithms.
"""

from .closed_loop_residuals import (
    ClosedLoopResiduals as ClosedLoopResiduals,
    measured_output as measured_output,
)
from .open_loop_multiple_shooting import (
    FEWEST_IN_WINDOW as FEWEST_IN_WINDOW,
    MultipleShootingResiduals as MultipleShootingResiduals,
    default_horizon as default_horizon,
)
from .output_residuals import (
    OutputResiduals as OutputResiduals,
    jacobian_at as jacobian_at,
    record_rows as record_rows,
)
