"""Results as plain data.

In: a result. Out: what JSON holds. Knows nothing of how statistics are computed.
"""

from .comparison import comparison_dict as comparison_dict
from .diagnosis import NOT_EVALUATED as NOT_EVALUATED
from .diagnosis import diagnosis_dict as diagnosis_dict
from .identification import estimate_dict as estimate_dict
from .identification import identification_dict as identification_dict
from .identification import identification_document as identification_document
from .identification import record_dict as record_dict
from .identification import request_document as request_document
from .law_search import law_search_dict as law_search_dict
from .output_fit import fit_validation_dict as fit_validation_dict
from .output_fit import output_fit_dict as output_fit_dict
from .same_members import number as number
from .same_members import read_as as read_as
from .same_members import written_as as written_as
from .sweep import sweep_dict as sweep_dict
from .validation import validation_dict as validation_dict
