"""What is to be estimated from what, and what the prefilter does to it.

In: an axis, its records under their filters. Out: `Problem`, with rows, loops, visible parameters.
Knows nothing of methods and of what becomes of an estimate.
"""

from .problem import (
    ParameterAtBound as ParameterAtBound,
    Problem as Problem,
    Solver as Solver,
    jacobian_by_gain as jacobian_by_gain,
    noise_free_record as noise_free_record,
    noise_free_residuals as noise_free_residuals,
    quantisation_bias as quantisation_bias,
)
from .visibility import (
    SignalRanges as SignalRanges,
    check_has_rows as check_has_rows,
    check_time_known as check_time_known,
    shown_up_to as shown_up_to,
    typical_magnitudes as typical_magnitudes,
)
