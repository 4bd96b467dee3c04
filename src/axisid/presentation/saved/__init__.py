"""Results read back from the files that they were written to.

In: a file of JSON. Out: results that are summarised, drawn, validated and exported like live ones.
Knows nothing of how statistics are computed.
"""

from .estimate import SavedEstimate as SavedEstimate
from .file import load_result as load_result
from .fitted_axis import FittedAxis as FittedAxis, fitted_axis as fitted_axis
from .identification import SavedIdentification as SavedIdentification
from .output_fit import (
    SavedFitValidation as SavedFitValidation,
    SavedOutputFit as SavedOutputFit,
    saved_fit_document as saved_fit_document,
)
from .result_comparison import (
    ResultComparison as ResultComparison,
    compare_results as compare_results,
    result_comparison_document as result_comparison_document,
)
from .study import SavedMonteCarlo as SavedMonteCarlo
from .views import (
    Like as Like,
    saved_document as saved_document,
    saved_estimate_document as saved_estimate_document,
    saved_plot as saved_plot,
    saved_repeats_plot as saved_repeats_plot,
)
