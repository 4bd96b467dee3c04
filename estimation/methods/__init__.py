"""Methods of estimation: from a problem to an estimate.

In: `Problem`. Out: `Method` with its `Fit`, and the `Estimate` that it makes.
Knows nothing of verdicts and of how it is shown.
"""

from .estimating import Bootstrap as Bootstrap, estimate_by as estimate_by
from .instrumental import Instruments as Instruments, StepControl as StepControl
from .method import Method as Method, scale_of as scale_of
from .methods import METHODS as METHODS, bound_record as bound_record
