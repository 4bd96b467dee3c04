"""Results as plain data.

In: a result. Out: what JSON holds. Knows nothing of how statistics are computed.
"""

from .diagnosis import NOT_EVALUATED as NOT_EVALUATED, written_diagnosis as written_diagnosis
from .identification import (
    written_estimate as written_estimate,
    written_identification as written_identification,
    written_record as written_record,
)
from .same_members import number as number, read_as as read_as, written_as as written_as
from .studies import (
    written_comparison as written_comparison,
    written_fit_validation as written_fit_validation,
    written_law_search as written_law_search,
    written_output_fit as written_output_fit,
    written_sweep as written_sweep,
    written_validation as written_validation,
)
