"""Results of an estimator.

In: the solution of a regression. Out: `Estimate` with the `Value` of each physical parameter.
Knows nothing of methods, verdicts and presentation.
"""

from .estimate import (
    Estimate as Estimate,
    EstimateFacts as EstimateFacts,
    Inference as Inference,
    Iterate as Iterate,
    NotSimulated as NotSimulated,
)
from .estimated_values import (
    CORRECTED as CORRECTED,
    COVARIANCES as COVARIANCES,
    NamedValues as NamedValues,
    SamplingDistribution as SamplingDistribution,
    Value as Value,
    covariance_of as covariance_of,
    degrees_of_freedom_of as degrees_of_freedom_of,
    least_freedom as least_freedom,
    student_interval as student_interval,
)
from .part_of_joint_estimate import estimate_of_record as estimate_of_record
from .physical_parameters import (
    Physical as Physical,
    PhysicalByMethod as PhysicalByMethod,
    physical_parameters as physical_parameters,
)
