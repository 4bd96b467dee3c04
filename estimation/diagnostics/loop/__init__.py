"""The recorded loop held against the declared one: force, delay, simulation.

In: an axis and a record, an estimate. Out: measured findings, each with a `Check`.
Knows nothing of what other checks find.
"""

from .alignment import Alignment as Alignment
from .alignment import alignment_check as alignment_check
from .alignment import alignment_of as alignment_of
from .alignment import declared_lateness as declared_lateness
from .alignment import estimate_delay as estimate_delay
from .force import force_check as force_check
from .force import limit_check as limit_check
from .in_time import ForceTiming as ForceTiming
from .in_time import force_timing as force_timing
from .in_time import law_in_time as law_in_time
from .in_time import timing_remedy as timing_remedy
from .measured_motion import MotionComparison as MotionComparison
from .measured_motion import compared_motion as compared_motion
from .measured_motion import compared_motions as compared_motions
from .measured_motion import motion_check as motion_check
from .simulation import following as following
