"""A record's own loop: where its law is evaluated, what that gives there, where the loop starts.

In: `Record`, axis. Out: `LawInputs`, `LoopStart`. Knows nothing of rows and parameters.
"""

from .gain_estimation import LAW_SETTLING as LAW_SETTLING, LawAlong as LawAlong
from .law_inputs import (
    LawInputs as LawInputs,
    as_logged as as_logged,
    cached_per_record as cached_per_record,
    control_along as control_along,
    control_at_ticks as control_at_ticks,
    hides_command as hides_command,
    late_in_log as late_in_log,
    law_along as law_along,
    law_memory as law_memory,
    law_terms_along as law_terms_along,
    law_ticks as law_ticks,
    least_step as least_step,
    limit_in_log as limit_in_log,
    measured_velocity as measured_velocity,
    recorded_inputs as recorded_inputs,
    state_at_rest as state_at_rest,
    two_clocks as two_clocks,
    with_drive as with_drive,
)
from .start import (
    START_SAMPLES as START_SAMPLES,
    at_rest_misses as at_rest_misses,
    below_limit as below_limit,
    first_velocity as first_velocity,
    law_residual as law_residual,
    loop_starts as loop_starts,
    position_noise as position_noise,
    shifted_start as shifted_start,
    start_of_law as start_of_law,
    unlimited as unlimited,
)
