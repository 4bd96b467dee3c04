"""The estimation problem: an axis and its filtered records.

In: an axis, its records with their filters. Out: `Problem` with rows, loops and detectable
parameters. Knows nothing of methods and of the use of an estimate.
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
