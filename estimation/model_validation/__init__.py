"""Many identifications, or one held against other data.

In: axes, records, cut-offs. Out: `Sweep`, `Comparison`, `Validation`. Knows
nothing of how it is shown.
"""

from .comparison import (
    Candidate as Candidate,
    Comparison as Comparison,
    Criteria as Criteria,
    compare as compare,
)
from .cutoff_sweep import Sweep as Sweep, default_cutoffs as default_cutoffs, sweep as sweep
from .friction_curve import FrictionCurve as FrictionCurve, friction_curve as friction_curve
from .nested_models import NestedTest as NestedTest
from .validate import (
    validate as validate,
    validate_fit as validate_fit,
)
from .validation_result import (
    FitValidation as FitValidation,
    MethodValidation as MethodValidation,
    Validation as Validation,
)
