"""Methods of estimation: from a problem to an estimate.

In: `Problem`. Out: `Method` with its `Fit`, and the `Estimate` that it makes.
Knows nothing of verdicts, nor of presentation.
"""

from .estimating import estimate_by as estimate_by
from .instrumental import Instruments as Instruments, StepControl as StepControl
from .least_squares import robust_scale as robust_scale
from .method import Method as Method
from .methods import METHODS as METHODS
from .parametric_bootstrap import Bootstrap as Bootstrap
from .reversals_of_simulated_loop import filtered_record as filtered_record
