"""The pipeline: from an axis and a record to checked estimates.

In: `Axis`, `Record`, `Prefilter`. Out: `Identification`.
Knows nothing of how it is shown.
"""

from .drive_delay_estimation import (
    check_drive_time as check_drive_time,
    with_drive_time as with_drive_time,
)
from .identify import (
    check_choices as check_choices,
    identify as identify,
    identify_problem as identify_problem,
    records_of as records_of,
    requested_methods as requested_methods,
)
from .joint_records import (
    JointRecords as JointRecords,
    check_usable as check_usable,
    filtered_records as filtered_records,
    joint_records as joint_records,
    known_of_used as known_of_used,
)
from .result import (
    ByMethod as ByMethod,
    DriveTime as DriveTime,
    HasRecords as HasRecords,
    Identification as Identification,
    RecordInfo as RecordInfo,
    RecordResult as RecordResult,
    record_index as record_index,
)
