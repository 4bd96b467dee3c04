"""What an estimator returns.

In: the solution of a regression. Out: `Estimate` with its `Value` of each parameter, physical ones.
Knows nothing of methods, of verdicts and of how it is shown.
"""

from .covariances import COVARIANCES as COVARIANCES
from .estimate import Estimate as Estimate
from .fitted import FittedParameters as FittedParameters
from .hausman import NOTICEABLE as NOTICEABLE
from .hausman import HausmanTest as HausmanTest
from .hausman import hausman as hausman
from .hausman import parted as parted
from .inference import Inference as Inference
from .iterate import Iterate as Iterate
from .iterate import NotSimulated as NotSimulated
from .part import part_of as part_of
from .physical import Physical as Physical
from .physical import PhysicalByMethod as PhysicalByMethod
from .physical import physical_parameters as physical_parameters
from .value import CORRECTED as CORRECTED
from .value import NamedValues as NamedValues
from .value import Value as Value
from .value import derived_value as derived_value
from .value import few_rows as few_rows
from .value import student_interval as student_interval
from .value import value_with_interval as value_with_interval
