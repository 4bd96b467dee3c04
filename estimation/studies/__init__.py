"""Many identifications, or one held against other data.

In: axes, records, cut-offs. Out: `Sweep`, `Comparison`, `Validation`, `DriveTiming`. Knows
nothing of how it is shown.
"""

from .candidate import Candidate as Candidate
from .candidate import ParameterCheck as ParameterCheck
from .comparison import Comparison as Comparison
from .comparison import compare as compare
from .friction_curve import Friction as Friction
from .friction_curve import friction as friction
from .held_out import HeldOut as HeldOut
from .nesting import NestedTest as NestedTest
from .sweep import Sweep as Sweep
from .sweep import default_cutoffs as default_cutoffs
from .sweep import sweep as sweep
from .validate import validate as validate
from .validate_fit import FitValidation as FitValidation
from .validate_fit import validate_fit as validate_fit
from .validation import MethodValidation as MethodValidation
from .validation import Validation as Validation
