"""Many identifications, or one held against other data.

In: axes, records, cut-offs. Out: `Sweep`, `Comparison`, `Validation`, `DriveTiming`. Knows
nothing of how it is shown.
"""

from .candidate import Candidate as Candidate
from .candidate import ParameterCheck as ParameterCheck
from .comparison import Comparison as Comparison
from .comparison import compare as compare
from .drive_timing import DriveTiming as DriveTiming
from .drive_timing import estimate_drive_timing as estimate_drive_timing
from .friction_curve import Friction as Friction
from .friction_curve import friction as friction
from .held_out import HeldOut as HeldOut
from .nesting import NestedTest as NestedTest
from .sweep import Sweep as Sweep
from .sweep import default_cutoffs as default_cutoffs
from .sweep import sweep as sweep
from .validate import validate as validate
from .validation import MethodValidation as MethodValidation
from .validation import Validation as Validation
