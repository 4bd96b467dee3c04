"""Estimates as they are, held against another record, and their friction against its velocity.

In: results and records. Out: `Validation`, `FitValidation`, `FrictionCurve`. Knows nothing of how
it is shown.
"""

from .friction_curve import FrictionCurve as FrictionCurve, friction_curve as friction_curve
from .validate import (
    validate as validate,
    validate_fit as validate_fit,
)
from .validation_result import (
    FitValidation as FitValidation,
    MethodValidation as MethodValidation,
    Validation as Validation,
)
