"""The control law along a record: times of its evaluations, its control, and its initial state.

In: `Record`, axis. Out: `LawInputs`, `LoopStart`. Knows nothing of rows and parameters.
"""

from .gain_estimation import LAW_SETTLING as LAW_SETTLING, LawReplay as LawReplay
from .initial_state_of_record import (
    START_SAMPLES as START_SAMPLES,
    at_rest_misses as at_rest_misses,
    below_limit as below_limit,
    law_residual as law_residual,
    loop_starts as loop_starts,
    shifted_start as shifted_start,
    start_of_law as start_of_law,
    unlimited as unlimited,
    with_drive_memory as with_drive_memory,
)
from .initial_velocity import first_velocity as first_velocity, position_noise as position_noise
from .replay import (
    LIMIT as LIMIT,
    LawInputs as LawInputs,
    control_along as control_along,
    control_at_ticks as control_at_ticks,
    law_along as law_along,
    law_memory as law_memory,
    law_terms_along as law_terms_along,
    law_ticks as law_ticks,
    measured_velocity as measured_velocity,
    recorded_inputs as recorded_inputs,
    state_at_rest as state_at_rest,
    two_clocks as two_clocks,
    with_limit as with_limit,
)
