"""A record's own loop: where its law is evaluated, what that gives there, where the loop starts.

In: `Record`, axis. Out: `LawTicks`, `LoopStart`. Knows nothing of rows and parameters.
"""

from .as_logged import as_logged as as_logged
from .as_logged import hides_command as hides_command
from .as_logged import late_in_log as late_in_log
from .as_logged import limit_in_log as limit_in_log
from .as_logged import with_drive as with_drive
from .clocks import two_clocks as two_clocks
from .kept import KeptByRecord as KeptByRecord
from .law_gains import Compared as Compared
from .law_gains import LawAlong as LawAlong
from .law_gains import LawPoint as LawPoint
from .law_run import applied_terms as applied_terms
from .law_run import control_along as control_along
from .law_run import control_at_ticks as control_at_ticks
from .law_run import law_memory as law_memory
from .law_run import state_at_rest as state_at_rest
from .law_run import terms_along as terms_along
from .law_ticks import LawTicks as LawTicks
from .law_ticks import between as between
from .law_ticks import law_ticks as law_ticks
from .law_ticks import measured_velocity as measured_velocity
from .start import START_SAMPLES as START_SAMPLES
from .start import at_rest_misses as at_rest_misses
from .start import below_limit as below_limit
from .start import first_velocities as first_velocities
from .start import first_velocity as first_velocity
from .start import loop_starts as loop_starts
from .start import moved_start as moved_start
from .start import noise_along as noise_along
from .start import position_noise as position_noise
from .start import start_of_law as start_of_law
from .start import unlimited as unlimited
