"""Many twins of one axis, each identified: how far estimates, intervals and checks can be believed.

In: an axis, what its twins are, how they are identified. Out: `MonteCarlo`, its numbers by run.
Knows nothing of measured records, and of how it looks.
"""

from .figures import Mean as Mean
from .figures import Share as Share
from .fits import COLOURED as COLOURED
from .fits import stated_by as stated_by
from .monte_carlo import monte_carlo as monte_carlo
from .noise import declared_chain as declared_chain
from .noise import declared_figures as declared_figures
from .plan import MonteCarloPlan as MonteCarloPlan
from .plan import noise_of as noise_of
from .plan import twin_of as twin_of
from .result import MonteCarlo as MonteCarlo
from .runs import DIRECT as DIRECT
from .runs import MODEL_ERROR as MODEL_ERROR
from .runs import PARAMETER as PARAMETER
from .runs import PHYSICAL as PHYSICAL
from .runs import Estimand as Estimand
from .runs import FailedRun as FailedRun
from .table import check_output as check_output
from .table import run_columns as run_columns
from .table import write_runs as write_runs
from .told import CheckFigures as CheckFigures
from .told import EstimandFigures as EstimandFigures
from .told import StudyFigures as StudyFigures
from .twins import drawn_twin as drawn_twin
from .twins import twins as twins
