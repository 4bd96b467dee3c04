"""Validation of estimates on another record, and the friction of a record by velocity.

In: results and records. Out: `Validation`, `FitValidation`, `FrictionCurve`. Knows nothing of
presentation.
"""

from .friction_curve import FrictionCurve as FrictionCurve, friction_curve as friction_curve
from .validate import (
    validate as validate,
    validate_fit as validate_fit,
)
from .validation_findings import (
    DoubtfulTimeBase as DoubtfulTimeBase,
    EquationErrorOnRecord as EquationErrorOnRecord,
    EstimatesDoNotHold as EstimatesDoNotHold,
    EstimatesHold as EstimatesHold,
    KnownSamples as KnownSamples,
    NoSimulation as NoSimulation,
    OutputOnRecord as OutputOnRecord,
    ReestimatedParameters as ReestimatedParameters,
    SamplePeriods as SamplePeriods,
    SimulationOnRecord as SimulationOnRecord,
)
from .validation_result import (
    FitValidation as FitValidation,
    MethodValidation as MethodValidation,
    Validation as Validation,
)
