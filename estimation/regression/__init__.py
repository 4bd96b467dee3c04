"""Signals as rows, and rows solved.

In: `Signals`. Out: `Equations`, `Solution`, `Covariance`.
Knows nothing of verdicts.
"""

from .covariance import Classical as Classical
from .covariance import Covariance as Covariance
from .covariance import Hac as Hac
from .covariance import LongRun as LongRun
from .covariance import PublishedCovariance as PublishedCovariance
from .covariance import Robust as Robust
from .covariance import correlation as correlation
from .covariance import delta_method as delta_method
from .covariance import score_products as score_products
from .forms import DirectForm as DirectForm
from .forms import Equations as Equations
from .forms import Form as Form
from .forms import InverseForm as InverseForm
from .linear import QrFactors as QrFactors
from .linear import Solution as Solution
from .linear import checked_columns as checked_columns
from .linear import condition_number as condition_number
from .linear import factor as factor
from .linear import instrumental_variables as instrumental_variables
from .linear import least_squares as least_squares
from .linear import weighted_least_squares as weighted_least_squares
from .propagation import Bend as Bend
from .propagation import DrawSummary as DrawSummary
from .propagation import bend as bend
from .propagation import draw_parameters as draw_parameters
from .propagation import summarised as summarised
from .residual_tests import ResidualTests as ResidualTests
from .residual_tests import residual_tests as residual_tests
from .simulated_rows import LoopDataError as LoopDataError
from .simulated_rows import loop_reference as loop_reference
from .simulated_rows import simulated_loops as simulated_loops
from .simulated_rows import simulated_position as simulated_position
from .simulated_rows import simulated_right as simulated_right
from .spectrum import power_density as power_density
from .variable_projection import damped_step as damped_step
from .variable_projection import search_bounds as search_bounds
from .variable_projection import variable_projection as variable_projection
