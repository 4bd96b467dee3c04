"""A record's own loop: where its law is evaluated, what that gives there, where the loop starts.

In: `Record`, axis. Out: `LawTicks`, `LoopStart`. Knows nothing of rows and parameters.
"""

from .law_run import state_at_rest as state_at_rest
from .law_run import terms_along as terms_along
from .law_ticks import LawTicks as LawTicks
from .law_ticks import law_ticks as law_ticks
from .start import loop_starts as loop_starts
from .start_memory import first_memory as first_memory
from .start_velocity import first_velocity as first_velocity
