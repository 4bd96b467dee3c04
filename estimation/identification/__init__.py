"""The pipeline: an axis and a record to estimates that are judged.

In: `Axis`, `Record`, `Prefilter`. Out: `Identification`.
Knows nothing of how it is shown.
"""

from .bound import bound_records as bound_records
from .bound import layout_for as layout_for
from .bound import tells_gain as tells_gain
from .bound import weighted as weighted
from .by_method import ByMethod as ByMethod
from .drive_time import DriveTiming as DriveTiming
from .drive_time import check_time as check_time
from .drive_timing import estimate_drive_timing as estimate_drive_timing
from .identify import check_choices as check_choices
from .identify import identify as identify
from .identify import identify_problem as identify_problem
from .identify import records_of as records_of
from .identify import requested_methods as requested_methods
from .result import DriveTime as DriveTime
from .result import Identification as Identification
from .set_aside import check_bad as check_bad
from .set_aside import of_used as of_used
from .set_aside import with_what_is_lost as with_what_is_lost
from .several import OfRecord as OfRecord
from .several import RecordInfo as RecordInfo
from .several import record_place as record_place
from .shared import Shared as Shared
from .shared import shared_records as shared_records
