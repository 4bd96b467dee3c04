"""The pipeline: an axis and a record to estimates that are judged.

In: `Axis`, `Record`, `Prefilter`. Out: `Identification`.
Knows nothing of how it is shown.
"""

from .bound import bound_records as bound_records
from .bound import layout_for as layout_for
from .bound import weighted as weighted
from .identify import check_bad as check_bad
from .identify import identify as identify
from .identify import identify_filtered as identify_filtered
from .identify import identify_problem as identify_problem
from .identify import records_of as records_of
from .result import Identification as Identification
from .several import OfRecord as OfRecord
from .several import RecordInfo as RecordInfo
