"""Estimates by each method.

In: `Problem`, `Method`. Out: `Estimate` with its `Value` of each parameter.
Knows nothing of verdicts and of how it is shown.
"""

from .covariances import COVARIANCES as COVARIANCES
from .estimate import Estimate as Estimate
from .estimate import Iterate as Iterate
from .estimate import NotSimulated as NotSimulated
from .physical import Physical as Physical
from .physical import physical_parameters as physical_parameters
from .value import NamedValues as NamedValues
from .value import Value as Value
from .value import derived_value as derived_value
from .value import student_interval as student_interval
