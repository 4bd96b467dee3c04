"""Results read back from the files that they were written to.

In: a file of JSON. Out: results that are summarised, drawn, validated and exported like live ones.
Knows nothing of how statistics are computed.
"""

from .estimate import SavedEstimate as SavedEstimate, estimate_facts as estimate_facts
from .file import load_result as load_result
from .fitted_axis import FittedAxis as FittedAxis, fitted_axis as fitted_axis
from .identification import (
    SavedIdentification as SavedIdentification,
    identification_facts as identification_facts,
)
from .output_fit import (
    SavedFitValidation as SavedFitValidation,
    SavedMonteCarlo as SavedMonteCarlo,
    SavedOutputFit as SavedOutputFit,
)
from .result_comparison import (
    compare_results as compare_results,
    result_comparison_document as result_comparison_document,
)
