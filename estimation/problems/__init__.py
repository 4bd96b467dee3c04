"""What is to be estimated from what, and what the prefilter does to it.

In: an axis, its records under their filters. Out: `Problem`, with rows, loops, visible parameters.
Knows nothing of methods and of what becomes of an estimate.
"""

from .noise_free import (
    NoiseFree as NoiseFree,
    noise_free as noise_free,
    noise_free_record as noise_free_record,
    slopes_by_gain as slopes_by_gain,
)
from .problem import Held as Held, Problem as Problem
from .rounded_position import moved_by_rounding as moved_by_rounding, position_step as position_step
from .solver import (
    ByInstruments as ByInstruments,
    ByLeastSquares as ByLeastSquares,
    ByOutputError as ByOutputError,
    Solver as Solver,
    by_least_squares as by_least_squares,
)
from .visibility import (
    Reach as Reach,
    check_has_rows as check_has_rows,
    check_time_known as check_time_known,
    natural_sizes as natural_sizes,
    shown_up_to as shown_up_to,
)
