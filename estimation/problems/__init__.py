"""What is to be estimated from what, and what the prefilter does to it.

In: an axis, its records under their filters. Out: `Problem`, with rows, loops, visible parameters.
Knows nothing of methods and of what becomes of an estimate.
"""

from .even_times import EvenTimes as EvenTimes
from .even_times import at_even_times as at_even_times
from .even_times import evenly as evenly
from .even_times import jitter_of as jitter_of
from .filter_bias import Answer as Answer
from .filter_bias import NoiseFree as NoiseFree
from .filter_bias import confirmed as confirmed
from .filter_bias import encoder_error as encoder_error
from .filter_bias import is_not_in as is_not_in
from .filter_bias import loop_record as loop_record
from .filter_bias import noise_free as noise_free
from .filter_bias import noise_free_at as noise_free_at
from .filter_bias import noise_free_record as noise_free_record
from .filter_bias import settled_noise_free as settled_noise_free
from .filter_bias import settled_together as settled_together
from .filter_bias import settling as settling
from .filter_bias import slopes_by_gain as slopes_by_gain
from .following_bias import noise_free_following as noise_free_following
from .following_bias import white_part as white_part
from .held import Held as Held
from .noisy_loop import record_as_measured as record_as_measured
from .noisy_loop import rows_as_measured as rows_as_measured
from .noisy_loop import with_loop_noise as with_loop_noise
from .problem import Problem as Problem
from .problem import adding as adding
from .rounded_control import ControlSteps as ControlSteps
from .rounded_control import control_error as control_error
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
