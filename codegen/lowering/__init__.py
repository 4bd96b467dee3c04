"""Expressions as programs of single operations.

In: `AxisModel`. Out: `Program`.
Knows nothing of languages and compilers.
"""

from .axis_functions import axis_programs as axis_programs
from .drive import drive_force as drive_force
from .drive import drive_force_by_gain as drive_force_by_gain
from .drive import drive_force_in_mode as drive_force_in_mode
from .evaluate import evaluate as evaluate
from .feed_forward import FeedForward as FeedForward
from .feed_forward import feed_forward as feed_forward
from .law_by_gains import law_by_gains as law_by_gains
from .loop_settings import BLOCK as BLOCK
from .loop_settings import HELD_REFERENCE as HELD_REFERENCE
from .loop_settings import PASSED as PASSED
from .loop_settings import PROBE as PROBE
from .loop_settings import PROBED as PROBED
from .loop_settings import RESOLVED as RESOLVED
from .loop_settings import SIGNALS as SIGNALS
from .loop_settings import STATUSES as STATUSES
from .loop_settings import STEPS_IN_ALL as STEPS_IN_ALL
from .loop_settings import STEPS_OF_EACH as STEPS_OF_EACH
from .loop_settings import STEPS_OF_SEARCH as STEPS_OF_SEARCH
from .loop_settings import STUCK as STUCK
from .loop_settings import LoopSettings as LoopSettings
from .loop_settings import LoopStart as LoopStart
from .lower import over_time as over_time
from .plant import GAINS as GAINS
from .program import OPERATIONS as OPERATIONS
from .program import Input as Input
from .program import Operation as Operation
from .program import Output as Output
from .program import Program as Program
from .switching import demanding_term as demanding_term
