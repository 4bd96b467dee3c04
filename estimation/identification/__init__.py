"""The pipeline: an axis and a record to estimates that are judged.

In: `Axis`, `Record`, `Prefilter`. Out: `Identification`.
Knows nothing of how it is shown.
"""

from .bound import (
    bound_records as bound_records,
    layout_for as layout_for,
    tells_gain as tells_gain,
)
from .drive_time import DriveTiming as DriveTiming, check_time as check_time
from .identify import (
    check_choices as check_choices,
    estimate_drive_timing as estimate_drive_timing,
    identify as identify,
    identify_problem as identify_problem,
    records_of as records_of,
    requested_methods as requested_methods,
)
from .result import (
    ByMethod as ByMethod,
    DriveTime as DriveTime,
    HasRecords as HasRecords,
    Identification as Identification,
    RecordInfo as RecordInfo,
    RecordResult as RecordResult,
    record_place as record_place,
)
from .shared import (
    JointRecords as JointRecords,
    check_bad as check_bad,
    layout_without as layout_without,
    shared_records as shared_records,
)
