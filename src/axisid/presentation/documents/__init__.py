"""Results as plain data.

In: a result. Out: what JSON holds. Knows nothing of how statistics are computed.
"""

from .comparison import written_comparison as written_comparison
from .diagnosis import NOT_EVALUATED as NOT_EVALUATED, written_diagnosis as written_diagnosis
from .identification import (
    written_estimate as written_estimate,
    written_identification as written_identification,
    written_record as written_record,
    written_request as written_request,
)
from .law_search import written_law_search as written_law_search
from .output_fit import (
    written_fit_validation as written_fit_validation,
    written_output_fit as written_output_fit,
)
from .same_members import number as number, read_as as read_as, written_as as written_as
from .sweep import written_sweep as written_sweep
from .validation import written_validation as written_validation
