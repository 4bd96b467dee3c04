"""What is to be estimated from what, and what the prefilter does to it.

In: an axis, its records under their filters. Out: `Problem`, with rows, loops, visible parameters.
Knows nothing of methods and of what becomes of an estimate.
"""

from .held import Held as Held
from .noise_free import NoiseFree as NoiseFree
from .noise_free import noise_free as noise_free
from .noise_free import noise_free_record as noise_free_record
from .noise_free import slopes_by_gain as slopes_by_gain
from .problem import Problem as Problem
from .rounded_position import moved_by_rounding as moved_by_rounding
from .rounded_position import position_step as position_step
from .solver import ByInstruments as ByInstruments
from .solver import ByLeastSquares as ByLeastSquares
from .solver import ByOutputError as ByOutputError
from .solver import Solver as Solver
from .solver import by_least_squares as by_least_squares
from .visibility import Reach as Reach
from .visibility import check_has_rows as check_has_rows
from .visibility import check_time_known as check_time_known
from .visibility import natural_sizes as natural_sizes
from .visibility import shown_up_to as shown_up_to
