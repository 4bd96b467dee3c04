"""What is to be estimated from what, and what the prefilter does to it.

In: an axis, its records under their filters. Out: `Problem`, with rows, loops, visible parameters.
Knows nothing of methods and of what becomes of an estimate.
"""

from .detectability import (
    SignalRanges as SignalRanges,
    check_has_rows as check_has_rows,
    check_time_known as check_time_known,
    detection_limits as detection_limits,
    typical_magnitudes as typical_magnitudes,
)
from .parameter_at_bound import ParameterAtBound as ParameterAtBound
from .problem import Problem as Problem, Solver as Solver
