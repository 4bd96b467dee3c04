"""Results as plain data.

In: a result. Out: what JSON holds. Knows nothing of how statistics are computed.
"""

from .comparison import comparison_document as comparison_document
from .diagnosis import NOT_EVALUATED as NOT_EVALUATED
from .diagnosis import diagnosis_document as diagnosis_document
from .identification import estimate_document as estimate_document
from .identification import identification_document as identification_document
from .identification import record_document as record_document
from .identification import request_document as request_document
from .law_search import law_search_document as law_search_document
from .output_fit import fit_validation_document as fit_validation_document
from .output_fit import output_fit_document as output_fit_document
from .same_members import number as number
from .same_members import read_as as read_as
from .same_members import written_as as written_as
from .sweep import sweep_document as sweep_document
from .validation import validation_document as validation_document
