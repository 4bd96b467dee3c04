"""Monte-Carlo studies: many twins of an axis, each identified, to assess estimates and intervals.

In: an axis, the noise and true values of its twins, the methods. Out: `MonteCarlo` with the numbers
of every run. Knows nothing of measured records and of presentation.
"""

from .drawn_twins import (
    declared_chain as declared_chain,
    declared_figures as declared_figures,
    drawn_twin as drawn_twin,
    noise_of as noise_of,
    twin_of as twin_of,
    twins as twins,
)
from .monte_carlo import monte_carlo as monte_carlo
from .plan import (
    COLOURED as COLOURED,
    MonteCarloPlan as MonteCarloPlan,
    interval_covariance as interval_covariance,
)
from .result import MonteCarlo as MonteCarlo
from .run_files import (
    check_output as check_output,
    run_columns as run_columns,
    write_runs as write_runs,
)
from .runs import (
    DIRECT as DIRECT,
    MODEL_ERROR as MODEL_ERROR,
    PARAMETER as PARAMETER,
    PHYSICAL as PHYSICAL,
    Estimand as Estimand,
    FailedRun as FailedRun,
)
from .study_statistics import (
    CheckFigures as CheckFigures,
    EstimandFigures as EstimandFigures,
    Mean as Mean,
    Share as Share,
    StudyFigures as StudyFigures,
)
