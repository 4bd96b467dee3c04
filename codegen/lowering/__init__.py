"""Expressions as programs of single operations.

In: `AxisModel`. Out: `Program`.
Knows nothing of languages and compilers.
"""

from .axis_functions import axis_programs as axis_programs, law_by_gains as law_by_gains
from .drive import (
    drive_force as drive_force,
)
from .expressions import over_time as over_time
from .feed_forward import FeedForward as FeedForward, feed_forward as feed_forward
from .loop_interface import (
    BLOCK as BLOCK,
    HELD_REFERENCE as HELD_REFERENCE,
    PHASE_PER_STEP as PHASE_PER_STEP,
    PROBE as PROBE,
    PROBED as PROBED,
    RESOLVED as RESOLVED,
    SIGNALS as SIGNALS,
    STATUSES as STATUSES,
    STEPS_IN_ALL as STEPS_IN_ALL,
    STEPS_OF_EACH as STEPS_OF_EACH,
    STEPS_OF_SEARCH as STEPS_OF_SEARCH,
    STUCK as STUCK,
    LoopSettings as LoopSettings,
    LoopStart as LoopStart,
)
from .plant import GAINS as GAINS
from .program import (
    OPERATIONS as OPERATIONS,
    Input as Input,
    Operation as Operation,
    Output as Output,
    Program as Program,
    evaluate as evaluate,
)
from .switching import stiffest_term as stiffest_term
