"""Results as plain data, and read back.

In: a result, a file. Out: what JSON holds. Knows nothing of how statistics are computed.
"""

from .comparison import comparison_dict as comparison_dict
from .fitted import FittedAxis as FittedAxis
from .fitted import fitted_axis as fitted_axis
from .identification import estimate_dict as estimate_dict
from .identification import identification_dict as identification_dict
from .identification import record_dict as record_dict
from .result_comparison import ResultComparison as ResultComparison
from .result_comparison import compare_results as compare_results
from .result_comparison import result_comparison_document as result_comparison_document
from .saved_estimate import SavedEstimate as SavedEstimate
from .saved_file import load_result as load_result
from .saved_result import SavedIdentification as SavedIdentification
from .saved_result import SavedPhysical as SavedPhysical
from .saved_result import SavedRecord as SavedRecord
from .saved_text import saved_document as saved_document
from .saved_text import saved_estimate_document as saved_estimate_document
from .saved_text import saved_plot as saved_plot
from .saved_text import saved_repeats_plot as saved_repeats_plot
from .stream import stream_dict as stream_dict
from .sweep import sweep_dict as sweep_dict
from .validation import validation_dict as validation_dict
