"""Estimates by each method.

In: `Problem`, `Method`. Out: `Estimate` with its `Value` of each parameter.
Knows nothing of verdicts and of how it is shown.
"""

from .bound_record import bound_record as bound_record
from .covariances import COVARIANCES as COVARIANCES
from .estimate import Estimate as Estimate
from .estimate import Iterate as Iterate
from .estimate import NotSimulated as NotSimulated
from .estimating import estimate_by as estimate_by
from .filter_bias import noise_free_record as noise_free_record
from .instrumental import Instruments as Instruments
from .method import Fit as Fit
from .method import Method as Method
from .methods import METHODS as METHODS
from .part import part_of as part_of
from .physical import Physical as Physical
from .physical import physical_parameters as physical_parameters
from .problem import Problem as Problem
from .value import Named as Named
from .value import Value as Value
from .value import derived_value as derived_value
from .value import student_interval as student_interval
from .visibility import Reach as Reach
from .visibility import check_identifiable as check_identifiable
from .visibility import check_shown as check_shown
from .visibility import natural_sizes as natural_sizes
